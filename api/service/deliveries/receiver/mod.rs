//! Sends one message to the receiver of a tenant: a POST to its URL, at an address that messages may go to, without redirects,
//! within a time, reading little of the answer.

use super::signature::Secret;
use crate::service::addresses::{Network, is_public};
use crate::service::clock::unix_time;
use crate::service::limits::DeliverySettings;
use crate::service::tls;
use futures_util::future::BoxFuture;
use reqwest::dns::{Addrs, Name, Resolve, Resolving};
use reqwest::header::RETRY_AFTER;
use reqwest::{Client, StatusCode, Url, redirect};
use std::error::Error;
use std::fmt;
use std::io;
use std::net::{IpAddr, SocketAddr};
use std::sync::{Arc, LazyLock};
use std::time::{Duration, SystemTime};

/// Bytes of an answer that are read, so that the connection ends in order. Nothing is done with them.
const ANSWER_BYTES: usize = 64 << 10;
/// Bytes of a URL.
const URL_BYTES: usize = 2_048;
/// Longest wait that a receiver can ask for.
const LONGEST_WAIT: Duration = Duration::from_secs(3_600);

/// Finds the addresses of a name.
pub(crate) type Lookup = dyn Fn(String) -> BoxFuture<'static, io::Result<Vec<IpAddr>>> + Send + Sync;

/// Makes a client when it is first asked for.
type LateClient = LazyLock<Result<Client, String>, Box<dyn FnOnce() -> Result<Client, String> + Send>>;

/// Sends messages.
pub(crate) struct Receivers {
    /// Made for the first message: it reads all certificates of the system, which may have none.
    client: LateClient,
    rules: Rules,
}

/// Where messages may go.
#[derive(Debug, Clone)]
pub(crate) struct Rules {
    allowed: Arc<[Network]>,
    plain_http: bool,
}

/// A message.
#[derive(Debug)]
pub(crate) struct Message<'a> {
    /// The same for all attempts, and for no other message.
    pub(crate) id: &'a str,
    /// JSON.
    pub(crate) body: &'a str,
    /// Signs it.
    pub(crate) secret: &'a Secret,
}

/// Why a message has not arrived.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Refusal {
    /// It may another time, not before a wait that the receiver asked for.
    Later(String, Duration),
    /// It never will.
    Never(String),
}

/// A URL that some service could send messages to.
pub(crate) fn read_url(url: &str) -> Result<Url, String> {
    if url.len() > URL_BYTES {
        return Err(format!("a webhook's url has at most {URL_BYTES} bytes"));
    }
    let url: Url = url.parse().map_err(|error| format!("the webhook's url cannot be read: {error}"))?;
    if !matches!(url.scheme(), "http" | "https") {
        return Err(format!("a webhook's url is https://, not {}://", url.scheme()));
    }
    if !url.username().is_empty() || url.password().is_some() {
        return Err("a webhook's url has no user and password: messages are signed instead".into());
    }
    Ok(url)
}

impl Rules {
    /// Those of the settings.
    pub(crate) fn of(settings: &DeliverySettings) -> Self {
        Self { allowed: settings.webhook_allow.clone().into(), plain_http: settings.webhook_http }
    }

    /// A URL that messages may be sent to, as far as it says itself. Its name is looked up when a message is sent.
    pub(crate) fn check(&self, url: &str) -> Result<Url, String> {
        let url = read_url(url)?;
        if url.scheme() == "http" && !self.plain_http {
            return Err("the webhook's url is https:// here; --webhook-http accepts http://, too".into());
        }
        // Addresses are not looked up.
        let address = url.host_str().and_then(|host| host.trim_matches(['[', ']']).parse().ok());
        if address.is_some_and(|address| !self.may_reach(address)) {
            return Err("the webhook's address is not public, and --webhook-allow does not name it".into());
        }
        Ok(url)
    }

    fn may_reach(&self, address: IpAddr) -> bool {
        is_public(address) || self.allowed.iter().any(|network| network.has(address))
    }
}

impl Receivers {
    /// As the settings say, with names that the system looks up.
    pub(crate) fn new(settings: &DeliverySettings) -> Self {
        Self::with(settings, Arc::new(|name| Box::pin(look_up(name))))
    }

    /// The same with another lookup.
    fn with(settings: &DeliverySettings, lookup: Arc<Lookup>) -> Self {
        let rules = Rules::of(settings);
        let names = PublicNames { rules: rules.clone(), lookup };
        let timeout = settings.webhook_timeout;
        Self { client: LazyLock::new(Box::new(move || client(timeout, names))), rules }
    }

    /// Sends a message; it has arrived if the receiver answers with a status of 200 to 299.
    pub(crate) async fn send(&self, url: &str, message: &Message<'_>) -> Result<(), Refusal> {
        let url = self.rules.check(url).map_err(Refusal::Never)?;
        let seconds = unix_time().as_secs();
        let later = |why: String| Refusal::Later(why, Duration::ZERO);
        let client = self.client.as_ref().map_err(|why| later(why.clone()))?;
        let request = client
            .post(url)
            .header("content-type", "application/json")
            .header("webhook-id", message.id)
            .header("webhook-timestamp", seconds.to_string())
            .header("webhook-signature", message.secret.sign(message.id, seconds, message.body))
            .body(message.body.to_owned());
        let mut answer = request.send().await.map_err(|error| later(reason(&error)))?;
        let status = answer.status();
        let wait = answer.headers().get(RETRY_AFTER).and_then(|wait| wait_of(wait.to_str().ok()?));
        let wait = wait.unwrap_or(Duration::ZERO).min(LONGEST_WAIT);
        let mut read = 0;
        while read < ANSWER_BYTES
            && let Ok(Some(bytes)) = answer.chunk().await
        {
            read += bytes.len();
        }
        match status {
            status if status.is_success() => Ok(()),
            StatusCode::GONE => Err(Refusal::Never("the receiver answered 410 Gone".into())),
            status if status.is_redirection() => {
                Err(Refusal::Later(format!("the receiver answered {status}; redirects are not followed"), wait))
            }
            status => Err(Refusal::Later(format!("the receiver answered {status}"), wait)),
        }
    }
}

/// How long a `Retry-After` asks to wait: seconds, or until a date (RFC 9110, 10.2.3).
fn wait_of(text: &str) -> Option<Duration> {
    let seconds = text.parse().ok().map(Duration::from_secs);
    let until = || Some(httpdate::parse_http_date(text).ok()?.duration_since(SystemTime::now()).unwrap_or_default());
    seconds.or_else(until)
}

impl fmt::Debug for Receivers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Receivers").field("rules", &self.rules).finish_non_exhaustive()
    }
}

fn client(timeout: Duration, names: PublicNames) -> Result<Client, String> {
    tls::install_provider();
    let client = Client::builder()
        .user_agent(concat!("strahl/", env!("CARGO_PKG_VERSION")))
        // A proxy would connect to addresses that it looks up itself.
        .no_proxy()
        .redirect(redirect::Policy::none())
        .referer(false)
        .timeout(timeout)
        .http1_only()
        // The address of each message is looked up and checked.
        .pool_max_idle_per_host(0)
        .dns_resolver(names)
        .build();
    client.map_err(|error| format!("the service cannot send messages: {}", reason(&error)))
}

async fn look_up(name: String) -> io::Result<Vec<IpAddr>> {
    Ok(tokio::net::lookup_host((name, 0)).await?.map(|address| address.ip()).collect())
}

/// Looks names up and leaves out addresses that messages may not go to. The client connects to those that are left.
struct PublicNames {
    rules: Rules,
    lookup: Arc<Lookup>,
}

impl Resolve for PublicNames {
    fn resolve(&self, name: Name) -> Resolving {
        let (rules, found) = (self.rules.clone(), (self.lookup)(name.as_str().to_owned()));
        Box::pin(async move {
            let found = found.await.map_err(|_| Unreachable("the receiver's name has no address"))?;
            let reachable: Vec<_> = found.into_iter().filter(|address| rules.may_reach(*address)).collect();
            if reachable.is_empty() {
                // Which they are is none of the tenant's business.
                return Err(Unreachable(
                    "the receiver's addresses are not public, and --webhook-allow does not name them",
                )
                .into());
            }
            // Port 0 is the one of the URL.
            Ok(Box::new(reachable.into_iter().map(|address| SocketAddr::new(address, 0))) as Addrs)
        })
    }
}

#[derive(Debug)]
struct Unreachable(&'static str);

impl fmt::Display for Unreachable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0)
    }
}

impl Error for Unreachable {}

/// Why a request failed: the first cause, without the URL, which may contain a secret.
fn reason(error: &reqwest::Error) -> String {
    let mut cause: &dyn Error = error;
    while let Some(source) = cause.source() {
        cause = source;
    }
    let text = if error.is_timeout() { "the receiver did not answer in time".to_owned() } else { cause.to_string() };
    text.chars().take(200).collect()
}

#[cfg(test)]
mod tests;
