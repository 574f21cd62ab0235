//! API keys, `rk_<id>_<secret>`, and the file that lists them with their tenants. The file contains hashes, never keys.

use super::capability::Signers;
use super::rate_limit::RateLimit;
use super::tenant::{Quotas, Scope, Tenant, TenantWebhook};
use crate::service::deliveries::receiver::read_url;
use crate::service::deliveries::signature::Secret;
use crate::service::{ANONYMOUS, is_tenant_name};
use data_encoding::{BASE32_NOPAD, HEXLOWER};
use serde::Deserialize;
use sha2::{Digest, Sha256};
use std::collections::{BTreeMap, HashMap};
use std::fmt;
use std::io;
use std::sync::Arc;
use subtle::ConstantTimeEq;

/// Bytes of a key's secret.
const SECRET_BYTES: usize = 32;
/// Bytes of a key's id.
const ID_BYTES: usize = 5;

/// The contents of the key file.
#[derive(Debug)]
pub(crate) struct Keys {
    by_id: HashMap<String, Key>,
    /// Each tenant as it may act through a capability.
    readers: HashMap<String, Arc<Tenant>>,
    /// Secrets that sign capabilities, if the file has any.
    pub(crate) signers: Option<Signers>,
}

#[derive(Debug)]
struct Key {
    sha256: [u8; 32],
    tenant: Arc<Tenant>,
}

/// The file: TOML.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default)]
    tenants: BTreeMap<String, TenantEntry>,
    #[serde(default)]
    keys: Vec<KeyEntry>,
    #[serde(default)]
    signers: Vec<SignerEntry>,
}

#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct TenantEntry {
    weight: Option<u32>,
    units_per_minute: Option<u32>,
    jobs: Option<u32>,
    streams: Option<u32>,
    webhook: Option<String>,
    webhook_secret: Option<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct KeyEntry {
    id: String,
    tenant: String,
    scopes: Vec<Scope>,
    sha256: String,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SignerEntry {
    kid: String,
    secret: String,
}

impl Keys {
    /// Reads the text of a key file. Tenants that were in it `before` keep the state of their rate limits.
    pub(crate) fn read(text: &str, before: Option<&Self>) -> Result<Self, String> {
        let File { tenants, keys, signers } = toml::from_str(text).map_err(|error| error.to_string())?;
        let mut readers = HashMap::new();
        let names = tenants.keys().chain(keys.iter().map(|key| &key.tenant));
        for name in names {
            check_name("tenant", name)?;
            if name == ANONYMOUS {
                return Err(format!("no tenant can be called {ANONYMOUS}: that is everybody where there are no keys"));
            }
            let entry = tenants.get(name).cloned().unwrap_or_default();
            let before = before.and_then(|before| before.readers.get(name)).map(Arc::as_ref);
            let reader = reader(name, &entry, before)?;
            readers.entry(name.clone()).or_insert_with(|| Arc::new(reader));
        }
        let mut by_id = HashMap::new();
        for KeyEntry { id, tenant, scopes, sha256 } in keys {
            check_name("key id", &id)?;
            if scopes.is_empty() {
                return Err(format!("the key {id} has no scopes; there are render, jobs, read and admin"));
            }
            let sha256 = HEXLOWER.decode(sha256.to_ascii_lowercase().as_bytes()).ok().and_then(|s| s.try_into().ok());
            let sha256 = sha256.ok_or_else(|| format!("sha256 of the key {id} is not 64 hexadecimal digits"))?;
            let tenant = Arc::new(Tenant { scopes, ..Tenant::clone(&readers[&tenant]) });
            if by_id.insert(id.clone(), Key { sha256, tenant }).is_some() {
                return Err(format!("the key id {id} is there twice"));
            }
        }
        let signers = signers.into_iter().map(|SignerEntry { kid, secret }| {
            check_name("kid", &kid)?;
            let secret =
                secret_of(&secret).ok_or_else(|| format!("the secret of {kid} is not one of `strahl key signer`"))?;
            Ok((kid, secret))
        });
        let signers = signers.collect::<Result<Vec<_>, String>>()?;
        Ok(Self { by_id, readers, signers: Signers::new(signers) })
    }

    /// Whether there are none.
    pub(crate) fn is_empty(&self) -> bool {
        self.by_id.is_empty()
    }

    /// The tenant of a key.
    pub(crate) fn tenant(&self, presented: &str) -> Option<Arc<Tenant>> {
        let (id, _) = presented.strip_prefix("rk_")?.split_once('_')?;
        let key = self.by_id.get(id)?;
        let same = Sha256::digest(presented).as_slice().ct_eq(&key.sha256);
        bool::from(same).then(|| Arc::clone(&key.tenant))
    }

    /// Tenants that have a rate limit.
    pub(crate) fn limited(&self) -> impl Iterator<Item = (&str, &RateLimit)> {
        self.readers.iter().filter_map(|(name, tenant)| Some((name.as_str(), tenant.rate_limit.as_deref()?)))
    }

    /// A tenant as it may act through a capability: read-only.
    pub(crate) fn reader(&self, tenant: &str) -> Option<Arc<Tenant>> {
        self.readers.get(tenant).map(Arc::clone)
    }
}

fn reader(name: &str, entry: &TenantEntry, before: Option<&Tenant>) -> Result<Tenant, String> {
    let wrong = |why| format!("webhook_secret of the tenant {name}: {why}");
    let secret = entry.webhook_secret.as_deref().map(str::parse::<Secret>).transpose().map_err(wrong)?;
    if entry.webhook.is_some() && secret.is_none() {
        return Err(format!("the tenant {name} has a webhook but no webhook_secret: `strahl key webhook` makes one"));
    }
    if let Some(Err(why)) = entry.webhook.as_deref().map(read_url) {
        return Err(format!("webhook of the tenant {name}: {why}"));
    }
    if entry.units_per_minute == Some(0) {
        return Err(format!(
            "units_per_minute of the tenant {name} must be at least 1; remove its keys to keep it out"
        ));
    }
    if entry.weight == Some(0) {
        return Err(format!("weight of the tenant {name} must be at least 1: it is the tenant's share beside others"));
    }
    let quotas = Quotas::default();
    let same = |rate_limit: &&Arc<RateLimit>| Some(rate_limit.per_minute) == entry.units_per_minute;
    let kept = before.and_then(|tenant| tenant.rate_limit.as_ref()).filter(same).map(Arc::clone);
    let fresh = || entry.units_per_minute.map(|units| Arc::new(RateLimit::new(units)));
    Ok(Tenant {
        name: name.to_owned(),
        weight: entry.weight.unwrap_or(1),
        scopes: vec![Scope::Read],
        quotas: Quotas { jobs: entry.jobs.unwrap_or(quotas.jobs), streams: entry.streams.unwrap_or(quotas.streams) },
        rate_limit: kept.or_else(fresh),
        webhook: TenantWebhook { url: entry.webhook.clone(), secret },
    })
}

/// Ids of keys are like names of tenants.
fn check_name(what: &str, name: &str) -> Result<(), String> {
    if is_tenant_name(name) {
        Ok(())
    } else {
        Err(format!("the {what} \"{name}\" must have 1 to 64 letters, digits and -"))
    }
}

/// A new key, and its lines for the key file.
pub(crate) fn new_key(tenant: &str, scopes: &[Scope]) -> io::Result<(String, String)> {
    check_name("tenant", tenant).map_err(io::Error::other)?;
    let id = random::<ID_BYTES>()?;
    let key = format!("rk_{id}_{}", random::<SECRET_BYTES>()?);
    let scopes: Vec<_> = scopes.iter().map(|scope| format!("\"{}\"", scope.name())).collect();
    let hash = HEXLOWER.encode(&Sha256::digest(&key));
    let lines = format!(
        "[[keys]]\nid = \"{id}\"\ntenant = \"{tenant}\"\nscopes = [{}]\nsha256 = \"{hash}\"\n",
        scopes.join(", ")
    );
    Ok((key, lines))
}

/// Lines for the key file: a new secret that signs capabilities.
pub(crate) fn new_signer() -> io::Result<String> {
    Ok(format!("[[signers]]\nkid = \"{}\"\nsecret = \"{}\"\n", random::<ID_BYTES>()?, random::<SECRET_BYTES>()?))
}

/// A line for a tenant in the key file: a new secret that signs messages about its jobs.
pub(crate) fn new_webhook_secret() -> io::Result<Secret> {
    let mut bytes = [0; SECRET_BYTES];
    fill(&mut bytes)?;
    Ok(Secret::of(&bytes))
}

/// Fills bytes with random ones.
pub(super) fn fill(bytes: &mut [u8]) -> io::Result<()> {
    // In a file system without devices a static program fails here, and the error does not name the missing file.
    getrandom::fill(bytes).map_err(|error| io::Error::other(no_random(&error)))
}

fn no_random(error: &dyn fmt::Display) -> String {
    format!("there are no random numbers ({error}): the service needs /dev/random and /dev/urandom")
}

fn random<const N: usize>() -> io::Result<String> {
    let mut bytes = [0; N];
    fill(&mut bytes)?;
    Ok(BASE32_NOPAD.encode(&bytes).to_ascii_lowercase())
}

fn secret_of(text: &str) -> Option<[u8; SECRET_BYTES]> {
    BASE32_NOPAD.decode(text.to_ascii_uppercase().as_bytes()).ok()?.try_into().ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Instant;

    #[test]
    fn a_key_opens_what_its_lines_say() {
        let (key, lines) = new_key("acme", &[Scope::Render, Scope::Read]).unwrap();
        let text = format!("[tenants.acme]\nweight = 3\njobs = 7\n{lines}");
        let keys = Keys::read(&text, None).unwrap();
        let tenant = keys.tenant(&key).unwrap();
        assert_eq!((tenant.name.as_str(), tenant.weight, tenant.quotas.jobs), ("acme", 3, 7));
        assert!(tenant.may(Scope::Render) && !tenant.may(Scope::Jobs));
        assert!(!lines.contains(&key), "the file must not hold the key");
        let (other, _) = new_key("acme", &[Scope::Render]).unwrap();
        let mut longer = key.clone();
        longer.push('a');
        for wrong in [other.as_str(), &longer, &key[..key.len() - 1], "rk_", "", "rk__"] {
            assert!(keys.tenant(wrong).is_none(), "{wrong}");
        }
    }

    #[test]
    fn mistakes_in_the_file_are_named() {
        let hash = "0".repeat(64);
        let secret = new_webhook_secret().unwrap().text();
        for (text, part) in [
            ("[[keys]]\nid = \"a\"".to_owned(), "missing field"),
            ("[[kyes]]\n".to_owned(), "kyes"),
            ("[tenants.a_b]\n".to_owned(), "a_b"),
            ("[tenants.anonymous]\n".to_owned(), "everybody"),
            (format!("[[keys]]\nid=\"a\"\ntenant=\"b\"\nscopes=[]\nsha256=\"{hash}\""), "no scopes"),
            (format!("[[keys]]\nid=\"a\"\ntenant=\"b\"\nscopes=[\"paint\"]\nsha256=\"{hash}\""), "paint"),
            ("[[keys]]\nid=\"a\"\ntenant=\"b\"\nscopes=[\"read\"]\nsha256=\"12\"".to_owned(), "64"),
            ("[[signers]]\nkid=\"a\"\nsecret=\"short\"".to_owned(), "strahl key signer"),
            ("[tenants.a]\nwebhook_secret=\"short\"".to_owned(), "strahl key webhook"),
            ("[tenants.a]\nwebhook=\"https://example.org/\"".to_owned(), "strahl key webhook"),
            (format!("[tenants.a]\nwebhook=\"not a url\"\nwebhook_secret=\"{secret}\""), "webhook of the tenant a"),
            (format!("[tenants.a]\nwebhook=\"https://user:word@example.org\"\nwebhook_secret=\"{secret}\""), "no user"),
            ("[tenants.a]\nunits_per_minute=0".to_owned(), "at least 1"),
            ("[tenants.a]\nweight=0".to_owned(), "at least 1"),
        ] {
            let error = Keys::read(&text, None).unwrap_err();
            assert!(error.contains(part), "{part} in {error}");
        }
    }

    #[test]
    fn missing_devices_are_named() {
        let error = io::Error::from(io::ErrorKind::NotFound);
        assert!(no_random(&error).contains("/dev/random"));
    }

    #[test]
    fn reading_again_forgives_no_debts() {
        let text = "[tenants.acme]\nunits_per_minute = 10\n";
        let first = Keys::read(text, None).unwrap();
        let rate_limit = |keys: &Keys| Arc::clone(keys.reader("acme").unwrap().rate_limit.as_ref().unwrap());
        rate_limit(&first).charge(8_000_000, Instant::now());
        assert!(rate_limit(&Keys::read(text, Some(&first)).unwrap()).left(Instant::now()).units < 5);
        let raised = Keys::read("[tenants.acme]\nunits_per_minute = 20\n", Some(&first)).unwrap();
        assert_eq!(rate_limit(&raised).left(Instant::now()).units, 20);
    }
}
