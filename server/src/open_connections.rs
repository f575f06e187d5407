//! Open connections, limited in number. At the limit, a new connection closes the one that has been
//! idle the longest.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio_util::sync::CancellationToken;

use crate::connection::Requests;

/// Time after which a new connection looks again for an idle one to close.
const AGAIN: Duration = Duration::from_millis(20);

/// The open connections of a server.
pub struct OpenConnections {
    free: Arc<Semaphore>,
    open: Arc<Mutex<Vec<Arc<Open>>>>,
}

struct Open {
    requests: Arc<Requests>,
    cut: CancellationToken,
}

/// Place of an open connection, free again when dropped.
pub struct ConnectionPlace {
    open: Arc<Mutex<Vec<Arc<Open>>>>,
    own: Arc<Open>,
    _permit: OwnedSemaphorePermit,
}

impl OpenConnections {
    /// Creates places for this many connections.
    pub fn new(most: usize) -> Self {
        Self { free: Arc::new(Semaphore::new(most)), open: Arc::default() }
    }

    /// Waits for a place. At the limit, closes the connection that has been idle the longest.
    pub async fn place(&self, requests: Arc<Requests>) -> ConnectionPlace {
        let permit = loop {
            if let Ok(permit) = self.free.clone().try_acquire_owned() {
                break permit;
            }
            self.cut_idle();
            let freed = tokio::time::timeout(AGAIN, self.free.clone().acquire_owned()).await;
            if let Ok(permit) = freed {
                break permit.expect("the semaphore is never closed");
            }
        };
        let own = Arc::new(Open { requests, cut: CancellationToken::new() });
        lock(&self.open).push(own.clone());
        ConnectionPlace { open: self.open.clone(), own, _permit: permit }
    }

    /// Number of open connections.
    pub fn len(&self) -> usize {
        lock(&self.open).len()
    }

    /// Closes the connection that has been idle the longest, if one is idle.
    fn cut_idle(&self) {
        let open = lock(&self.open);
        let waiting = open.iter().filter(|open| !open.cut.is_cancelled());
        let idle = waiting.filter_map(|open| Some((open.requests.idle_since()?, open)));
        if let Some((_, open)) = idle.min_by_key(|(since, _)| *since) {
            open.cut.cancel();
        }
    }
}

impl ConnectionPlace {
    /// Cancelled when the connection must be closed for a new one.
    pub fn cut(&self) -> CancellationToken {
        self.own.cut.clone()
    }
}

impl Drop for ConnectionPlace {
    fn drop(&mut self) {
        lock(&self.open).retain(|open| !Arc::ptr_eq(open, &self.own));
    }
}

fn lock(open: &Mutex<Vec<Arc<Open>>>) -> MutexGuard<'_, Vec<Arc<Open>>> {
    open.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test(start_paused = true)]
    async fn longest_idle_connection_gives_way_and_busy_ones_do_not() {
        let connections = OpenConnections::new(3);
        let requests: Vec<Arc<Requests>> = (0..4).map(|_| Arc::default()).collect();
        let mut places = Vec::new();
        for requests in &requests[..3] {
            places.push(connections.place(requests.clone()).await);
            tokio::time::sleep(Duration::from_secs(1)).await;
        }
        let busy = requests[0].begin();
        let cut: Vec<_> = places.iter().map(ConnectionPlace::cut).collect();
        let is_cut = || cut.iter().map(CancellationToken::is_cancelled).collect::<Vec<_>>();
        let given = tokio::spawn({
            let cut = places[1].cut();
            let place = places.remove(1);
            async move {
                cut.cancelled().await;
                drop(place);
            }
        });
        let fourth = connections.place(requests[3].clone()).await;
        given.await.unwrap();
        assert_eq!(is_cut(), [false, true, false]);
        drop((busy, fourth));
        assert!(connections.free.available_permits() == 1);
    }

    #[tokio::test(start_paused = true)]
    async fn connection_waits_while_all_others_are_busy() {
        let connections = OpenConnections::new(1);
        let requests = Arc::new(Requests::default());
        let place = connections.place(requests.clone()).await;
        let busy = requests.begin();
        let next = connections.place(Arc::default());
        let waited = tokio::time::timeout(Duration::from_secs(60), next).await;
        assert!(waited.is_err() && !place.cut().is_cancelled());
        drop(busy);
        let next = connections.place(Arc::default());
        let waited = tokio::time::timeout(Duration::from_secs(1), next).await;
        assert!(waited.is_err() && place.cut().is_cancelled(), "the place is still held");
    }
}
