//! Signatures of messages as Standard Webhooks describes them (www.standardwebhooks.com): HMAC-SHA256 over id, time and body,
//! so that a receiver knows who sent a message, when, and that nobody changed it.

use data_encoding::BASE64;
use hmac::{Hmac, KeyInit, Mac};
use sha2::Sha256;
use std::fmt;
use std::str::FromStr;

/// What secrets begin with.
const PREFIX: &str = "whsec_";
/// Bytes that a secret may have.
const BYTES: std::ops::RangeInclusive<usize> = 24..=64;

/// The secret that a tenant and its receiver share.
#[derive(Clone, PartialEq, Eq)]
pub(crate) struct Secret(Vec<u8>);

impl Secret {
    /// A secret of these bytes.
    pub(crate) fn of(bytes: &[u8; 32]) -> Self {
        Self(bytes.to_vec())
    }

    /// As key files have it.
    pub(crate) fn text(&self) -> String {
        format!("{PREFIX}{}", BASE64.encode(&self.0))
    }

    /// The header `webhook-signature` of a message.
    pub(crate) fn sign(&self, id: &str, seconds: u64, body: &str) -> String {
        // HMAC takes keys of any length, so this cannot fail.
        let mac = Hmac::<Sha256>::new_from_slice(&self.0).ok();
        let mac = mac.map(|mac| mac.chain_update(format!("{id}.{seconds}.")).chain_update(body).finalize());
        format!("v1,{}", mac.map(|mac| BASE64.encode(&mac.into_bytes())).unwrap_or_default())
    }
}

impl FromStr for Secret {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let bytes = text.strip_prefix(PREFIX).and_then(|rest| BASE64.decode(rest.as_bytes()).ok());
        let is_long_enough = |bytes: &Vec<u8>| BYTES.contains(&bytes.len());
        bytes
            .filter(is_long_enough)
            .map(Self)
            .ok_or("expected whsec_ and 24 to 64 bytes in base64, as `strahl key webhook` makes them")
    }
}

/// Secrets do not get into logs.
impl fmt::Debug for Secret {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Secret")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The example of the specification.
    #[test]
    fn signatures_are_those_of_the_specification() {
        let secret: Secret = "whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw".parse().unwrap();
        let body = r#"{"test": 2432232314}"#;
        let signature = secret.sign("msg_p5jXN8AQM9LWM0D4loKWxJek", 1_614_265_330, body);
        assert_eq!(signature, "v1,g0hM9SsE+OTPJTGt/tmIKtSyZlE3uFJELVlNIOLJ1OE=");
        assert_ne!(secret.sign("msg_p5jXN8AQM9LWM0D4loKWxJek", 1_614_265_331, body), signature);
    }

    #[test]
    fn secrets_are_read_as_they_are_written() {
        let secret = Secret::of(&[7; 32]);
        assert_eq!(secret.text().parse(), Ok(secret.clone()));
        assert!(!format!("{secret:?}").contains("Bw"));
        for wrong in ["", "whsec_", "MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw", "whsec_c2hvcnQ=", "whsec_%%%"] {
            assert!(wrong.parse::<Secret>().is_err(), "{wrong}");
        }
    }
}
