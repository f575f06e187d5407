//! The searches that are out, on the monotonic clock.

use std::collections::HashMap;
use std::sync::{Mutex, MutexGuard};
use std::time::Duration;

use brood_protocol::{JobId, SearchTicket};
use tokio::time::Instant;

use crate::limit;

/// The searches that are out.
#[derive(Debug, Default)]
pub struct Holds {
    holds: Mutex<HashMap<JobId, Hold>>,
}

#[derive(Debug)]
struct Hold {
    epoch: u64,
    worker: String,
    granted: Instant,
    deadline: Instant,
}

impl Holds {
    /// Gives a search out; whoever had it has it no more.
    pub fn grant(&self, ticket: SearchTicket, worker: &str) {
        let granted = Instant::now();
        let deadline = granted + limit::LEASE;
        let hold = Hold { epoch: ticket.epoch, worker: worker.to_owned(), granted, deadline };
        self.lock().insert(ticket.job, hold);
    }

    /// Keeps a lease and says how long it has been held; `None` where it is not this holder's any more.
    pub fn renew(&self, ticket: &SearchTicket) -> Option<Duration> {
        let mut holds = self.lock();
        let hold = holds.get_mut(&ticket.job).filter(|hold| hold.epoch == ticket.epoch)?;
        hold.deadline = Instant::now() + limit::LEASE;
        Some(hold.granted.elapsed())
    }

    /// Ends a lease; false where it is not this holder's any more.
    pub fn end(&self, ticket: &SearchTicket) -> bool {
        let mut holds = self.lock();
        let is_held = holds.get(&ticket.job).is_some_and(|hold| hold.epoch == ticket.epoch);
        is_held && holds.remove(&ticket.job).is_some()
    }

    /// Ends the lease of a search, whoever has it.
    pub fn forget(&self, job: JobId) {
        self.lock().remove(&job);
    }

    /// Ends those that nobody has kept.
    pub fn expire(&self) -> Vec<SearchTicket> {
        let now = Instant::now();
        self.take(|hold| hold.deadline <= now)
    }

    /// Ends those of one worker.
    pub fn end_those_of(&self, worker: &str) -> Vec<SearchTicket> {
        self.take(|hold| hold.worker == worker)
    }

    /// Ends all.
    pub fn end_all(&self) -> Vec<SearchTicket> {
        self.take(|_| true)
    }

    fn take(&self, which: impl Fn(&Hold) -> bool) -> Vec<SearchTicket> {
        let mut holds = self.lock();
        let taken = holds.extract_if(|_, hold| which(hold));
        taken.map(|(job, hold)| SearchTicket { job, epoch: hold.epoch }).collect()
    }

    fn lock(&self) -> MutexGuard<'_, HashMap<JobId, Hold>> {
        self.holds.lock().expect("nothing panics under this lock")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test(start_paused = true)]
    async fn hold_lapses_unless_it_is_kept_and_ends_once() {
        let holds = Holds::default();
        let ticket = |epoch| SearchTicket { job: JobId::fresh(), epoch };
        let (kept, lost) = (ticket(1), ticket(2));
        holds.grant(kept, "a");
        holds.grant(lost, "b");
        tokio::time::advance(Duration::from_secs(15)).await;
        assert_eq!(holds.renew(&kept), Some(Duration::from_secs(15)));
        tokio::time::advance(Duration::from_secs(6)).await;
        assert_eq!(holds.expire(), [lost]);
        assert_eq!(holds.renew(&SearchTicket { epoch: 9, ..kept }), None);
        assert!(!holds.end(&SearchTicket { epoch: 9, ..kept }));
        assert!(holds.end(&kept) && !holds.end(&kept));
    }

    #[tokio::test]
    async fn holds_of_one_worker_end_without_the_others() {
        let holds = Holds::default();
        for worker in ["a", "a", "b"] {
            holds.grant(SearchTicket { job: JobId::fresh(), epoch: 1 }, worker);
        }
        assert_eq!(holds.end_those_of("a").len(), 2);
        assert_eq!(holds.end_all().len(), 1);
    }
}
