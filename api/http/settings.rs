//! Settings of the connections: addresses, keys, and what one connection may take.

use super::host::Host;
use crate::service::values::{as_seconds, seconds};
use axum::http::{HeaderMap, HeaderValue, header};
use clap::{Args, value_parser};
use schemars::JsonSchema;
use serde::Serialize;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::Duration;

/// Addresses, keys and origins.
#[derive(Debug, Clone, Args)]
#[group(skip)]
#[command(next_help_heading = "Network and keys")]
pub(crate) struct HttpSettings {
    /// Address and port to listen on; port 0 takes a free one. An address that other machines can reach needs --keys or
    /// --insecure-no-auth.
    #[arg(long, env = "STRAHL_LISTEN", value_name = "ADDRESS:PORT", default_value = "127.0.0.1:8080", value_parser = address)]
    pub(crate) listen: SocketAddr,
    /// Address and port of the admin listener, which needs no keys: /livez, /readyz, /metrics. Usual is 127.0.0.1:9090;
    /// clients that can reach another address can read the metrics. Without this flag there is no admin listener, and
    /// /metrics is not served; /livez and /readyz are answered on --listen, too.
    #[arg(long, env = "STRAHL_ADMIN_LISTEN", value_name = "ADDRESS:PORT", value_parser = address)]
    pub(crate) admin_listen: Option<SocketAddr>,
    /// File of API keys, as `strahl key new` makes them. The service reads it again when it changes. Without it requests
    /// need no key.
    #[arg(long, env = "STRAHL_KEYS", value_name = "FILE")]
    pub(crate) keys: Option<PathBuf>,
    /// Accept requests from other machines without keys.
    #[arg(long, env = "STRAHL_INSECURE_NO_AUTH", conflicts_with = "keys")]
    pub(crate) insecure_no_auth: bool,
    /// Web pages that may use the service from a browser: * for all, loopback for those of this machine, none, or origins
    /// between commas [default: * with --keys, loopback without].
    #[arg(long, env = "STRAHL_CORS_ORIGIN", value_name = "ORIGINS", value_parser = Origins::read)]
    pub(crate) cors_origin: Option<Origins>,
    /// Address under which clients see the service, such as https://render.example.org, for the addresses in IIIF answers
    /// [default: http:// and the request's Host]. Without --keys the service answers only to localhost, to its own address
    /// and to this one.
    #[arg(long, env = "STRAHL_PUBLIC_URL", value_name = "URL", value_parser = public_url)]
    pub(crate) public_url: Option<String>,
    /// Open connections. One more takes the place of one that has no request; if all have one, it waits.
    #[arg(long, env = "STRAHL_MAX_CONNECTIONS", default_value_t = 2_048, value_parser = value_parser!(u32).range(1..=1_000_000))]
    pub(crate) max_connections: u32,
    /// Open connections of one address, or of one network of 64 bits with IPv6. One more takes the place of one that has no
    /// request; if all have one, it is closed [default: a quarter of --max-connections; loopback addresses may have all].
    #[arg(long, env = "STRAHL_CLIENT_CONNECTIONS", value_name = "CONNECTIONS", value_parser = value_parser!(u32).range(1..=1_000_000))]
    pub(crate) client_connections: Option<u32>,
    /// Seconds that running requests have to finish after SIGTERM or Ctrl-C.
    #[arg(long, env = "STRAHL_DRAIN_TIMEOUT", value_name = "SECONDS", default_value = "20", value_parser = seconds)]
    pub(crate) drain_timeout: Duration,
    /// Do not serve the studio, the page at /studio.
    #[arg(long, env = "STRAHL_NO_STUDIO", conflicts_with = "studio_files")]
    pub(crate) no_studio: bool,
    /// Folder to read the studio's files from at each request, for people who change it [default: those in the program].
    #[arg(long, env = "STRAHL_STUDIO_FILES", value_name = "DIR")]
    pub(crate) studio_files: Option<PathBuf>,
    /// What one connection may take.
    #[command(flatten)]
    pub(crate) limits: ConnectionLimits,
}

impl HttpSettings {
    /// Origins that may use the service. Without keys nothing else keeps pages of other sites out.
    pub(crate) fn origins(&self) -> Origins {
        let default = if self.keys.is_some() { Origins::Any } else { Origins::Loopback };
        self.cors_origin.clone().unwrap_or(default)
    }

    /// Where the files of the studio are. Fails if there is no such folder.
    pub(crate) fn studio(&self) -> Result<Studio, String> {
        match &self.studio_files {
            _ if self.no_studio => Ok(Studio::Off),
            Some(folder) if folder.is_dir() => Ok(Studio::Folder(folder.clone())),
            Some(folder) => Err(format!("--studio-files {}: there is no such folder", folder.display())),
            None => Ok(Studio::Embedded),
        }
    }
}

/// An address to listen on.
pub(crate) fn address(text: &str) -> Result<SocketAddr, String> {
    text.parse()
        .map_err(|_| "expected an IP address and a port, such as 127.0.0.1:8080; names are not looked up".to_owned())
}

/// Where the files of the studio are.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Studio {
    /// In the program.
    Embedded,
    /// In a folder.
    Folder(PathBuf),
    /// The service has no studio.
    Off,
}

/// What one connection may take.
#[derive(Debug, Clone, Args, Serialize, JsonSchema)]
#[group(skip)]
#[command(next_help_heading = "Limits of one request")]
pub(crate) struct ConnectionLimits {
    /// Bytes of a request body.
    #[arg(long, env = "STRAHL_MAX_BODY_BYTES", value_name = "BYTES", default_value_t = 64 << 20, value_parser = value_parser!(u64).range(1..=1 << 32))]
    pub(crate) max_body_bytes: u64,
    /// Tiles that one client may ask for at one time; one more is answered with 429. A client is an address of a tenant, so
    /// a proxy that many use needs more.
    #[arg(long, env = "STRAHL_CLIENT_TILES", value_name = "TILES", default_value_t = 64, value_parser = value_parser!(u32).range(1..=100_000))]
    pub(crate) client_tiles: u32,
    /// Seconds a client may take to send a request's headers. A connection without requests is closed after as long: proxies that
    /// keep connections need less, or some requests meet one that closes.
    #[arg(long, env = "STRAHL_HEADER_TIMEOUT", value_name = "SECONDS", default_value = "10", value_parser = seconds)]
    #[serde(rename = "header_timeout_s", serialize_with = "as_seconds")]
    #[schemars(with = "f64")]
    pub(crate) header_timeout: Duration,
    /// Seconds a client may take to send a request's body.
    #[arg(long, env = "STRAHL_BODY_TIMEOUT", value_name = "SECONDS", default_value = "30", value_parser = seconds)]
    #[serde(rename = "body_timeout_s", serialize_with = "as_seconds")]
    #[schemars(with = "f64")]
    pub(crate) body_timeout: Duration,
    /// Seconds a client may stop reading its answer.
    #[arg(long, env = "STRAHL_WRITE_TIMEOUT", value_name = "SECONDS", default_value = "30", value_parser = seconds)]
    #[serde(rename = "write_timeout_s", serialize_with = "as_seconds")]
    #[schemars(with = "f64")]
    pub(crate) write_timeout: Duration,
}

/// Parses the address under which clients see the service.
fn public_url(text: &str) -> Result<String, &'static str> {
    // Paths are put behind it.
    match Host::of_url(text).is_some() && text.bytes().all(|byte| byte.is_ascii_graphic() && !b"?#".contains(&byte)) {
        true => Ok(text.trim_end_matches('/').to_owned()),
        false => Err("expected an address such as https://render.example.org, without ? and #"),
    }
}

/// Origins whose pages may use the service.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Origins {
    /// All origins.
    Any,
    /// Those of this machine.
    Loopback,
    /// Some origins, such as `https://example.org`, or none.
    Listed(Vec<String>),
}

impl Origins {
    /// From the command line: `*`, `loopback`, `none`, or origins between commas.
    pub(crate) fn read(text: &str) -> Result<Self, &'static str> {
        match text.trim() {
            "*" => Ok(Self::Any),
            "loopback" => Ok(Self::Loopback),
            "none" => Ok(Self::Listed(Vec::new())),
            list => {
                let origins: Vec<_> = list.split(',').map(|origin| origin.trim().to_owned()).collect();
                let sound = |origin: &String| {
                    let host = origin.strip_prefix("https://").or_else(|| origin.strip_prefix("http://"));
                    host.is_some_and(|host| !host.is_empty() && host.bytes().all(|b| b.is_ascii_graphic() && b != b'/'))
                };
                let wrong = "expected *, loopback, none, or origins such as https://example.org, separated by commas";
                origins.iter().all(sound).then_some(Self::Listed(origins)).ok_or(wrong)
            }
        }
    }

    /// The value of `Access-Control-Allow-Origin` for a request.
    pub(crate) fn allowed(&self, headers: &HeaderMap) -> Option<HeaderValue> {
        let origin = headers.get(header::ORIGIN);
        let is_loopback =
            |origin: &&HeaderValue| origin.to_str().ok().and_then(Host::of_url).is_some_and(|host| host.is_loopback());
        match self {
            Self::Any => Some(HeaderValue::from_static("*")),
            Self::Loopback => origin.filter(is_loopback).cloned(),
            Self::Listed(known) => origin.filter(|origin| known.iter().any(|known| known == *origin)).cloned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn origins_are_read_and_matched_exactly() {
        let of = |origin: &'static str| HeaderMap::from_iter([(header::ORIGIN, HeaderValue::from_static(origin))]);
        let listed = Origins::read("https://a.org, http://localhost:3000").unwrap();
        assert_eq!(listed.allowed(&of("https://a.org")).unwrap(), "https://a.org");
        assert_eq!(listed.allowed(&of("https://a.org.evil")), None);
        assert_eq!(listed.allowed(&HeaderMap::new()), None);
        assert_eq!(Origins::read("*").unwrap().allowed(&HeaderMap::new()).unwrap(), "*");
        assert_eq!(Origins::read("none").unwrap().allowed(&of("https://a.org")), None);
        let loopback = Origins::read("loopback").unwrap();
        for (origin, is_known) in [
            ("http://localhost:3000", true),
            ("https://127.0.0.1", true),
            ("http://[::1]:8080", true),
            ("http://localhost.evil.example", false),
            ("http://evil.example/localhost", false),
            ("null", false),
        ] {
            assert_eq!(loopback.allowed(&of(origin)).is_some(), is_known, "{origin}");
        }
        for wrong in ["", "a.org", "https://", "https://a.org/", "https://a.org, *"] {
            assert!(Origins::read(wrong).is_err(), "{wrong}");
        }
    }
}
