//! Memory of request bodies while they arrive, and the rates at which they have to.
//!
//! A body holds permits for the bytes that have arrived, so a declared size costs nothing. If there
//! is too little memory for another body, the largest of those that arrive slowly is given up.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use tokio::sync::{Notify, Semaphore, SemaphorePermit};
use tokio::time::Instant;

use crate::client::Client;
use crate::limit;
use crate::problem::ApiError;

/// Time after which the rate of a body is known.
const RATED: Duration = Duration::from_secs(2);
/// Longest wait for the memory of a body that is given up.
const GIVE_UP: Duration = Duration::from_secs(1);

/// Memory of bodies, in bytes, without the first [`limit::BODY_FREE`] of each.
pub struct BodyBudget {
    permits: Semaphore,
    /// Bodies that are arriving and hold permits.
    arriving: Mutex<Vec<Arc<Arrival>>>,
    /// Most bodies of one client that are arriving and hold permits.
    each: usize,
}

/// A body that is arriving.
struct Arrival {
    client: Client,
    progress: Mutex<Progress>,
    /// Notified if its memory is taken.
    taken: Notify,
}

/// Bytes of a body so far.
#[derive(Clone, Copy)]
struct Progress {
    received: usize,
    /// Start of the time over which the rate is measured, and bytes received before.
    since: Instant,
    before: usize,
}

impl Progress {
    /// True if the rate is known and below [`limit::BODY_RATE_SPARED`].
    fn is_slow(&self) -> bool {
        let seconds = self.since.elapsed();
        let bytes = (self.received - self.before) as f64;
        seconds >= RATED && bytes < limit::BODY_RATE_SPARED as f64 * seconds.as_secs_f64()
    }
}

/// Memory of one body.
pub struct BodyMemory {
    budget: &'static BodyBudget,
    arrival: Arc<Arrival>,
    permits: Option<SemaphorePermit<'static>>,
}

impl BodyBudget {
    /// Creates a budget of this memory, for at most `each` bodies of a client at the same time.
    pub const fn new(bytes: usize, each: usize) -> Self {
        Self { permits: Semaphore::const_new(bytes), arriving: Mutex::new(Vec::new()), each }
    }

    /// Begins a body.
    pub fn body(&'static self) -> BodyMemory {
        let progress = Progress { received: 0, since: Instant::now(), before: 0 };
        let (client, progress) = (Client::current(), Mutex::new(progress));
        let arrival = Arrival { client, progress, taken: Notify::new() };
        BodyMemory { budget: self, arrival: Arc::new(arrival), permits: None }
    }

    fn arriving(&self) -> std::sync::MutexGuard<'_, Vec<Arc<Arrival>>> {
        self.arriving.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Gives up the largest of the slow bodies; false if there is none.
    fn give_up_slow(&self) -> bool {
        let arriving = self.arriving();
        let slow = arriving.iter().map(|arrival| (arrival, arrival.progress()));
        let slow = slow.filter(|(_, progress)| progress.is_slow());
        let largest = slow.max_by_key(|(_, progress)| progress.received);
        largest.is_some_and(|(arrival, _)| {
            arrival.taken.notify_one();
            true
        })
    }
}

impl Arrival {
    fn progress(&self) -> Progress {
        *self.progress.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl BodyMemory {
    /// Time at which the next bytes must have arrived.
    pub fn deadline(&self) -> Instant {
        self.arrival.progress().since + limit::BODY
    }

    /// Completes if the memory is needed for another body.
    pub async fn taken(&self) {
        self.arrival.taken.notified().await;
    }

    /// Counts bytes that have arrived; returns the number of all so far.
    pub fn add(&mut self, bytes: usize) -> usize {
        let mut progress = self.arrival.progress.lock().unwrap_or_else(PoisonError::into_inner);
        progress.received += bytes;
        let enough = limit::BODY_RATE * limit::BODY.as_secs() as usize;
        if progress.received - progress.before >= enough {
            (progress.since, progress.before) = (Instant::now(), progress.received);
        }
        progress.received
    }

    /// Takes memory for all bytes that have arrived.
    ///
    /// # Errors
    /// 503 if there is too little and no slow body to give up, or if the client sends too many
    /// large bodies at once.
    pub async fn reserve(&mut self) -> Result<(), ApiError> {
        let held = self.permits.as_ref().map_or(0, SemaphorePermit::num_permits);
        let more = self.arrival.progress().received.saturating_sub(limit::BODY_FREE + held);
        if more == 0 {
            return Ok(());
        }
        let client = self.arrival.client;
        if self.permits.is_none() && client != Client::Server {
            let arriving = self.budget.arriving();
            let own = arriving.iter().filter(|arrival| arrival.client == client).count();
            if own >= self.budget.each {
                let words = format!("this client is sending {own} large bodies; retry later");
                return Err(ApiError::busy(words));
            }
        }
        let busy = || ApiError::busy("too many large bodies are being read; retry later");
        let more = u32::try_from(more).map_err(|_| busy())?;
        let free = &self.budget.permits;
        let more = match free.try_acquire_many(more) {
            Ok(more) => more,
            Err(_) if self.budget.give_up_slow() => {
                let waited = tokio::time::timeout(GIVE_UP, free.acquire_many(more)).await;
                waited.map_err(|_| busy())?.map_err(|_| busy())?
            }
            Err(_) => return Err(busy()),
        };
        match &mut self.permits {
            Some(permits) => permits.merge(more),
            None => {
                self.permits = Some(more);
                self.budget.arriving().push(self.arrival.clone());
            }
        }
        Ok(())
    }

    /// Permits for the memory of the body, which has arrived.
    pub fn into_permits(mut self) -> Option<SemaphorePermit<'static>> {
        self.permits.take()
    }
}

impl Drop for BodyMemory {
    fn drop(&mut self) {
        self.budget.arriving().retain(|arrival| !Arc::ptr_eq(arrival, &self.arrival));
    }
}
