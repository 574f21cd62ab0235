//! `strahl serve`: the service. Tokio's threads talk, the pool's threads render.

pub(crate) mod auth;
pub(crate) mod concurrency_limit;
pub(crate) mod contract;
pub(crate) mod drain;
pub(crate) mod extract;
pub(crate) mod job_host;
pub(crate) mod metrics;
pub(crate) mod middleware;
pub(crate) mod problem;
pub(crate) mod raw_errors;
pub(crate) mod respond;
pub(crate) mod routes;
pub(crate) mod server;
pub(crate) mod write_timeout;

use crate::cli::failure::Failure;
use crate::cli::{LogFormat, ServeArgs};
use crate::service::jobs::Jobs;
use crate::service::limits::Limits;
use crate::service::pictures::cache::PictureCache;
use crate::service::scenes::cache::SceneCache;
use crate::service::scenes::store::SceneStore;
use crate::service::scenes::texture_folder::TextureFolder;
use crate::service::scheduler::admission::Queue;
use crate::service::scheduler::pool::Pool;
use crate::service::storage::blob_store::BlobStore;
use crate::service::storage::data_folder::DataFolder;
use crate::service::storage::lru_cache::LruCache;
use auth::Access;
use auth::client::Client;
use concurrency_limit::ConcurrencyLimit;
use drain::{Drain, StopSignals};
use job_host::JobHost;
use metrics::Metrics;
use server::Listeners;
use std::io;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;
use tokio::net::TcpListener;
use tokio::sync::Semaphore;
use tracing_subscriber::filter::Targets;
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;

/// Everything the handlers share.
#[derive(Debug)]
pub(crate) struct Service {
    /// The threads that render.
    pool: Arc<Pool>,
    /// The one way to them.
    queue: Queue,
    /// The way for tiles, of which a viewer asks for many at once.
    tiles: Queue,
    /// Who may do what.
    access: Arc<Access>,
    /// Scenes that need not be built again.
    scenes: Arc<SceneCache>,
    /// Pictures that need not be made again.
    pictures: PictureCache,
    /// Under which address clients see the service, if it was told.
    public_url: Option<String>,
    /// Renders that nobody has to wait for.
    jobs: Arc<Jobs>,
    /// Open event streams of tenants.
    streams: ConcurrencyLimit<String>,
    /// Tiles that are being answered.
    tile_clients: ConcurrencyLimit<Client>,
    /// What a request may ask for.
    limits: Limits,
    /// How much memory bodies and answers may take together, in units of [`body::UNIT`] bytes.
    memory: Arc<Semaphore>,
    /// What has been counted.
    metrics: Arc<Metrics>,
    /// Whether the service is about to end.
    drain: Drain,
}

/// How handlers get it.
pub(crate) type App = Arc<Service>;

/// What a tile may wait. OpenSeadragon gives up after 30 seconds, and never asks again.
const TILE_PATIENCE: Duration = Duration::from_secs(25);
/// Threads that only wait for sockets: the pool needs the processors.
const TALKERS: usize = 2;
/// What a render that ignores its cancellation gets before the process ends without it.
const LAST_WAIT: Duration = Duration::from_secs(1);

/// Serves until SIGTERM or Ctrl-C.
pub(crate) fn run(args: &ServeArgs) -> Result<(), Failure> {
    log(args.log_format);
    check_exposure(args)?;
    let access = Access::open(args.keys.as_deref(), args.cors_origin.clone()).map_err(|error| {
        let file = args.keys.as_deref().map_or_else(String::new, |path| format!("--keys {}: ", path.display()));
        Failure::Usage(format!("{file}{error}"))
    })?;
    let pool = Pool::start(args.threads)
        .map_err(|error| Failure::Input(format!("the rendering threads cannot be started: {error}")))?;
    let limits = Limits::new(args);
    let textures = args.textures.as_deref().map(|path| {
        TextureFolder::open(path).map_err(|error| Failure::Usage(format!("--textures {}: {error}", path.display())))
    });
    let blobs = |part: &str, budget: u64| {
        let folder = args.cache.as_ref().map(|folder| folder.join(part));
        let open = |folder: PathBuf| {
            BlobStore::open(&folder, budget)
                .map_err(|error| Failure::Usage(format!("--cache {}: {error}", folder.display())))
        };
        folder.map(open).transpose()
    };
    let texts = blobs("scenes", args.known_scene_bytes)?
        .map_or_else(|| SceneStore::Memory(LruCache::new(args.known_scene_bytes)), SceneStore::TextureFolder);
    let scenes = Arc::new(SceneCache::new(args.scene_cache_bytes, textures.transpose()?, texts));
    let data = DataFolder::open(args.data.as_deref()).map_err(|error| Failure::Usage(error.to_string()))?;
    let (access, metrics) = (Arc::new(access), Arc::<Metrics>::default());
    let host = JobHost { scenes: Arc::clone(&scenes), access: Arc::clone(&access), metrics: Arc::clone(&metrics) };
    let jobs = open_jobs(&data, &limits, &pool, host)?;
    let service = Arc::new(Service {
        queue: Queue::new(Arc::clone(&pool), args.queue, args.timeout),
        tiles: Queue::new(Arc::clone(&pool), args.tile_queue, TILE_PATIENCE.min(args.timeout)),
        pool,
        access,
        pictures: PictureCache::new(args.picture_cache_bytes, blobs("pictures", args.disk_cache_bytes)?),
        public_url: args.public_url.clone(),
        scenes,
        jobs,
        streams: ConcurrencyLimit::default(),
        tile_clients: ConcurrencyLimit::default(),
        memory: Arc::new(Semaphore::new(extract::body::units(limits.memory_bytes))),
        limits,
        metrics,
        drain: Drain::default(),
    });
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(TALKERS)
        .enable_all()
        .build()
        .map_err(|error| Failure::Input(format!("the service cannot start: {error}")))?;
    let served = runtime.block_on(async {
        let listeners = Listeners {
            clients: listen(args.listen).await?,
            admin: match args.admin_listen {
                Some(address) => Some(listen(address).await?),
                None => None,
            },
        };
        // Before the address is announced: whoever reads it may send a signal at once.
        let signals = StopSignals::watch()
            .map_err(|error| Failure::Input(format!("the signals to stop cannot be watched for: {error}")))?;
        let reload = tokio::spawn(auth::key_file::watch(Arc::clone(&service)));
        let ticking = tokio::spawn(tick(Arc::clone(&service.jobs)));
        server::serve(listeners, signals, service, args).await;
        reload.abort();
        ticking.abort();
        Ok(())
    });
    runtime.shutdown_timeout(LAST_WAIT);
    served
}

/// The jobs in the folder, whose scenes are built as those of requests are.
fn open_jobs(data: &DataFolder, limits: &Limits, pool: &Arc<Pool>, host: JobHost) -> Result<Arc<Jobs>, Failure> {
    Jobs::open(data.path(), data.is_durable(), limits.of_jobs(), Arc::clone(pool), Box::new(host)).map_err(|error| {
        let folder = data.path().display();
        Failure::Input(format!("jobs cannot be kept in {folder}: {error}\n\nAnother process may be using the folder."))
    })
}

/// What jobs need once in a while.
async fn tick(jobs: Arc<Jobs>) {
    let mut seconds = tokio::time::interval(Duration::from_secs(1));
    loop {
        seconds.tick().await;
        let jobs = Arc::clone(&jobs);
        // Files may be removed, which takes its time.
        let _ = tokio::task::spawn_blocking(move || jobs.tick()).await;
    }
}

/// Refuses to listen where others can reach it, and let everybody do everything.
fn check_exposure(args: &ServeArgs) -> Result<(), Failure> {
    if args.keys.is_some() || args.insecure_no_auth || args.listen.ip().is_loopback() {
        return Ok(());
    }
    Err(Failure::Usage(format!(
        "--listen {} can be reached from other machines, and without keys everybody may render there.\n\n\
         Give --keys FILE (`strahl key new --tenant NAME --file FILE` makes one), or --insecure-no-auth if something \
         else keeps strangers out.",
        args.listen
    )))
}

async fn listen(address: SocketAddr) -> Result<TcpListener, Failure> {
    TcpListener::bind(address).await.map_err(|error| Failure::Input(format!("cannot listen on {address}: {error}")))
}

/// From now on the log goes to standard error; `STRAHL_LOG` says what of it, by default what is at least `info`.
fn log(format: LogFormat) {
    let wanted = std::env::var("STRAHL_LOG").ok().and_then(|filter| filter.parse::<Targets>().ok());
    let filter = wanted.unwrap_or_else(|| Targets::new().with_default(tracing::Level::INFO));
    let lines = tracing_subscriber::fmt::layer().with_writer(io::stderr).with_ansi(false);
    let log = tracing_subscriber::registry().with(filter);
    match format {
        LogFormat::Text => log.with(lines).init(),
        LogFormat::Json => log.with(lines.json().flatten_event(true).with_current_span(false)).init(),
    }
}
