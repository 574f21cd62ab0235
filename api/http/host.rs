//! The host of a request (RFC 9112 section 3.2): the name or address by which a client reaches the service.

use std::fmt::{self, Display};
use std::net::{IpAddr, Ipv6Addr};

/// A name or an address, with or without a port. All its characters are allowed in URLs and headers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Host {
    name: String,
    /// With its colon.
    port: String,
}

impl Host {
    /// Parses a host.
    pub(crate) fn read(text: &str) -> Option<Self> {
        let end = if text.starts_with('[') { text.find(']')? + 1 } else { text.find(':').unwrap_or(text.len()) };
        let (name, port) = text.split_at(end);
        let is_name = match name.strip_prefix('[') {
            Some(rest) => rest.strip_suffix(']').is_some_and(|address| address.parse::<Ipv6Addr>().is_ok()),
            None => {
                (1..=255).contains(&name.len())
                    && name.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"-._".contains(&byte))
            }
        };
        let is_port = match port.strip_prefix(':') {
            Some(digits) => {
                digits.bytes().all(|byte| byte.is_ascii_digit()) && (digits.is_empty() || digits.parse::<u16>().is_ok())
            }
            None => port.is_empty(),
        };
        (is_name && is_port).then(|| Self { name: name.to_ascii_lowercase(), port: port.to_owned() })
    }

    /// The host in an address that begins with `http://` or `https://`.
    pub(crate) fn of_url(url: &str) -> Option<Self> {
        let rest = url.strip_prefix("https://").or_else(|| url.strip_prefix("http://"))?;
        Self::read(rest.split('/').next()?)
    }

    /// Whether it has that name, whatever the ports.
    pub(crate) fn has_name_of(&self, other: &Self) -> bool {
        self.name == other.name
    }

    /// The address, if it is no name.
    pub(crate) fn address(&self) -> Option<IpAddr> {
        let text = self.name.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')).unwrap_or(&self.name);
        text.parse().ok().map(|address: IpAddr| address.to_canonical())
    }

    /// Whether it can only mean the machine that the client runs on.
    pub(crate) fn is_loopback(&self) -> bool {
        self.name == "localhost" || self.address().is_some_and(|address| address.is_loopback())
    }
}

impl Display for Host {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", self.name, self.port)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hosts_are_names_or_addresses_with_or_without_a_port() {
        for text in ["a", "example.org", "a-b_c.d:80", "127.0.0.1:8080", "[::1]", "[::1]:0", "a:"] {
            assert_eq!(Host::read(text).map(|host| host.to_string()).as_deref(), Some(text));
        }
        assert_eq!(Host::read("LocalHost:1").unwrap().to_string(), "localhost:1");
        for text in [
            "",
            ":80",
            "a b",
            "a>",
            "a/b",
            "a@b",
            "a:b",
            "a:+1",
            "a:99999",
            "a:1:2",
            "[",
            "[]",
            "[::1]x",
            "[::1",
            "::1",
            "ä",
            "a,b",
            "x>; rel=\"x\", <http://evil",
            &"a".repeat(256),
        ] {
            assert_eq!(Host::read(text), None, "{text}");
        }
        assert_eq!(Host::of_url("https://a.org:1/x").unwrap().to_string(), "a.org:1");
        assert_eq!([Host::of_url("ftp://a.org"), Host::of_url("null"), Host::of_url("http://")], [None, None, None]);
    }

    #[test]
    fn loopback_is_this_machine_and_nothing_that_looks_like_it() {
        let is_loopback = |text: &str| Host::read(text).unwrap().is_loopback();
        for text in ["localhost", "LOCALHOST:3000", "127.0.0.1:8080", "127.1.2.3", "[::1]:8080", "[::ffff:127.0.0.1]"] {
            assert!(is_loopback(text), "{text}");
        }
        for text in ["evil.example", "localhost.evil.example", "127.0.0.1.evil.example", "10.0.0.1", "[::2]", "0.0.0.0"]
        {
            assert!(!is_loopback(text), "{text}");
        }
        assert!(Host::read("a.org:80").unwrap().has_name_of(&Host::read("A.org").unwrap()));
    }
}
