//! Claim loop of a worker that searches, and a leased search from grant to end.
//!
//! Every search has its own thread pool; the operating system shares the cores among them.

use std::num::NonZeroUsize;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use brood_protocol::{
    ClientError, Directive, SearchGrant, SearchReport, SearchRequest, SearchTicket, SearchUpdate,
    WorkerClient,
};
use brood_search::{TargetFile, TargetKind};
use moka::sync::Cache;
use tokio::sync::Semaphore;
use tokio::task::JoinSet;
use tokio_util::sync::CancellationToken;

use crate::backoff::Backoff;
use crate::claim::{LONG_POLL, SHUTDOWN_GRACE, WARN_AFTER_FAILURES, WorkerError};
use crate::job::HEARTBEAT;
use crate::search_run::{SearchRun, StepBatch};

/// Number of concurrent searches of a worker. Other searches wait for a time slice.
const CONCURRENT_SEARCHES: usize = 4;
/// Size of the target cache in KiB. Image targets are large: they contain the sample sets of their
/// views.
const TARGETS_KIB: u64 = 512 << 10;

/// Configuration of a worker that searches.
#[derive(Debug, Clone)]
pub struct SearcherConfig {
    /// URL of the server.
    pub server: String,
    /// Token with the scope `work`.
    pub token: String,
    /// Name for logs.
    pub name: String,
    /// Number of threads of a search that does not specify one; `None` for all cores.
    pub threads: Option<NonZeroUsize>,
}

/// Runs searches until `shutdown` is cancelled.
///
/// # Errors
/// Returns [`WorkerError::Refused`] if the server rejects the token, [`WorkerError::Client`] if the
/// HTTP client cannot be set up.
pub async fn run_searches(
    config: SearcherConfig,
    shutdown: CancellationToken,
) -> Result<(), WorkerError> {
    let client = WorkerClient::new(&config.server, &config.token).map_err(WorkerError::Client)?;
    let stop = shutdown.child_token();
    let context = SearchContext {
        client,
        targets: Cache::builder().max_capacity(TARGETS_KIB).weigher(weigh).build(),
        threads: config.threads,
        shutdown: stop.clone(),
    };
    let mut searches = JoinSet::new();
    let result = claim(&config, &context, &mut searches).await;
    stop.cancel();
    let finished = async { while searches.join_next().await.is_some() {} };
    if tokio::time::timeout(SHUTDOWN_GRACE, finished).await.is_err() {
        tracing::warn!("some leases of searches were not returned in time; they will expire");
    }
    result
}

/// Leases searches and spawns a task for each.
async fn claim(
    config: &SearcherConfig,
    context: &SearchContext,
    searches: &mut JoinSet<()>,
) -> Result<(), WorkerError> {
    let slots = Arc::new(Semaphore::new(CONCURRENT_SEARCHES));
    let mut backoff = Backoff::default();
    tracing::info!(server = config.server, worker = config.name, "requesting searches");
    loop {
        while searches.try_join_next().is_some() {}
        let slot = tokio::select! {
            slot = slots.clone().acquire_owned() => slot.expect("the semaphore is never closed"),
            () = context.shutdown.cancelled() => return Ok(()),
        };
        let wait_ms = u32::try_from(LONG_POLL.as_millis()).expect("seconds");
        let request = SearchRequest { worker: config.name.clone(), wait_ms };
        let answer = tokio::select! {
            answer = context.client.lease_search(&request) => answer,
            () = context.shutdown.cancelled() => return Ok(()),
        };
        match answer {
            Ok(grant) => {
                backoff.reset();
                if let Some(grant) = grant {
                    let context = context.clone();
                    searches.spawn(async move {
                        context.run(grant).await;
                        drop(slot);
                    });
                }
            }
            Err(error @ ClientError::Refused(_)) => return Err(WorkerError::Refused(error)),
            Err(error) => {
                let wait = backoff.next();
                if backoff.failures() == WARN_AFTER_FAILURES {
                    tracing::warn!(%error, "cannot lease searches from the server; retrying");
                }
                tokio::select! {
                    () = tokio::time::sleep(wait) => {}
                    () = context.shutdown.cancelled() => return Ok(()),
                }
            }
        }
    }
}

/// Resources that a worker shares among its searches.
#[derive(Clone)]
struct SearchContext {
    client: WorkerClient,
    targets: Cache<[u8; 32], Arc<TargetFile>>,
    threads: Option<NonZeroUsize>,
    shutdown: CancellationToken,
}

/// Reason for stopping a search.
enum StopReason {
    /// The search is complete, the server has answered [`Directive::Stop`], or the lease is no
    /// longer valid: nothing remains to be reported.
    Done,
    /// Permanent failure.
    Failed(String),
    /// The search is returned to the queue for another worker.
    Release(String),
}

impl From<ClientError> for StopReason {
    fn from(error: ClientError) -> Self {
        match error {
            ClientError::Stale => Self::Done,
            ClientError::Wire(error) => Self::Failed(error.to_string()),
            ClientError::Status { status, detail } if status.is_client_error() => {
                Self::Failed(format!("the server rejected a request ({status}): {detail}"))
            }
            error => Self::Release(error.to_string()),
        }
    }
}

impl SearchContext {
    /// Runs one search. Errors are handled here: the lease is returned or expires.
    async fn run(self, grant: SearchGrant) {
        let (ticket, job) = (grant.ticket, grant.ticket.job);
        let ttl = Duration::from_millis(grant.ttl_ms.into());
        let stop = Arc::new(AtomicBool::new(false));
        let reason = tokio::select! {
            reason = self.search(grant, &stop) => reason,
            () = self.renew_lease(&ticket, ttl) => StopReason::Done,
            () = self.shutdown.cancelled() => StopReason::Release("shutting down".to_owned()),
        };
        // A computation that is still running checks this flag after each generation.
        stop.store(true, Ordering::Relaxed);
        let sent = match reason {
            StopReason::Done => return tracing::debug!(%job, "search ended"),
            StopReason::Failed(reason) => {
                tracing::warn!(%job, reason, "search failed");
                let update = SearchUpdate::Failed(reason);
                self.client.report_search(&SearchReport { ticket, update }).await.map(drop)
            }
            StopReason::Release(reason) => {
                tracing::info!(%job, reason, "search returned to the queue");
                self.client.release_search(&ticket).await
            }
        };
        if let Err(error) = sent {
            tracing::debug!(%job, %error, "cannot return the search; its lease will expire");
        }
    }

    /// Runs a search to its end, or until the server answers [`Directive::Stop`].
    async fn search(&self, grant: SearchGrant, stop: &Arc<AtomicBool>) -> StopReason {
        match self.run_search(grant, stop).await {
            Ok(()) => StopReason::Done,
            Err(reason) => reason,
        }
    }

    async fn run_search(
        &self,
        grant: SearchGrant,
        stop: &Arc<AtomicBool>,
    ) -> Result<(), StopReason> {
        let target = self.target(&grant).await?;
        let threads = grant.threads.and_then(|n| usize::try_from(n).ok());
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let threads = threads.or(self.threads.map(usize::from)).unwrap_or(cores).min(cores);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.map_err(|error| StopReason::Release(error.to_string()))?;
        let pool = Arc::new(pool);
        let ticket = grant.ticket;
        let mut run = blocking(&pool, move || SearchRun::new(grant, target))
            .await?
            .map_err(StopReason::Failed)?;
        loop {
            let (back, batch) = blocking(&pool, {
                let stop = stop.clone();
                move || {
                    let batch = run.step_batch(&stop);
                    (run, batch)
                }
            })
            .await?;
            run = back;
            let StepBatch { update, is_over } = batch.map_err(StopReason::Failed)?;
            if let Some(update) = update
                && self.report(ticket, update).await? == Directive::Stop
            {
                return Ok(());
            }
            if is_over {
                let stop = stop.clone();
                let update = blocking(&pool, move || run.finish(&stop)).await?;
                self.report(ticket, update.map_err(StopReason::Failed)?).await?;
                return Ok(());
            }
        }
    }

    /// Returns the target, from the cache if possible.
    async fn target(&self, grant: &SearchGrant) -> Result<Arc<TargetFile>, StopReason> {
        let hash = grant.target_hash;
        if let Some(target) = self.targets.get(&hash) {
            return Ok(target);
        }
        let kind: Result<TargetKind, _> = grant.target_kind.parse();
        let kind = kind.map_err(|_| {
            StopReason::Failed("server and worker are of different versions".to_owned())
        })?;
        let bytes = self.client.target(&hash).await?;
        let read = tokio::task::spawn_blocking(move || TargetFile::read(kind, &bytes)).await;
        let read =
            read.map_err(|_| StopReason::Failed("reading the target panicked".to_owned()))?;
        let target = Arc::new(read.map_err(|error| StopReason::Failed(error.to_string()))?);
        self.targets.insert(hash, target.clone());
        Ok(target)
    }

    /// Sends a report, with retries for as long as it takes: a full disk or a busy server delays a
    /// search and does not fail it.
    async fn report(
        &self,
        ticket: SearchTicket,
        update: SearchUpdate,
    ) -> Result<Directive, StopReason> {
        let report = SearchReport { ticket, update };
        let mut backoff = Backoff::default();
        loop {
            let error = match self.client.report_search(&report).await {
                Ok(directive) => return Ok(directive),
                Err(error @ (ClientError::Transport(_) | ClientError::Busy)) => error,
                Err(error @ ClientError::Status { status, .. }) if status.is_server_error() => {
                    error
                }
                Err(error) => return Err(error.into()),
            };
            let wait = backoff.next();
            if backoff.failures() == WARN_AFTER_FAILURES {
                tracing::warn!(job = %ticket.job, %error, "cannot report progress; retrying");
            }
            tokio::time::sleep(wait).await;
        }
    }

    /// Renews the lease periodically. Returns only if the lease is lost.
    async fn renew_lease(&self, ticket: &SearchTicket, ttl: Duration) {
        let period = HEARTBEAT.min(ttl / 4).max(Duration::from_millis(50));
        loop {
            tokio::time::sleep(period).await;
            match self.client.heartbeat_search(ticket).await {
                Ok(()) => {}
                Err(ClientError::Stale) => return,
                Err(error) => tracing::debug!(%error, "heartbeat failed"),
            }
        }
    }
}

fn weigh(_: &[u8; 32], target: &Arc<TargetFile>) -> u32 {
    u32::try_from(target.bytes() / 1024 + 1).unwrap_or(u32::MAX)
}

/// Runs a closure on the thread pool of a search. A panic fails this search only.
async fn blocking<T: Send + 'static>(
    pool: &Arc<rayon::ThreadPool>,
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<T, StopReason> {
    let pool = pool.clone();
    let done = tokio::task::spawn_blocking(move || pool.install(work)).await;
    done.map_err(|_| StopReason::Failed("the search panicked".to_owned()))
}
