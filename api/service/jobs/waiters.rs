//! Requests that wait for a job, and whether any client has been told of it: a job that nobody knows of ends with the last request.

use parking_lot::Mutex;

/// The requests.
#[derive(Debug, Default)]
pub(crate) struct Waiters(Mutex<State>);

#[derive(Debug, Default)]
struct State {
    waiting: usize,
    /// Whether only they know of the job.
    hidden: bool,
    left: bool,
}

impl Waiters {
    /// The job was made for a request that has not told its client of it.
    pub(crate) fn hide(&self) {
        self.0.lock().hidden = true;
    }

    /// A client is told of the job.
    pub(crate) fn tell(&self) {
        self.0.lock().hidden = false;
    }

    /// A request waits for it; false if the job ends, since the last one has left.
    pub(crate) fn join(&self) -> bool {
        let mut state = self.0.lock();
        state.waiting += usize::from(!state.left);
        !state.left
    }

    /// A request leaves. Whether nobody is left who knows of the job.
    pub(crate) fn leave(&self) -> bool {
        let mut state = self.0.lock();
        state.waiting -= 1;
        state.left = state.hidden && state.waiting == 0;
        state.left
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_request_leaves_a_hidden_job_alone() {
        let waiters = Waiters::default();
        // The second one joins before the first has hidden the job.
        assert!(waiters.join());
        waiters.hide();
        assert!(waiters.join() && !waiters.leave() && waiters.leave());
        assert!(!waiters.join(), "it ends");
    }

    #[test]
    fn a_job_that_a_client_was_told_of_stays() {
        let waiters = Waiters::default();
        waiters.hide();
        assert!(waiters.join() && waiters.join());
        waiters.tell();
        assert!(!waiters.leave() && !waiters.leave() && waiters.join());
    }
}
