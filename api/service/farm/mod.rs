//! The farm: a broker and a store between fronts, which take requests, and nodes, which render.

pub(crate) mod accounts;
pub(crate) mod backlog;
pub(crate) mod connection;
pub(crate) mod coordinator;
pub(crate) mod events;
pub(crate) mod fronts;
pub(crate) mod names;
pub(crate) mod node;
pub(crate) mod nodes;
pub(crate) mod records;
pub(crate) mod results;
pub(crate) mod settings;
pub(crate) mod spending;
pub(crate) mod summary;
pub(crate) mod work;

use self::backlog::{Backlog, Counts};
use self::connection::{Broker, reasons};
use self::nodes::Nodes;
use self::records::Records;
use self::results::Results;
use self::settings::FarmSettings;
use self::work::SceneSource;
use crate::service::error::{StartError, not_reachable};
use crate::service::storage::objects::Objects;
use crate::service::storage::revisions::Refused;
use async_nats::jetstream::stream::Stream;
use std::io;
use std::time::Duration;
use tokio::runtime::Handle;
use tokio::time::sleep;

/// Times that the broker is asked to take back the pieces of a picture that is complete, and the time between them.
const PURGES: u32 = 300;
const BETWEEN_PURGES: Duration = Duration::from_secs(1);

/// The farm as a front sees it.
#[derive(Debug)]
pub(crate) struct Farm {
    /// The connection to the broker.
    pub(crate) broker: Broker,
    /// The runtime of the connection. Threads of jobs wait on it.
    pub(crate) runtime: Handle,
    /// Scenes and pictures.
    pub(crate) objects: Objects,
    /// The nodes.
    pub(crate) nodes: Nodes,
    /// Finished tiles.
    pub(crate) results: Results,
    /// Work that is left.
    pub(crate) backlog: Backlog,
    /// What has happened.
    pub(crate) counts: Counts,
    /// The predicted time above which a picture that somebody waits for is rendered by nodes, if any is.
    pub(crate) spread: Option<Duration>,
    /// The stream of work.
    work: Stream<()>,
    /// How long the broker waits for a piece.
    lease: Duration,
}

impl Farm {
    /// Connects a front to the broker, if the settings name one, and to the store. Not to be called on a thread of a runtime.
    pub(crate) fn open(
        settings: &FarmSettings,
        store: Option<&Objects>,
        spread: Option<u64>,
        runtime: &Handle,
    ) -> Result<Option<Self>, StartError> {
        let Some(store) = store.filter(|_| settings.farm.is_some()) else { return Ok(None) };
        runtime.block_on(async {
            let broker = Broker::connect(settings, "strahl serve").await?;
            names::set_up(&broker, settings).await?;
            let results = Results::open(&broker).await.map_err(StartError::Machine)?;
            let work = broker.stream.get_stream_no_info(names::WORK).await;
            Ok(Some(Self {
                runtime: runtime.clone(),
                objects: store.clone(),
                nodes: Nodes::watch(&broker),
                results,
                backlog: Backlog::default(),
                counts: Counts::default(),
                spread: spread.map(Duration::from_millis),
                work: work.map_err(|error| StartError::Machine(reasons(&error)))?,
                lease: settings.farm_lease,
                broker,
            }))
        })
    }

    /// The secret that all fronts have, which is the one of the first that offers one. Not to be called on a thread of a
    /// runtime.
    pub(crate) fn secret(&self, offered: [u8; 32]) -> Result<[u8; 32], StartError> {
        let kept = || -> Result<Vec<u8>, String> {
            let bucket = self.runtime.block_on(Records::open(&self.broker, names::SECRETS, &self.runtime))?;
            match bucket.create(names::CAPABILITIES, offered.to_vec()) {
                Ok(_) => Ok(offered.to_vec()),
                Err(Refused::Changed) => {
                    let found = bucket.get(names::CAPABILITIES).map_err(|error| error.to_string())?;
                    Ok(found.map(|(secret, _)| secret).unwrap_or_default())
                }
                Err(Refused::Failed(error)) => Err(error.to_string()),
            }
        };
        let wrong = |why: &str| StartError::Machine(format!("the secret of the farm's fronts cannot be read: {why}"));
        kept().map_err(|error| wrong(&error))?.try_into().map_err(|_| wrong("it is not one of 32 bytes"))
    }

    /// Puts the text of a scene where nodes find it.
    pub(crate) fn share_scene(&self, scene: &SceneSource, text: &[u8]) -> io::Result<()> {
        self.runtime.block_on(async {
            let name = scene.blob();
            if !self.objects.exists(&name).await.map_err(not_reachable)? {
                self.objects.put_if_absent(&name, text.to_vec()).await.map_err(not_reachable)?;
            }
            Ok(())
        })
    }

    /// Forgets the tiles of a job that has ended.
    pub(crate) fn forget_results(&self, job: &str) {
        let (results, job) = (self.results.clone(), job.to_owned());
        self.runtime.spawn(async move {
            if let Err(error) = results.delete_all(&job).await {
                tracing::debug!(job, error, "the tiles of a job go later, since they are old");
            }
        });
    }

    /// Takes back all pieces of a job that wait.
    async fn purge(&self, tenant: &str, job: &str) -> Result<(), String> {
        purge(&self.work, names::all_work(tenant, job)).await
    }

    /// The same once the broker answers, for a job that sends no more. If the leader of the stream ends, pieces that nodes have
    /// acknowledged may stay in it: no node gets them, and they count against the most that the stream holds.
    fn purge_later(&self, tenant: &str, job: &str) {
        let (work, subject) = (self.work.clone(), names::all_work(tenant, job));
        self.runtime.spawn(async move {
            for _ in 0..PURGES {
                sleep(BETWEEN_PURGES).await;
                if purge(&work, subject.clone()).await.is_ok() {
                    return;
                }
            }
        });
    }
}

async fn purge(work: &Stream<()>, subject: String) -> Result<(), String> {
    work.purge().filter(subject).await.map(|_| ()).map_err(|error| reasons(&error))
}
