//! Starts and stops the service. Tokio's threads serve connections, the pool's threads render.

use super::auth::capability::{Signers, random_secret};
use super::auth::{Access, key_file};
use super::drain::Drain;
use super::metrics::Metrics;
use super::openapi_text;
use super::respond::message::HttpMessageWriter;
use super::routes::answer_front;
use super::server;
use super::settings::HttpSettings;
use super::state::{App, AppState};
use crate::service::concurrency_limit::ConcurrencyLimit;
use crate::service::deliveries::DeliveryWorker;
use crate::service::deliveries::receiver::Receivers;
use crate::service::deliveries::signature::Secret;
use crate::service::error::StartError;
use crate::service::farm::Farm;
use crate::service::farm::settings::FarmSettings;
use crate::service::farm::spending;
use crate::service::jobs::Jobs;
use crate::service::limits::Settings;
use crate::service::requests::Service;
use crate::service::requests::folders::Folders;
use crate::service::scheduler::pool::Pool;
use crate::service::stop_signals::StopSignals;
use crate::service::storage::objects::Objects;
use std::fmt::Display;
use std::io;
use std::net::SocketAddr;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::sync::{Arc, LazyLock};
use std::thread;
use std::time::Duration;
use tokio::net::{TcpListener, TcpSocket};

/// Threads for connections. They mostly wait, and the pool needs the processors.
const IO_THREADS: usize = 2;
/// Connections that the system accepts for us. A client beyond it tries again after a second, which a burst should not cost.
const BACKLOG: u32 = 4096;
/// Time for cancelled renders to stop before the process ends without them.
const LAST_WAIT: Duration = Duration::from_secs(1);

/// Serves until SIGTERM or Ctrl-C.
pub(crate) fn run(
    threads: Option<u64>,
    http: &HttpSettings,
    settings: &Settings,
    (farm, spread): (&FarmSettings, Option<u64>),
) -> Result<(), StartError> {
    check(http, settings, farm)?;
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(IO_THREADS)
        .enable_all()
        .build()
        .map_err(|error| StartError::Machine(format!("the service cannot start: {error}")))?;
    let store = farm.store.as_deref().map(|place| runtime.block_on(Objects::open(place))).transpose()?;
    let farm = Farm::open(farm, store.as_ref(), spread, runtime.handle())?.map(Arc::new);
    let mut settings = settings.clone();
    // The image of a container names a folder, whatever runs in it.
    if farm.is_some()
        && let Some(data) = settings.jobs.data.take()
    {
        tracing::info!(data = %data.display(), "the jobs of a farm are at its broker and in its store: --data is not used");
    }
    let settings = &settings;
    // They are given up, and a temporary one is removed, at the end of this function.
    let mut folders = Folders::open(settings)?;
    let app = open(threads, http, settings, farm, store, &mut folders)?;
    let delivery_worker = delivery_worker(&app);
    let served = runtime.block_on(async {
        let (clients, admin) = (listen(http.listen)?, http.admin_listen.map(listen).transpose()?);
        // Before the address is announced, since a client that reads it may send a signal at once.
        let signals = StopSignals::watch()
            .map_err(|error| StartError::Machine(format!("the signals to stop cannot be watched for: {error}")))?;
        let reload = tokio::spawn(key_file::watch(Arc::clone(&app.access)));
        let deliveries = tokio::spawn(delivery_worker.run());
        let (stop, stopped) = mpsc::channel();
        let jobs = Arc::clone(&app.service.jobs);
        let ticking = thread::Builder::new().name("retention".into()).spawn(move || tick(&jobs, &stopped));
        ticking.map_err(|error| StartError::Machine(format!("no thread can be started: {error}")))?;
        let jobs = Arc::clone(&app.service.jobs);
        let answering = tokio::spawn({
            let (app, jobs) = (Arc::clone(&app), Arc::clone(&jobs));
            async move { jobs.answer_fronts(move |question| answer_front(Arc::clone(&app), question)).await }
        });
        let spending = app.service.farm.as_ref().map(|farm| {
            let (here, there) = (Arc::clone(&app.access), Arc::clone(&app.access));
            let hear = move |tenant: &str, units| there.spent_elsewhere(tenant, units);
            tokio::spawn(spending::exchange(farm.broker.clone(), move || here.spent(), hear))
        });
        server::serve(clients, admin, signals, app, http).await;
        jobs.leave().await;
        answering.abort();
        reload.abort();
        deliveries.abort();
        spending.iter().for_each(tokio::task::JoinHandle::abort);
        drop(stop);
        Ok(())
    });
    runtime.shutdown_timeout(LAST_WAIT);
    served
}

/// What handlers share, with what is in the folders.
pub(super) fn open(
    threads: Option<u64>,
    http: &HttpSettings,
    settings: &Settings,
    farm: Option<Arc<Farm>>,
    store: Option<Objects>,
    folders: &mut Folders,
) -> Result<App, StartError> {
    let of_farm = match &farm {
        Some(farm) => {
            let random = random_secret().map_err(|error| StartError::Machine(error.to_string()))?;
            Some(Signers::of_farm(farm.secret(random)?))
        }
        None => None,
    };
    let webhooks = webhook_secret(settings)?;
    let access = Access::open(http.keys.as_deref(), of_farm, webhooks).map_err(|error| {
        let file = http.keys.as_deref().map_or_else(String::new, |path| format!("--keys {}: ", path.display()));
        StartError::Settings(format!("{file}{error}"))
    })?;
    let (access, metrics) = (Arc::new(access), Arc::<Metrics>::default());
    let pool = Pool::start(threads, Some(Arc::<Access>::clone(&access)))
        .map_err(|error| StartError::Machine(format!("the rendering threads cannot be started: {error}")))?;
    Ok(Arc::new(AppState {
        service: Service::open(settings, folders, pool, farm, store, Arc::<Metrics>::clone(&metrics))?,
        access,
        origins: http.origins(),
        public_url: http.public_url.clone(),
        streams: ConcurrencyLimit::default(),
        waits: ConcurrencyLimit::default(),
        requests: ConcurrencyLimit::default(),
        max_connections: http.max_connections,
        tile_clients: ConcurrencyLimit::default(),
        studio: http.studio().map_err(StartError::Settings)?,
        limits: http.limits.clone(),
        metrics,
        drain: Drain::default(),
        contract: LazyLock::new(openapi_text),
    }))
}

/// Delivers what jobs leave behind.
fn delivery_worker(app: &App) -> Arc<DeliveryWorker> {
    let service = &app.service;
    let settings = service.settings.deliveries.clone();
    let writer = Arc::new(HttpMessageWriter(Arc::clone(app)));
    DeliveryWorker::new(Arc::clone(&service.jobs), service.store.clone(), Receivers::new(&settings), writer, settings)
}

/// The secret that signs messages where there are no keys.
fn webhook_secret(settings: &Settings) -> Result<Option<Secret>, StartError> {
    let Some(path) = &settings.deliveries.webhook_secret_file else { return Ok(None) };
    let wrong = |why: &dyn Display| StartError::Settings(format!("--webhook-secret-file {}: {why}", path.display()));
    let text = std::fs::read_to_string(path).map_err(|error| wrong(&error))?;
    text.trim().parse().map(Some).map_err(|why: &str| wrong(&why))
}

/// Does what jobs need once a second until the sender is dropped. Files may be removed, which takes its time; a thread that
/// was borrowed each second would keep tokio's other idle threads alive, too.
fn tick(jobs: &Jobs, until: &Receiver<()>) {
    while until.recv_timeout(Duration::from_secs(1)) == Err(RecvTimeoutError::Timeout) {
        jobs.tick();
    }
}

/// Refuses settings that contradict each other.
pub(crate) fn check(http: &HttpSettings, settings: &Settings, farm: &FarmSettings) -> Result<(), StartError> {
    check_exposure(http)?;
    check_listeners(http)?;
    farm.store.as_deref().map_or(Ok(()), Objects::check_place)?;
    // A farm does not use --data.
    if farm.farm.is_none() { Folders::check(settings) } else { Ok(()) }
}

/// Refuses an address that other machines can reach, if no keys are needed there.
fn check_exposure(http: &HttpSettings) -> Result<(), StartError> {
    if http.keys.is_some() || http.insecure_no_auth || http.listen.ip().is_loopback() {
        return Ok(());
    }
    Err(StartError::Settings(format!(
        "--listen {} can be reached from other machines, and without keys everybody may render there.\n\n\
         Give --keys FILE (`strahl key new --tenant NAME --file FILE` makes one), or --insecure-no-auth if something \
         else keeps strangers out.",
        http.listen
    )))
}

/// Refuses one address for both listeners.
fn check_listeners(http: &HttpSettings) -> Result<(), StartError> {
    let is_same = |admin: SocketAddr| {
        let any = http.listen.ip().is_unspecified() || admin.ip().is_unspecified();
        http.listen.port() == admin.port() && admin.port() != 0 && (any || http.listen.ip() == admin.ip())
    };
    match http.admin_listen {
        Some(admin) if is_same(admin) => {
            let both = "--listen and --admin-listen are the same address: give each its own port";
            Err(StartError::Settings(both.into()))
        }
        _ => Ok(()),
    }
}

fn listen(address: SocketAddr) -> Result<TcpListener, StartError> {
    bind(address).map_err(|error| {
        let advice = match error.kind() {
            io::ErrorKind::AddrInUse => {
                "\n\nAnother program listens there. Stop it, or take another port: --listen 127.0.0.1:0 takes a free one."
            }
            io::ErrorKind::PermissionDenied => "\n\nPorts below 1024 are for the superuser.",
            _ => "",
        };
        StartError::Machine(format!("cannot listen on {address}: {error}{advice}"))
    })
}

fn bind(address: SocketAddr) -> io::Result<TcpListener> {
    let socket = if address.is_ipv4() { TcpSocket::new_v4() } else { TcpSocket::new_v6() }?;
    // Else a service that starts again would have to wait until the connections of the one before are forgotten.
    socket.set_reuseaddr(true)?;
    socket.bind(address)?;
    socket.listen(BACKLOG)
}
