//! Gauges: what waits, runs and is cached, read when Prometheus asks.

use crate::service::jobs::record::State;
use crate::service::requests::Service;
use crate::service::scheduler::task::Class;
use crate::service::storage::hit_counter::HitCounter;
use prometheus_client::metrics::counter::Counter;
use prometheus_client::metrics::family::Family;
use prometheus_client::metrics::gauge::Gauge;
use prometheus_client::registry::{Registry, Unit};
use std::sync::atomic::{AtomicU64, Ordering};

/// The gauges, as they were read last.
#[derive(Debug, Default)]
pub(crate) struct Gauges {
    running: Family<Label, Gauge>,
    waiting: Family<Label, Gauge>,
    pool_seconds: Family<Label, Counter<f64, AtomicU64>>,
    canceled_seconds: Family<Label, Counter<f64, AtomicU64>>,
    threads: Gauge,
    threads_busy: Gauge,
    jobs: Family<Label, Gauge>,
    data_bytes: Gauge,
    streams: Gauge,
    memory_bytes: Gauge,
    cache_bytes: Family<Label, Gauge>,
    cache_hits: Family<Label, Counter>,
    cache_misses: Family<Label, Counter>,
}

/// A label and its value.
pub(crate) type Label = [(&'static str, &'static str); 1];

pub(crate) fn lane(class: Class) -> Label {
    [("lane", class.name())]
}

impl Gauges {
    /// Registers all gauges.
    pub(crate) fn register(&self, to: &mut Registry) {
        to.register("renders_running", "Renders and jobs under way", self.running.clone());
        to.register("queue_depth", "Renders and jobs that wait", self.waiting.clone());
        let help = "Time that the threads which render have spent";
        to.register_with_unit("pool", help, Unit::Seconds, self.pool_seconds.clone());
        let help = "Time spent on renders whose clients went away or ran out of time";
        to.register_with_unit("canceled_work", help, Unit::Seconds, self.canceled_seconds.clone());
        to.register("threads", "Threads that render", self.threads.clone());
        to.register("threads_busy", "Those that have work at this moment", self.threads_busy.clone());
        to.register("jobs", "Jobs that are known", self.jobs.clone());
        to.register("data_bytes", "Bytes of scenes and pictures of jobs on disk", self.data_bytes.clone());
        to.register("sse_streams", "Event streams that are open", self.streams.clone());
        let help = "Memory that requests, jobs, caches and the program have taken of --memory-bytes";
        to.register("memory_bytes", help, self.memory_bytes.clone());
        to.register("cache_bytes", "Bytes that are kept", self.cache_bytes.clone());
        to.register("cache_hits", "What was asked for and was kept", self.cache_hits.clone());
        to.register("cache_misses", "What had to be made or fetched", self.cache_misses.clone());
    }

    /// Reads all gauges.
    pub(crate) fn read(&self, service: &Service, streams: u64) {
        let (jobs_waiting, jobs_open) = service.jobs.counts();
        let of_queue = [(Class::Tiles, &service.tiles), (Class::Renders, &service.queue)];
        let queues = of_queue.map(|(class, queue)| (class, queue.waiting(), queue.running()));
        for (class, waiting, running) in queues.into_iter().chain([(Class::Jobs, jobs_waiting, jobs_open)]) {
            self.waiting.get_or_create(&lane(class)).set(whole(waiting as u64));
            self.running.get_or_create(&lane(class)).set(whole(running as u64));
            self.pool_seconds
                .get_or_create(&lane(class))
                .inner()
                .store(service.pool.scheduler.spent(class).to_bits(), Ordering::Relaxed);
        }
        let canceled = of_queue.map(|(class, queue)| (class, queue.canceled()));
        for (class, seconds) in canceled.into_iter().chain([(Class::Jobs, service.jobs.canceled())]) {
            self.canceled_seconds
                .get_or_create(&lane(class))
                .inner()
                .store(seconds.as_secs_f64().to_bits(), Ordering::Relaxed);
        }
        let threads = service.pool.threads as u64;
        self.threads.set(whole(threads));
        self.threads_busy.set(whole(if service.pool.scheduler.is_taken() { threads } else { 0 }));
        let by_state = service.jobs.by_state();
        for (state, _) in State::ALL {
            let count = by_state.iter().filter(|known| known.name() == state).count();
            self.jobs.get_or_create(&[("state", state)]).set(whole(count as u64));
        }
        self.data_bytes.set(whole(service.jobs.bytes()));
        self.streams.set(whole(streams));
        self.memory_bytes.set(whole(service.memory.taken()));
        self.cache("scenes", service.scenes.bytes(), Some(&service.scenes.hits));
        self.cache("known_scenes", service.scenes.store.bytes(), None);
        for (name, bytes, hits) in service.pictures.hit_counters() {
            self.cache(name, bytes, Some(hits));
        }
    }

    fn cache(&self, cache: &'static str, bytes: u64, hits: Option<&HitCounter>) {
        let labels = [("cache", cache)];
        self.cache_bytes.get_or_create(&labels).set(whole(bytes));
        if let Some([hits, misses]) = hits.map(HitCounter::counts) {
            self.cache_hits.get_or_create(&labels).inner().store(hits, Ordering::Relaxed);
            self.cache_misses.get_or_create(&labels).inner().store(misses, Ordering::Relaxed);
        }
    }
}

/// A count as a gauge, whose numbers are signed.
pub(super) fn whole(count: u64) -> i64 {
    i64::try_from(count).unwrap_or(i64::MAX)
}
