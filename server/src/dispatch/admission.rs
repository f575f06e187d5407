//! Admission of births: refused while the queue of their pictures is full. Otherwise births would
//! go on for which no picture comes in time.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use brood_protocol::Queue;
use brood_storage::Store;

use super::Workers;
use crate::limit;
use crate::problem::ApiError;

/// Time for which the state of the queue is remembered.
const REMEMBERED: Duration = Duration::from_millis(100);

/// State of the queue as last read.
#[derive(Debug, Default)]
pub struct Admission {
    read: Mutex<Option<(Instant, bool)>>,
}

impl Admission {
    /// Checks that a birth may add pictures to the queue. Without workers it may: its pictures are
    /// not expected.
    ///
    /// # Errors
    /// 503 if the queue is full.
    pub async fn check(&self, store: &Store, workers: &Workers) -> Result<(), ApiError> {
        let read = *self.read.lock().unwrap_or_else(PoisonError::into_inner);
        let is_full = match read.filter(|(when, _)| when.elapsed() < REMEMBERED) {
            Some((_, is_full)) => is_full,
            None => {
                let is_full = store.is_queue_full(Queue::Interactive, limit::QUEUED_JOBS).await?;
                let read = Some((Instant::now(), is_full));
                *self.read.lock().unwrap_or_else(PoisonError::into_inner) = read;
                is_full
            }
        };
        if is_full && !workers.present().0.is_empty() {
            return Err(ApiError::busy("too many pictures are queued; retry later"));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use brood_protocol::{JobId, WorkerReport};
    use brood_storage::NewJob;

    use super::*;
    use crate::config::ServerConfig;
    use crate::server::Server;

    #[tokio::test]
    async fn birth_is_refused_while_the_queue_is_full_and_workers_are_there() {
        let dir = tempfile::tempdir().unwrap();
        let address = "127.0.0.1:0".parse().unwrap();
        let config = ServerConfig::new(address, dir.path().to_owned());
        let app = Server::bind(config).await.unwrap().app();
        let check = || async { Admission::default().check(&app.store, &app.workers).await };
        app.workers.seen("a", &WorkerReport::default());
        check().await.unwrap();
        for _ in 0..limit::QUEUED_JOBS {
            let job = NewJob {
                id: JobId::fresh(),
                queue: Queue::Interactive,
                turn: 0,
                leased_to: None,
                payload: Vec::new(),
                created_ms: 1,
            };
            app.store.enqueue(job, limit::QUEUED_JOBS).await.unwrap();
        }
        assert_eq!(check().await.unwrap_err().status(), 503);
        let others = Workers::default();
        Admission::default().check(&app.store, &others).await.unwrap();
    }
}
