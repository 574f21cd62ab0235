//! Settings of the farm: where the broker and the store are. `serve`, `node`, `tile` and `frame` share them.

use crate::service::error::StartError;
use crate::service::values::seconds;
use async_nats::ServerAddr;
use clap::{Args, value_parser};
use std::fmt;
use std::path::PathBuf;
use std::time::Duration;

/// Addresses of brokers and of the store.
#[derive(Debug, Clone, Args)]
#[group(skip)]
#[command(next_help_heading = "Farm")]
pub(crate) struct FarmSettings {
    /// Addresses of the farm's NATS servers between commas, such as nats://user:password@broker:4222, or tls:// to encrypt.
    /// With it, nodes render what is asked of the service; without it the service renders itself.
    #[arg(long, env = "STRAHL_FARM", value_name = "URL,...", value_parser = Servers::read, requires = "store", hide_env_values = true)]
    pub(crate) farm: Option<Servers>,
    /// File of credentials for the broker: a seed, as `strahl farm accounts` writes it, or a JWT and its seed, as nsc does.
    #[arg(long, env = "STRAHL_FARM_CREDENTIALS", value_name = "FILE", requires = "farm")]
    pub(crate) farm_credentials: Option<PathBuf>,
    /// File of certificates, as PEM, that the broker's is checked with [default: those of the system].
    #[arg(long, env = "STRAHL_FARM_CA", value_name = "FILE", requires = "farm")]
    pub(crate) farm_ca: Option<PathBuf>,
    /// First part of the subjects on which the broker answers this process. Accounts that keep nodes from reading each
    /// other's answers give each its own.
    #[arg(long, env = "STRAHL_FARM_INBOX", value_name = "SUBJECT", default_value = "_INBOX", value_parser = inbox)]
    pub(crate) farm_inbox: String,
    /// How many servers keep each message: 3 survive the loss of one.
    #[arg(long, env = "STRAHL_FARM_REPLICAS", value_name = "SERVERS", default_value_t = 1, value_parser = value_parser!(u64).range(1..=5))]
    pub(crate) farm_replicas: u64,
    /// Seconds after which work goes to another node if its own does not get on with it.
    #[arg(long, env = "STRAHL_FARM_LEASE", value_name = "SECONDS", default_value = "15", value_parser = seconds)]
    pub(crate) farm_lease: Duration,
    /// Where scenes and pictures of the farm are, and pictures of jobs that ask for it: a folder that all its machines see, or
    /// s3://BUCKET/PREFIX, with AWS_ENDPOINT_URL, AWS_REGION, AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY of the environment.
    #[arg(long, env = "STRAHL_STORE", value_name = "DIR|s3://BUCKET/PREFIX")]
    pub(crate) store: Option<String>,
}

/// The addresses of brokers, and the user and password in them.
#[derive(Clone)]
pub(crate) struct Servers {
    /// Without users and passwords.
    pub(super) addresses: Vec<ServerAddr>,
    /// The client library does not send those of an address.
    pub(super) login: Option<(String, String)>,
}

impl Servers {
    fn read(text: &str) -> Result<Self, String> {
        let (mut addresses, mut login) = (Vec::new(), None);
        for part in text.split(',').map(str::trim) {
            let wrong = || "expected addresses such as nats://127.0.0.1:4222 or tls://broker.example.org".to_owned();
            let (scheme, rest) = part.split_once("://").ok_or_else(wrong)?;
            let (user, host) = rest.rsplit_once('@').map_or((None, rest), |(user, host)| (Some(user), host));
            if !matches!(scheme, "nats" | "tls") || host.is_empty() {
                return Err(wrong());
            }
            if let Some(user) = user {
                let pair = user.split_once(':').ok_or("expected nats://user:password@host")?;
                login.get_or_insert((pair.0.to_owned(), pair.1.to_owned()));
            }
            addresses.push(format!("{scheme}://{host}").parse().map_err(|_| wrong())?);
        }
        Ok(Self { addresses, login })
    }

    /// Whether all that is sent is encrypted.
    pub(super) fn need_tls(&self) -> bool {
        self.addresses.iter().any(ServerAddr::tls_required)
    }
}

impl fmt::Display for Servers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let all: Vec<_> = self.addresses.iter().map(|address| address.as_url_str().trim_end_matches('/')).collect();
        f.write_str(&all.join(","))
    }
}

/// Passwords do not get into logs.
impl fmt::Debug for Servers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl FarmSettings {
    /// Refuses what a file cannot be read for, before anything is started.
    pub(super) fn credentials(&self) -> Result<Option<String>, StartError> {
        let Some(path) = &self.farm_credentials else { return Ok(None) };
        let text = std::fs::read_to_string(path);
        text.map(Some).map_err(|error| StartError::Settings(format!("--farm-credentials {}: {error}", path.display())))
    }
}

/// A prefix of subjects.
fn inbox(text: &str) -> Result<String, &'static str> {
    let is_token =
        |token: &str| !token.is_empty() && token.bytes().all(|b| b.is_ascii_alphanumeric() || b"_-".contains(&b));
    match text.split('.').all(is_token) {
        true => Ok(text.to_owned()),
        false => Err("expected letters, digits, _ and -, with dots between, such as _INBOX.node7"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_read_without_their_passwords() {
        let servers = Servers::read("nats://me:se:cret@a:4222, nats://b").unwrap();
        assert_eq!(servers.to_string(), "nats://a:4222,nats://b");
        assert_eq!(servers.login, Some(("me".to_owned(), "se:cret".to_owned())));
        assert!(!format!("{servers:?}").contains("cret") && !servers.need_tls());
        assert!(Servers::read("tls://a").unwrap().need_tls());
        for wrong in ["", "a:4222", "http://a", "nats://", "nats://a,", "nats://me@a"] {
            assert!(Servers::read(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn an_inbox_is_no_wildcard() {
        assert!(inbox("_INBOX").is_ok() && inbox("_INBOX.node-7").is_ok());
        assert!(["", "a.", "a.*", ">", "a b"].iter().all(|wrong| inbox(wrong).is_err()));
    }
}
