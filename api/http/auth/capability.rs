//! Capability URLs, `/c/{kid}.{expires}.{id}~{tenant}.{signature}/...`: they give access to one job or picture until they
//! expire. Pages need them, since neither `<img>` nor EventSource can send a key, and only a prefix of the path is kept by the
//! relative URLs of deep zoom.
//!
//! The signature is HMAC-SHA256 of the text before it. The first secret in the key file signs and all of them verify, so that
//! secrets can be changed without breaking URLs that are in use.

use super::keys::fill;
use crate::http::problem::{Kind, Problem};
use axum::extract::Request;
use axum::http::{Method, Uri};
use data_encoding::BASE64URL_NOPAD;
use hmac::{Hmac, KeyInit, Mac};
use sha2::Sha256;
use std::borrow::Cow;
use std::io;

/// Prefix of paths with a capability.
pub(crate) const PREFIX: &str = "/c/";
/// Paths that a capability gives access to, each followed by its id.
const PLACES: [&str; 6] = ["/v1/jobs/", "/v1/images/", "/v1/scenes/", "/iiif/3/", "/dzi/", "/xyz/"];

/// Secrets by name; the first one signs.
#[derive(Debug)]
pub(crate) struct Signers(Vec<(String, [u8; 32])>);

impl Signers {
    /// None if there are none.
    pub(crate) fn new(secrets: Vec<(String, [u8; 32])>) -> Option<Self> {
        (!secrets.is_empty()).then_some(Self(secrets))
    }

    /// A random secret, which is forgotten when the process ends.
    pub(crate) fn random() -> io::Result<Self> {
        Ok(Self(vec![("process".into(), random_secret()?)]))
    }

    /// The secret that all fronts of a farm have.
    pub(crate) fn of_farm(secret: [u8; 32]) -> Self {
        Self(vec![("farm".into(), secret)])
    }

    fn mac(secret: &[u8; 32], text: &str) -> Option<Hmac<Sha256>> {
        // HMAC takes keys of any length, so this cannot fail.
        Hmac::<Sha256>::new_from_slice(secret).ok().map(|mac| mac.chain_update(text))
    }

    /// A capability for an id of a tenant. `expires` is in seconds since 1970.
    pub(crate) fn sign(&self, id: &str, tenant: &str, expires: u64) -> String {
        let (kid, secret) = &self.0[0];
        let text = format!("{kid}.{expires}.{id}~{tenant}");
        let tag = Self::mac(secret, &text).map(|mac| mac.finalize().into_bytes()).unwrap_or_default();
        format!("{text}.{}", BASE64URL_NOPAD.encode(&tag))
    }

    /// The id and tenant of a genuine capability, and when it expires.
    pub(crate) fn verify<'c>(&self, capability: &'c str) -> Option<(&'c str, &'c str, u64)> {
        let (text, tag) = capability.rsplit_once('.')?;
        let tag = BASE64URL_NOPAD.decode(tag.as_bytes()).ok()?;
        let mut parts = text.splitn(3, '.');
        let (kid, expires, scope) = (parts.next()?, parts.next()?, parts.next()?);
        let (_, secret) = self.0.iter().find(|(known, _)| known == kid)?;
        Self::mac(secret, text)?.verify_slice(&tag).ok()?;
        let (id, tenant) = scope.split_once('~')?;
        Some((id, tenant, expires.parse().ok()?))
    }
}

/// A new secret.
pub(crate) fn random_secret() -> io::Result<[u8; 32]> {
    let mut secret = [0; 32];
    fill(&mut secret)?;
    Ok(secret)
}

/// The capability that a request came with, in its extensions.
#[derive(Debug, Clone)]
pub(crate) struct Capability {
    /// Its text in the path.
    text: String,
}

impl Capability {
    /// Prefix of links in the answer, so that they work with the same capability.
    pub(crate) fn prefix(&self) -> String {
        format!("{PREFIX}{}", self.text)
    }

    /// The tenant's name, if this request is one that the capability is for.
    pub(crate) fn check(&self, signers: &Signers, request: &Request, now: u64) -> Result<String, Problem> {
        let refused = |detail: &str| Problem::new(Kind::Forbidden, detail);
        let (id, tenant, expires) = signers.verify(&self.text).ok_or_else(|| {
            refused("this capability is not genuine: it was changed on its way, or its secret is no longer in use")
        })?;
        if expires <= now {
            return Err(refused("this capability has expired: ask for a new one at POST /v1/capabilities"));
        }
        if !matches!(*request.method(), Method::GET | Method::HEAD) {
            return Err(refused("a capability is for looking only: GET and HEAD"));
        }
        let path = request.uri().path();
        let about = PLACES.iter().find_map(|place| path.strip_prefix(place)).unwrap_or_default();
        let after = about.strip_prefix(id);
        if after.is_some_and(|rest| rest.is_empty() || rest.starts_with(['/', '.']) || rest.starts_with("_files/")) {
            Ok(tenant.to_owned())
        } else {
            Err(refused(&format!("this capability is for {id} alone")))
        }
    }
}

/// Removes a capability from the path, before routing.
pub(crate) fn strip<B>(mut request: axum::http::Request<B>) -> axum::http::Request<B> {
    let taken = request.uri().path_and_query().and_then(|all| {
        let (text, rest) = all.as_str().strip_prefix(PREFIX)?.split_once('/')?;
        Some((text.to_owned(), format!("/{rest}").parse::<Uri>().ok()?))
    });
    if let Some((text, uri)) = taken {
        *request.uri_mut() = uri;
        request.extensions_mut().insert(Capability { text });
    }
    request
}

/// A path for the log: without capabilities that were not taken off it, since they lead nowhere. They may still be valid.
pub(crate) fn hidden(path: &str) -> Cow<'_, str> {
    match path.split_once(PREFIX) {
        Some((before, _)) => format!("{before}{PREFIX}...").into(),
        None => path.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn request(method: Method, path: &str) -> Request {
        Request::builder().method(method).uri(path).body(axum::body::Body::empty()).unwrap()
    }

    #[test]
    fn a_capability_opens_its_own_thing_and_nothing_else() {
        let signers = Signers::new(vec![("k1".into(), [7; 32])]).unwrap();
        let text = signers.sign("i_abc", "acme", 1_000);
        let opens = |method, path: &str, now| {
            let stripped = strip(request(method, &format!("/c/{text}{path}")));
            assert!(stripped.uri().path().starts_with("/v1") || !path.starts_with("/v1"));
            let capability = stripped.extensions().get::<Capability>().unwrap().clone();
            capability.check(&signers, &stripped, now).ok()
        };
        for path in
            ["/iiif/3/i_abc/info.json", "/v1/images/i_abc.png?x=1", "/dzi/i_abc_files/9/0_0.png", "/v1/jobs/i_abc"]
        {
            assert_eq!(opens(Method::GET, path, 999).as_deref(), Some("acme"), "{path}");
        }
        for path in ["/v1/jobs", "/v1/images/i_abcd.png", "/v1/images/other/i_abc", "/v1/limits", "/c/x/v1/jobs/i_abc"]
        {
            assert_eq!(opens(Method::GET, path, 999), None, "{path}");
        }
        assert_eq!(opens(Method::POST, "/v1/jobs/i_abc/cancel", 999), None);
        assert_eq!(opens(Method::GET, "/v1/jobs/i_abc", 1_000), None, "it has expired");
    }

    #[test]
    fn only_the_secrets_in_use_verify() {
        let old = ("old".to_owned(), [1; 32]);
        let new = ("new".to_owned(), [2; 32]);
        let signed = Signers::new(vec![old.clone()]).unwrap().sign("j", "t", 5);
        let both = Signers::new(vec![new.clone(), old]).unwrap();
        assert_eq!(both.verify(&signed), Some(("j", "t", 5)));
        assert!(both.sign("j", "t", 5).starts_with("new."));
        assert_eq!(Signers::new(vec![new]).unwrap().verify(&signed), None);
        for (from, to) in [(".5.", ".6."), ("j~", "k~"), ("~t", "~u")] {
            assert_eq!(both.verify(&signed.replacen(from, to, 1)), None, "{from}");
        }
    }
}
