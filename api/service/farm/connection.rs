//! The connection to the broker: made within a deadline or refused with a reason, and watched afterwards.

use super::settings::{FarmSettings, Servers};
use crate::service::error::StartError;
use crate::service::tls;
use async_nats::jetstream::{self, Context};
use async_nats::{Client, ConnectError, ConnectErrorKind, ConnectOptions, Event, ServerError};
use std::error::Error;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};
use tokio::sync::watch;

/// The oldest server. 2.9.10, which Debian has, leaves work behind after a restart and after a purge; between that and 2.12 none
/// was tried.
const OLDEST: (i64, i64, i64) = (2, 12, 0);
/// How long a broker that does not answer is tried at the start: the two may have been started together.
const PATIENCE: Duration = Duration::from_secs(15);
/// Time between two tries.
const BETWEEN: Duration = Duration::from_millis(500);
/// How long one answer of the broker may take.
const ANSWER: Duration = Duration::from_secs(5);
/// Time until the broker is asked again after an error.
pub(super) const RETRY_AFTER: Duration = Duration::from_secs(1);
/// Messages that may wait for their acknowledgement.
const IN_FLIGHT: usize = 4_096;

/// The broker. Clones share one connection.
#[derive(Debug, Clone)]
pub(crate) struct Broker {
    /// For messages that are not kept.
    pub(crate) client: Client,
    /// For those that are.
    pub(crate) stream: Context,
    health: Arc<Health>,
}

/// How the connection is.
#[derive(Debug)]
struct Health {
    connected: AtomicBool,
    errors: AtomicU64,
    /// Grows with each connection. What was said meanwhile has not been heard.
    connections: watch::Sender<u64>,
}

impl Broker {
    /// Connects. `name` is what the broker's operator sees.
    pub(crate) async fn connect(settings: &FarmSettings, name: &str) -> Result<Self, StartError> {
        tls::install_provider();
        let Some(servers) = &settings.farm else {
            return Err(StartError::Settings("--farm is needed: the address of the farm's NATS servers".into()));
        };
        let health = Arc::new(Health {
            connected: AtomicBool::new(true),
            errors: AtomicU64::new(0),
            connections: watch::Sender::new(0),
        });
        let client = within_patience(settings, servers, name, &health).await?;
        let version = client.server_info().version;
        let (major, minor, patch) = OLDEST;
        if !client.is_server_compatible(major, minor, patch) {
            return Err(StartError::Machine(format!(
                "the broker at {servers} is nats-server {version}; {major}.{minor} or newer is needed: older ones lose work \
                 when they are restarted."
            )));
        }
        if !client.server_info().jetstream {
            return Err(StartError::Machine(format!(
                "the broker at {servers} keeps no messages: start nats-server with -js, or with `jetstream {{}}` in its \
                 configuration."
            )));
        }
        tracing::info!(broker = %servers, version, "connected to the broker");
        let context = jetstream::ContextBuilder::new();
        let stream =
            context.timeout(ANSWER).max_ack_inflight(IN_FLIGHT).backpressure_on_inflight(true).build(client.clone());
        Ok(Self { client, stream, health })
    }

    /// Whether it is connected now.
    pub(crate) fn is_connected(&self) -> bool {
        self.health.connected.load(Ordering::Relaxed)
    }

    /// Errors that the broker has reported, such as missing permissions.
    pub(crate) fn errors(&self) -> u64 {
        self.health.errors.load(Ordering::Relaxed)
    }

    /// A channel that changes with each new connection.
    pub(crate) fn connections(&self) -> watch::Receiver<u64> {
        self.health.connections.subscribe()
    }
}

/// Tries until the broker answers, or refuses.
async fn within_patience(
    settings: &FarmSettings,
    servers: &Servers,
    name: &str,
    health: &Arc<Health>,
) -> Result<Client, StartError> {
    let begun = Instant::now();
    let mut has_complained = false;
    loop {
        let error = match options(settings, servers, name, health)?.connect(servers.addresses.as_slice()).await {
            Ok(client) => return Ok(client),
            Err(error) => error,
        };
        let may_come =
            matches!(error.kind(), ConnectErrorKind::Io | ConnectErrorKind::TimedOut | ConnectErrorKind::Dns);
        if !may_come || begun.elapsed() >= PATIENCE {
            return Err(refused(servers, &error));
        }
        if !has_complained {
            tracing::warn!(broker = %servers, error = reasons(&error), "the broker does not answer yet");
            has_complained = true;
        }
        tokio::time::sleep(BETWEEN).await;
    }
}

fn options(
    settings: &FarmSettings,
    servers: &Servers,
    name: &str,
    health: &Arc<Health>,
) -> Result<ConnectOptions, StartError> {
    let mut options = ConnectOptions::new()
        .name(name)
        .custom_inbox_prefix(&settings.farm_inbox)
        .require_tls(servers.need_tls())
        // A connection that is silently dead is noticed within two pings.
        .ping_interval(Duration::from_secs(10))
        .event_callback({
            let health = Arc::clone(health);
            move |event| {
                health.note(&event);
                std::future::ready(())
            }
        });
    if let Some(path) = &settings.farm_ca {
        std::fs::read(path).map_err(|error| StartError::Settings(format!("--farm-ca {}: {error}", path.display())))?;
        options = options.add_root_certificates(path.clone());
    }
    if let Some((user, password)) = &servers.login {
        options = options.user_and_password(user.clone(), password.clone());
    }
    if let Some(text) = settings.credentials()? {
        let path = settings.farm_credentials.as_deref().unwrap_or_else(|| "".as_ref());
        let wrong = |error| StartError::Settings(format!("--farm-credentials {}: {error}", path.display()));
        options = match lone_seed(&text) {
            Some(seed) => options.nkey(seed.to_owned()),
            None => options.credentials(&text).map_err(wrong)?,
        };
    }
    Ok(options)
}

/// The seed of a file that has nothing else, as `strahl farm accounts` writes it.
fn lone_seed(text: &str) -> Option<&str> {
    let text = text.trim();
    (text.starts_with("SU") && text.bytes().all(|b| b.is_ascii_alphanumeric())).then_some(text)
}

impl Health {
    fn note(&self, event: &Event) {
        match event {
            Event::Connected => {
                self.connected.store(true, Ordering::Relaxed);
                self.connections.send_modify(|count| *count += 1);
                tracing::info!("connected to the broker");
            }
            Event::Disconnected | Event::Closed => {
                self.connected.store(false, Ordering::Relaxed);
                tracing::warn!("the connection to the broker is lost; it is tried again");
            }
            // Whoever publishes without permission only waits in vain: this is where it is said.
            Event::ServerError(ServerError::Other(error)) => self.complain(error),
            Event::ServerError(error) => self.complain(&error.to_string()),
            Event::ClientError(error) => tracing::debug!(%error, "the broker cannot be reached"),
            Event::SlowConsumer(_) => self.complain("messages come faster than they are read"),
            Event::LameDuckMode | Event::Draining => tracing::info!(%event, "the broker will stop"),
        }
    }

    fn complain(&self, error: &str) {
        self.errors.fetch_add(1, Ordering::Relaxed);
        tracing::error!(error, "the broker has refused something");
    }
}

/// Why there is no connection, and what to do.
fn refused(servers: &Servers, error: &ConnectError) -> StartError {
    let advice = match error.kind() {
        ConnectErrorKind::AuthorizationViolation | ConnectErrorKind::Authentication => {
            "Give the user and password in the address, nats://user:password@host, or --farm-credentials FILE."
        }
        ConnectErrorKind::Tls => "Give the certificates that the broker's is signed with: --farm-ca FILE.",
        ConnectErrorKind::Io if servers.need_tls() => {
            "Is it the right address, and is the broker's certificate one of --farm-ca FILE?"
        }
        _ => "Is it the right address, and does nats-server run there?",
    };
    StartError::Machine(format!("the broker at {servers} cannot be reached: {}\n\n{advice}", reasons(error)))
}

/// An error with all that has led to it.
pub(crate) fn reasons(error: &(dyn Error + 'static)) -> String {
    let mut all = vec![error.to_string()];
    let mut next = error.source();
    while let Some(error) = next {
        all.push(error.to_string());
        next = error.source();
    }
    // The text of an error often contains that of its source.
    all.dedup_by(|source, error| error.contains(source.as_str()));
    all.join(": ")
}
