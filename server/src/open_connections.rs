//! Open connections, limited in number. At the limit, a new connection closes the one that has been
//! idle the longest. Connections of workers, which wait for jobs or render all the time, have a
//! limit of their own from their first request on.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::time::Duration;

use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio_util::sync::CancellationToken;

use crate::connection::Requests;

/// Time after which a new connection looks again for an idle one to close.
const AGAIN: Duration = Duration::from_millis(20);

/// The open connections of a server.
pub struct OpenConnections {
    free: Arc<Semaphore>,
    free_for_workers: Arc<Semaphore>,
    open: Arc<Mutex<Vec<Arc<Open>>>>,
}

struct Open {
    requests: Arc<Requests>,
    cut: CancellationToken,
    free_for_workers: Arc<Semaphore>,
    place: Mutex<Place>,
}

/// Place that a connection holds.
struct Place {
    is_workers: bool,
    _permit: OwnedSemaphorePermit,
}

/// Place of an open connection, free again when dropped.
pub struct ConnectionPlace {
    open: Arc<Mutex<Vec<Arc<Open>>>>,
    own: Arc<Open>,
}

/// Open connection, an extension of its requests.
#[derive(Clone)]
pub struct OpenConnection(Weak<Open>);

impl OpenConnection {
    /// Notes that a worker uses the connection: it takes a place of workers, if one is free, and
    /// leaves its own to others.
    pub fn serves_worker(&self) {
        let Some(open) = self.0.upgrade() else { return };
        let mut place = lock(&open.place);
        if !place.is_workers
            && let Ok(permit) = open.free_for_workers.clone().try_acquire_owned()
        {
            *place = Place { is_workers: true, _permit: permit };
        }
    }
}

impl Open {
    fn is_workers(&self) -> bool {
        lock(&self.place).is_workers
    }
}

impl OpenConnections {
    /// Creates places for this many connections, and for this many of workers.
    pub fn new(most: usize, most_of_workers: usize) -> Self {
        let [free, free_for_workers] = [most, most_of_workers].map(Semaphore::new).map(Arc::new);
        Self { free, free_for_workers, open: Arc::default() }
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
        let own = Arc::new(Open {
            requests,
            cut: CancellationToken::new(),
            free_for_workers: self.free_for_workers.clone(),
            place: Mutex::new(Place { is_workers: false, _permit: permit }),
        });
        lock(&self.open).push(own.clone());
        ConnectionPlace { open: self.open.clone(), own }
    }

    /// Number of open connections, and of those in places of workers.
    pub fn counts(&self) -> (usize, usize) {
        let open = lock(&self.open);
        (open.len(), open.iter().filter(|open| open.is_workers()).count())
    }

    /// Closes the connection that has been idle the longest, if one is idle.
    fn cut_idle(&self) {
        let open = lock(&self.open);
        // A place of workers is of no use to the new connection.
        let waiting = open.iter().filter(|open| !open.cut.is_cancelled() && !open.is_workers());
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

    /// The connection, for its requests.
    pub fn connection(&self) -> OpenConnection {
        OpenConnection(Arc::downgrade(&self.own))
    }
}

impl Drop for ConnectionPlace {
    fn drop(&mut self) {
        lock(&self.open).retain(|open| !Arc::ptr_eq(open, &self.own));
    }
}

fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test(start_paused = true)]
    async fn longest_idle_connection_gives_way_and_busy_ones_do_not() {
        let connections = OpenConnections::new(3, 0);
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
    async fn connections_of_workers_leave_their_places_to_others() {
        let connections = OpenConnections::new(1, 1);
        let worker = connections.place(Arc::default()).await;
        worker.connection().serves_worker();
        worker.connection().serves_worker();
        assert_eq!(connections.counts(), (1, 1));
        // It is idle, and is not closed for another.
        let person = connections.place(Arc::default()).await;
        assert!(!worker.cut().is_cancelled() && !person.cut().is_cancelled());
        // There is no second place of workers.
        person.connection().serves_worker();
        assert_eq!(connections.counts(), (2, 1));
        drop(worker);
        person.connection().serves_worker();
        assert_eq!(connections.counts(), (1, 1));
        drop(person);
        let free = [&connections.free, &connections.free_for_workers];
        assert_eq!(free.map(|free| free.available_permits()), [1, 1]);
    }

    #[tokio::test(start_paused = true)]
    async fn connection_waits_while_all_others_are_busy() {
        let connections = OpenConnections::new(1, 0);
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
