//! Claims of a worker: requests jobs of one kind at each server behind a name, runs as many as the
//! worker has slots, and returns leases at shutdown. Independent of the kind.

use std::collections::HashMap;
use std::net::IpAddr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use brood_protocol::{ClaimRequest, ClientError, WorkerClient};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::task::JoinSet;
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use crate::backoff::Backoff;
use crate::lease::{
    JobKind, OTHER_VERSION_WAIT, RetryPolicy, WARN_AFTER_FAILURES, WorkerError, send_with_retry,
};

/// Longest time that a server may delay its answer if it has no job, in milliseconds.
pub(crate) const LONG_POLL_MS: u32 = 20_000;
/// Longest time that a slot is reserved for the answer of one server.
const RESERVED: Duration = Duration::from_millis(250);
/// Interval at which the server's name is resolved again.
pub(crate) const RESOLVE: Duration = Duration::from_secs(5);
/// Interval between warnings of servers of another version.
const WARN_INTERVAL: Duration = Duration::from_secs(60);
/// Time for returning a lease for which no slot was free. A lease not returned by then expires.
const RETURN_LIMIT: Duration = Duration::from_secs(10);
/// Time for returning leases at shutdown. Leases not returned by then expire.
const SHUTDOWN_GRACE: Duration = Duration::from_secs(3);

/// Lease that answers a request of a kind.
type Grant<K> = <<K as JobKind>::Request as ClaimRequest>::Grant;
/// Permission to run one job.
type Slot = OwnedSemaphorePermit;

/// Servers behind a name.
pub(crate) trait Servers: Sync {
    /// Returns the addresses of the servers. Empty if there is no name, and if it cannot be
    /// resolved now.
    fn resolve(&self) -> impl Future<Output = Vec<IpAddr>> + Send;

    /// Returns a client of the server at an address; `None` for any of them.
    ///
    /// # Errors
    /// Returns the error of the HTTP client's construction.
    fn client(&self, address: Option<IpAddr>) -> Result<WorkerClient, ClientError>;
}

impl Servers for WorkerClient {
    async fn resolve(&self) -> Vec<IpAddr> {
        self.addresses().await
    }

    fn client(&self, address: Option<IpAddr>) -> Result<WorkerClient, ClientError> {
        address.map_or_else(|| Ok(self.clone()), |address| self.at(address))
    }
}

/// Leases and runs jobs until `shutdown` is cancelled or a server rejects the token. Then cancels
/// `shutdown`, which the jobs observe, and waits until they have returned their leases.
///
/// # Errors
/// Returns [`WorkerError::Refused`] if a server rejects the token.
pub(crate) async fn run_jobs<K: JobKind>(
    client: &WorkerClient,
    worker: &str,
    kind: K,
    shutdown: CancellationToken,
) -> Result<(), WorkerError> {
    let name = kind.name();
    tracing::info!(server = client.server(), worker, kind = name, "requesting jobs");
    let claims = Claims::new(worker, kind.concurrent(), shutdown.clone());
    // The end of the claims drops requests that were sent. That closes their connections, and a
    // server takes back the job of a request whose connection is closed. The lease of a grant that
    // is already on its way expires.
    let result = tokio::select! {
        result = claim_at_all(client, &claims, kind, RESOLVE) => result,
        () = shutdown.cancelled() => Ok(()),
    };
    shutdown.cancel();
    claims.jobs.close();
    if tokio::time::timeout(SHUTDOWN_GRACE, claims.jobs.wait()).await.is_err() {
        tracing::warn!(kind = name, "some leases were not returned in time; they will expire");
    }
    result
}

/// Jobs of one kind in a worker.
#[derive(Debug, Clone)]
pub(crate) struct Claims {
    worker: String,
    /// Slots for jobs. Waiting polls receive them in turn.
    slots: Arc<Semaphore>,
    /// True if several servers are polled.
    is_shared: Arc<AtomicBool>,
    /// Time of the last warning of a server of another version.
    warned: Arc<Mutex<Option<Instant>>>,
    jobs: TaskTracker,
    shutdown: CancellationToken,
}

impl Claims {
    pub(crate) fn new(worker: &str, concurrent: usize, shutdown: CancellationToken) -> Self {
        Self {
            worker: worker.to_owned(),
            slots: Arc::new(Semaphore::new(concurrent)),
            is_shared: Arc::default(),
            warned: Arc::default(),
            jobs: TaskTracker::new(),
            shutdown,
        }
    }

    /// Warns of a server of another version, at most once a minute.
    fn warn_of_version(&self, kind: &str, reason: &str) {
        let mut warned = self.warned.lock().expect("no code panics while holding this lock");
        if warned.is_none_or(|last| last.elapsed() >= WARN_INTERVAL) {
            *warned = Some(Instant::now());
            tracing::warn!(kind, reason, "a server gives no jobs to this worker; trying again");
        }
    }
}

/// Leases jobs at each address of the servers, as a render job can be claimed only at the server
/// that has queued it. Resolves the name again after each `interval`. Returns only if a server
/// rejects the token.
///
/// One task polls each server. It waits for its turn at a free slot, and claims a job without delay
/// while the slot is reserved; if the server has none, it frees the slot and waits for a job by a
/// long poll. A claim that was sent is never dropped, as a lost grant counts as a death of this
/// worker: a grant without a free slot, possible only after a long poll, is returned at once, and
/// the server is polled again at the next free slot. With a single server, there are long polls
/// only.
pub(crate) async fn claim_at_all<K: JobKind>(
    servers: &impl Servers,
    claims: &Claims,
    kind: K,
    interval: Duration,
) -> Result<(), WorkerError> {
    let mut tasks = JoinSet::new();
    let mut polls: HashMap<Option<IpAddr>, (tokio::task::Id, PollState)> = HashMap::new();
    loop {
        let found = servers.resolve().await;
        if !found.is_empty() || polls.is_empty() {
            let is_unreachable = |address: IpAddr| {
                polls.get(&Some(address)).is_some_and(|(_, poll)| poll.is_unreachable())
            };
            let wanted: Vec<_> = match preferred(found, is_unreachable) {
                addresses if addresses.is_empty() => vec![None],
                addresses => addresses.into_iter().map(Some).collect(),
            };
            claims.is_shared.store(wanted.len() > 1, Ordering::Relaxed);
            polls.retain(|address, (_, poll)| {
                let stays = wanted.contains(address);
                if !stays {
                    poll.end.cancel();
                }
                stays
            });
            for address in wanted {
                if polls.contains_key(&address) {
                    continue;
                }
                let client = servers.client(address).map_err(WorkerError::Client)?;
                let state = PollState::default();
                let poll = Poll {
                    kind: kind.clone().at(client.clone()),
                    client,
                    claims: claims.clone(),
                    state: state.clone(),
                };
                polls.insert(address, (tasks.spawn(poll.run()).id(), state));
            }
        }
        let mut round = std::pin::pin!(tokio::time::sleep(interval));
        loop {
            let ended = tokio::select! {
                Some(ended) = tasks.join_next_with_id() => ended,
                () = &mut round => break,
            };
            let task = match ended {
                Ok((task, result)) => {
                    result?;
                    task
                }
                Err(error) => {
                    tracing::error!(kind = kind.name(), %error, "a poll failed; restarting it");
                    error.id()
                }
            };
            // The next round starts a poll of an address that has none.
            polls.retain(|_, (id, _)| *id != task);
        }
    }
}

/// Returns the addresses to poll: those of IP version 4, as a server may have one of each version;
/// those of version 6 if there are no others. While no address of the preferred version can be
/// reached, all.
pub(crate) fn preferred(
    found: Vec<IpAddr>,
    is_unreachable: impl Fn(IpAddr) -> bool,
) -> Vec<IpAddr> {
    let (mut first, mut second): (Vec<_>, Vec<_>) = found.into_iter().partition(IpAddr::is_ipv4);
    if first.is_empty() {
        std::mem::swap(&mut first, &mut second);
    }
    if first.iter().all(|address| is_unreachable(*address)) {
        first.append(&mut second);
    }
    first
}

/// State of a poll, shared with its task.
#[derive(Debug, Clone, Default)]
struct PollState {
    /// Ends the poll after its present claim.
    end: CancellationToken,
    /// True if the server could not be reached repeatedly.
    is_unreachable: Arc<AtomicBool>,
}

impl PollState {
    fn is_unreachable(&self) -> bool {
        self.is_unreachable.load(Ordering::Relaxed)
    }
}

/// Task that claims the jobs of one server.
struct Poll<K> {
    client: WorkerClient,
    claims: Claims,
    kind: K,
    state: PollState,
}

impl<K: JobKind> Poll<K> {
    /// Leases jobs and spawns a task for each, until the poll is ended.
    ///
    /// # Errors
    /// Returns [`WorkerError::Refused`] if the server rejects the token.
    async fn run(self) -> Result<(), WorkerError> {
        let (mut backoff, kind) = (Backoff::default(), self.kind.name());
        let mut is_other_version = false;
        loop {
            let slot = tokio::select! {
                biased;
                () = self.state.end.cancelled() => return Ok(()),
                slot = self.claims.slots.clone().acquire_owned() => slot,
            };
            let slot = slot.expect("the semaphore is never closed");
            let has_failed = is_other_version || backoff.failures() > 0;
            let error = match self.claim(slot, has_failed).await {
                Ok(granted) => {
                    is_other_version = false;
                    if backoff.failures() >= WARN_AFTER_FAILURES {
                        tracing::info!(kind, "the server responds again");
                    }
                    backoff.reset();
                    self.state.is_unreachable.store(false, Ordering::Relaxed);
                    if let Some((grant, slot)) = granted {
                        self.start(grant, slot);
                    }
                    continue;
                }
                Err(error @ ClientError::Refused(_)) => return Err(WorkerError::Refused(error)),
                Err(error) => error,
            };
            is_other_version = matches!(error, ClientError::OtherVersion(_));
            if is_other_version {
                // Servers and workers are being upgraded.
                self.claims.warn_of_version(kind, &error.to_string());
                backoff.reset();
                self.state.is_unreachable.store(false, Ordering::Relaxed);
                self.pause(OTHER_VERSION_WAIT).await;
                continue;
            }
            let wait = backoff.next();
            // A single failure is normal while a server restarts. Warn once if failures continue.
            if backoff.failures() == WARN_AFTER_FAILURES {
                tracing::warn!(kind, %error, "cannot lease jobs from the server; retrying");
            } else {
                tracing::debug!(kind, %error, "no job leased");
            }
            let is_unreachable = error.is_unanswered() && backoff.failures() >= WARN_AFTER_FAILURES;
            self.state.is_unreachable.store(is_unreachable, Ordering::Relaxed);
            self.pause(wait).await;
        }
    }

    /// Waits for this time or until the poll is ended.
    async fn pause(&self, time: Duration) {
        let _ = self.state.end.run_until_cancelled(tokio::time::sleep(time)).await;
    }

    /// Requests a job. Returns it with the slot if that is still reserved; `None` if there was none
    /// in time. No slot is reserved if the server `has_failed`: that would keep it from others.
    async fn claim(
        &self,
        slot: Slot,
        has_failed: bool,
    ) -> Result<Option<(Grant<K>, Option<Slot>)>, ClientError> {
        if self.claims.is_shared.load(Ordering::Relaxed) && !has_failed {
            let request = self.kind.request(&self.claims.worker, 0);
            let mut claim = std::pin::pin!(self.client.claim(&request));
            let (granted, slot) = match tokio::time::timeout(RESERVED, &mut claim).await {
                Ok(answer) => (answer?, Some(slot)),
                Err(_) => {
                    drop(slot);
                    (claim.await?, None)
                }
            };
            if let Some(grant) = granted {
                return Ok(Some((grant, slot)));
            }
            if self.state.end.is_cancelled() {
                return Ok(None);
            }
        } else {
            drop(slot);
        }
        let request = self.kind.request(&self.claims.worker, LONG_POLL_MS);
        let granted = self.client.claim(&request).await?;
        Ok(granted.map(|grant| (grant, None)))
    }

    /// Runs a job in its slot or a free one. Returns its lease if there is none.
    fn start(&self, grant: Grant<K>, slot: Option<Slot>) {
        let slot = slot.or_else(|| self.claims.slots.clone().try_acquire_owned().ok());
        if let Some(slot) = slot {
            let run = self.kind.clone().run(grant);
            self.claims.jobs.spawn(async move {
                run.await;
                drop(slot);
            });
            return;
        }
        let (job, ticket) = K::lease(&grant);
        let (client, shutdown) = (self.client.clone(), self.claims.shutdown.clone());
        self.claims.jobs.spawn(async move {
            let policy = RetryPolicy { limit: Some(RETURN_LIMIT), repeats_server_errors: true };
            let release = || client.release(&ticket);
            let sent = send_with_retry(policy, (job, "return a job"), &shutdown, release).await;
            match sent {
                Ok(()) => tracing::debug!(%job, "job returned: no slot is free"),
                Err(error) => {
                    tracing::debug!(%job, %error, "cannot return the lease; it will expire");
                }
            }
        });
    }
}
