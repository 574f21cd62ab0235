//! `strahl healthcheck`: asks a running service whether it is alive. It needs no shell and no HTTP library, so a
//! container can run it.

use super::failure::Failure;
use clap::Args;
use std::io::{self, Read, Write};
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, TcpStream, ToSocketAddrs};
use std::path::PathBuf;
use std::time::Duration;

/// `strahl healthcheck`. It reads the same environment variables and configuration file as the service.
#[derive(Debug, Args)]
#[command(after_help = "\
Ask on the listener for operators if there is one: on that for clients, a crowd of them may take all connections.")]
pub(super) struct HealthcheckArgs {
    /// Configuration file of the service, which says where it listens.
    #[arg(long, env = "STRAHL_CONFIG", value_name = "FILE.toml")]
    config: Option<PathBuf>,
    /// What to ask [default: /livez on the listener for operators, or else on that for clients].
    #[arg(long, env = "STRAHL_HEALTHCHECK_URL")]
    url: Option<String>,
    /// Where the service listens for operators.
    #[arg(long, env = "STRAHL_ADMIN_LISTEN", value_name = "ADDRESS:PORT")]
    admin_listen: Option<SocketAddr>,
    /// Where the service listens for clients.
    #[arg(long, env = "STRAHL_LISTEN", value_name = "ADDRESS:PORT", default_value = "127.0.0.1:8080")]
    listen: SocketAddr,
}

const PATIENCE: Duration = Duration::from_secs(3);

/// Fails if the service does.
pub(super) fn run(args: &HealthcheckArgs) -> Result<(), Failure> {
    let url = args.url.clone().unwrap_or_else(|| {
        let listener = args.admin_listen.unwrap_or(args.listen);
        format!("http://{}/livez", reachable(listener))
    });
    let (authority, path) = split(&url)?;
    let status = get(&authority, path).map_err(|error| Failure::Input(format!("{url} does not answer: {error}")))?;
    if status.starts_with("HTTP/1.1 200") {
        Ok(())
    } else {
        Err(Failure::Input(format!("{url} answers \"{}\"", status.trim_end())))
    }
}

/// A listener on all addresses is asked on the loopback address.
fn reachable(mut listener: SocketAddr) -> SocketAddr {
    if listener.ip().is_unspecified() {
        let own: IpAddr = if listener.is_ipv4() { Ipv4Addr::LOCALHOST.into() } else { Ipv6Addr::LOCALHOST.into() };
        listener.set_ip(own);
    }
    listener
}

/// Host with port, and path.
fn split(url: &str) -> Result<(String, &str), Failure> {
    let rest = url
        .strip_prefix("http://")
        .ok_or_else(|| Failure::Usage(format!("--url {url} does not start with http://")))?;
    let slash = rest.find('/').unwrap_or(rest.len());
    let (authority, path) = rest.split_at(slash);
    let has_port = authority.rsplit_once(':').is_some_and(|(_, port)| port.parse::<u16>().is_ok());
    let authority = if has_port { authority.to_owned() } else { format!("{authority}:80") };
    Ok((authority, if path.is_empty() { "/livez" } else { path }))
}

/// The status line of the answer.
fn get(authority: &str, path: &str) -> io::Result<String> {
    let address = authority.to_socket_addrs()?.next().ok_or(io::ErrorKind::AddrNotAvailable)?;
    let mut stream = TcpStream::connect_timeout(&address, PATIENCE)?;
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    write!(stream, "GET {path} HTTP/1.1\r\nHost: {authority}\r\nConnection: close\r\n\r\n")?;
    let mut answer = String::new();
    stream.take(4_096).read_to_string(&mut answer)?;
    Ok(answer.lines().next().unwrap_or("nothing").to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_addresses_are_asked_on_loopback() {
        for (listener, asked) in [("0.0.0.0:1", "127.0.0.1:1"), ("[::]:2", "[::1]:2"), ("10.0.0.1:3", "10.0.0.1:3")] {
            assert_eq!(reachable(listener.parse().unwrap()).to_string(), asked);
        }
    }

    #[test]
    fn urls_are_split() {
        assert_eq!(split("http://127.0.0.1:8080/livez").unwrap(), ("127.0.0.1:8080".into(), "/livez"));
        assert_eq!(split("http://[::1]:81").unwrap(), ("[::1]:81".into(), "/livez"));
        assert_eq!(split("http://box/readyz").unwrap(), ("box:80".into(), "/readyz"));
        assert!(split("https://box/").is_err());
    }
}
