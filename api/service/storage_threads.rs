//! Threads for requests that wait: for the disk, for the store of a farm, for one another, or until a large body is understood.
//! The runtime has 512 threads for such work, on which renders begin, too, and two that must never wait.

use super::error::Error;
use parking_lot::Mutex;
use std::collections::HashMap;
use std::sync::{Arc, Weak};
use tokio::sync::Semaphore;

/// Requests that have a thread at a time. Others wait without one.
const ALL: usize = 64;
/// Of them, those of one tenant: whatever one asks for, there is room for others.
const OF_A_TENANT: usize = 16;

/// Who has threads.
#[derive(Debug)]
pub(crate) struct StorageThreads {
    all: Arc<Semaphore>,
    tenants: Mutex<HashMap<String, Weak<Semaphore>>>,
}

impl Default for StorageThreads {
    fn default() -> Self {
        Self { all: Arc::new(Semaphore::new(ALL)), tenants: Mutex::default() }
    }
}

impl StorageThreads {
    /// Does work of a tenant on a thread that may wait. Who leaves does not end what has begun.
    pub(crate) async fn run<T: Send + 'static>(
        &self,
        tenant: &str,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, Error> {
        let lost = || Error::Internal("the request failed");
        let own = self.of(tenant).acquire_owned().await.map_err(|_| lost())?;
        let any = Arc::clone(&self.all).acquire_owned().await.map_err(|_| lost())?;
        let work = move || {
            let _places = (own, any);
            work()
        };
        tokio::task::spawn_blocking(work).await.map_err(|_| lost())
    }

    fn of(&self, tenant: &str) -> Arc<Semaphore> {
        let mut tenants = self.tenants.lock();
        if let Some(known) = tenants.get(tenant).and_then(Weak::upgrade) {
            return known;
        }
        tenants.retain(|_, known| known.strong_count() > 0);
        let new = Arc::new(Semaphore::new(OF_A_TENANT));
        tenants.insert(tenant.to_owned(), Arc::downgrade(&new));
        new
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc::channel;

    /// One tenant's requests all wait for something; another's are answered meanwhile.
    #[tokio::test]
    async fn a_tenant_whose_requests_wait_leaves_threads_to_others() {
        let threads = Arc::new(StorageThreads::default());
        let (begun, begins) = channel();
        let (wake, sleep) = channel::<()>();
        let sleep = Arc::new(Mutex::new(sleep));
        let many: Vec<_> = (0..2 * ALL)
            .map(|number| {
                let (threads, begun, sleep) = (Arc::clone(&threads), begun.clone(), Arc::clone(&sleep));
                tokio::spawn(async move {
                    let work = move || {
                        begun.send(()).unwrap();
                        let _ = sleep.lock().recv();
                        number
                    };
                    threads.run("many", work).await.unwrap()
                })
            })
            .collect();
        while threads.all.available_permits() > ALL - OF_A_TENANT {
            tokio::task::yield_now().await;
        }
        assert_eq!(threads.run("one", || 1).await.unwrap(), 1);
        assert!(begins.try_iter().count() <= OF_A_TENANT);
        drop(wake);
        for (number, work) in many.into_iter().enumerate() {
            assert_eq!(work.await.unwrap(), number);
        }
        assert!(threads.tenants.lock().values().all(|known| known.strong_count() == 0), "nobody is remembered");
    }

    #[tokio::test]
    async fn a_panic_gives_its_place_back() {
        let threads = StorageThreads::default();
        for _ in 0..=ALL {
            assert!(threads.run("one", || panic!("as it is meant")).await.is_err());
        }
        assert_eq!(threads.run("one", || 1).await.unwrap(), 1);
    }
}
