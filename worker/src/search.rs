//! Worker that searches: configuration and start, and a leased search from grant to end.
//!
//! Every search has its own thread pool; the operating system shares the cores among them.

use std::num::NonZeroUsize;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use brood_protocol::{
    ClientError, Directive, JobId, SearchGrant, SearchReport, SearchRequest, SearchTicket,
    SearchUpdate, WorkerClient, idle_thread_priority,
};
use brood_target::TargetKind;
use moka::sync::Cache;
use tokio_util::sync::CancellationToken;

use crate::claim::run_jobs;
use crate::lease::{
    HEARTBEAT, Interrupted, JobKind, RetryPolicy, WorkerError, leave_to_others, renew_lease,
    send_with_retry,
};
use crate::search_run::{SearchRun, StepBatch};
use crate::search_target::SearchTarget;

/// Size of the target cache in KiB. Image targets are large: they contain the sample sets of their
/// views.
const TARGETS_KIB: u64 = 256 << 10;

/// Time for reporting a checkpoint at shutdown.
const SAVE_GRACE: Duration = Duration::from_secs(2);

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
    let shutdown = shutdown.child_token();
    let context = SearchContext {
        client: client.clone(),
        granter: client.clone(),
        targets: Cache::builder().max_capacity(TARGETS_KIB).weigher(weigh).build(),
        threads: config.threads,
        shutdown: shutdown.clone(),
    };
    run_jobs(&client, &config.name, context, shutdown).await
}

/// Lease of a search.
#[derive(Debug, Clone, Copy)]
struct Lease {
    ticket: SearchTicket,
    granted: Instant,
}

impl Lease {
    fn report(self, update: SearchUpdate) -> SearchReport {
        let held = self.granted.elapsed().as_millis();
        let held_ms = u64::try_from(held).unwrap_or(u64::MAX);
        SearchReport { ticket: self.ticket, held_ms, update }
    }
}

/// Resources that a worker shares among its searches.
#[derive(Clone)]
struct SearchContext {
    /// Client of any server.
    client: WorkerClient,
    /// Client of the server that grants the searches.
    granter: WorkerClient,
    targets: Cache<[u8; 32], Arc<SearchTarget>>,
    threads: Option<NonZeroUsize>,
    shutdown: CancellationToken,
}

impl JobKind for SearchContext {
    /// Other searches wait for a time slice.
    const HEARTBEAT: Duration = HEARTBEAT;
    type Request = SearchRequest;
    type Ticket = SearchTicket;

    /// Any server takes the reports of a search: others get those that the granting one does not
    /// answer.
    fn at(self, granter: WorkerClient) -> Self {
        Self { granter, ..self }
    }

    fn name(&self) -> &'static str {
        "search"
    }

    fn concurrent(&self) -> usize {
        4
    }

    fn request(&self, worker: &str, wait_ms: u32) -> SearchRequest {
        SearchRequest { worker: worker.to_owned(), wait_ms }
    }

    fn lease(grant: &SearchGrant) -> (JobId, SearchTicket) {
        (grant.ticket.job, grant.ticket)
    }

    async fn run(self, grant: SearchGrant) {
        let (ticket, job) = (grant.ticket, grant.ticket.job);
        let ttl = Duration::from_millis(grant.ttl_ms.into());
        let lease = Lease { ticket, granted: Instant::now() };
        let stop = Arc::new(AtomicBool::new(false));
        let mut search = std::pin::pin!(self.search(lease, grant, &stop));
        let ended = tokio::select! {
            ended = &mut search => ended,
            () = renew_lease::<Self, _>(ttl, || self.renew(&ticket)) => Err(Interrupted::Stale),
            () = self.shutdown.cancelled() => {
                stop.store(true, Ordering::Relaxed);
                let saved = tokio::time::timeout(SAVE_GRACE, search).await;
                saved.unwrap_or_else(|_| Err(shutting_down()))
            }
        };
        // A computation that is still running checks this flag after each generation.
        stop.store(true, Ordering::Relaxed);
        let mut is_for_others = false;
        let sent = match ended {
            Ok(()) | Err(Interrupted::Stale) => return tracing::debug!(%job, "search ended"),
            Err(Interrupted::Failed(reason)) => {
                tracing::warn!(%job, reason, "search failed");
                self.client.report(&lease.report(SearchUpdate::Failed(reason))).await.map(drop)
            }
            Err(Interrupted::Release(reason)) => {
                tracing::info!(%job, reason, "search returned to the queue");
                self.release(&ticket).await
            }
            Err(Interrupted::OtherVersion(reason)) => {
                tracing::warn!(%job, reason, "search returned to the queue");
                is_for_others = true;
                self.release(&ticket).await
            }
        };
        if let Err(error) = sent {
            tracing::debug!(%job, %error, "cannot return the search; its lease will expire");
        }
        if is_for_others {
            leave_to_others(&self.shutdown).await;
        }
    }
}

impl SearchContext {
    /// Runs a search to its end, or until the server answers [`Directive::Stop`]. If `stop` is set,
    /// it reports a checkpoint instead.
    async fn search(
        &self,
        lease: Lease,
        grant: SearchGrant,
        stop: &Arc<AtomicBool>,
    ) -> Result<(), Interrupted> {
        let threads = grant.threads.and_then(|n| usize::try_from(n).ok());
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let threads = threads.or(self.threads.map(usize::from)).unwrap_or(cores).min(cores);
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .start_handler(|_| idle_thread_priority())
            .build();
        let pool = pool.map_err(|error| Interrupted::Release(error.to_string()))?;
        let pool = Arc::new(pool);
        let target = self.target(&grant, &pool).await?;
        if let Some(scenes) = target.report()
            && self.report(lease, SearchUpdate::Calibrated(scenes)).await? == Directive::Stop
        {
            return Ok(());
        }
        let mut run = blocking(&pool, move || SearchRun::new(grant, target)).await??;
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
            let StepBatch { update, is_over } = batch.map_err(Interrupted::Failed)?;
            let mut directive = Directive::Continue;
            if let Some(update) = update {
                directive = self.report(lease, update).await?;
            }
            if let Directive::Take(arrival) = directive {
                let (back, taken) = blocking(&pool, move || {
                    let taken = run.take(&arrival);
                    (run, taken)
                })
                .await?;
                run = back;
                taken.map_err(Interrupted::Failed)?;
                directive = Directive::Continue;
            }
            let is_stopped = stop.load(Ordering::Relaxed);
            if (is_stopped || directive == Directive::Yield)
                && let Some(update) = run.save()
            {
                directive = self.report(lease, update).await?;
            }
            if directive == Directive::Stop {
                return Ok(());
            }
            if is_stopped {
                return Err(shutting_down());
            }
            if is_over {
                let ending = stop.clone();
                let ended = blocking(&pool, move || (run.spread(), run.finish(&ending))).await?;
                // The end of a stopped search would depend on the time.
                if stop.load(Ordering::Relaxed) {
                    return Err(shutting_down());
                }
                let (spread, front) = ended;
                if let Some(spread) = spread.map_err(Interrupted::Failed)?
                    && self.report(lease, spread).await? == Directive::Stop
                {
                    return Ok(());
                }
                self.report(lease, front.map_err(Interrupted::Failed)?).await?;
                return Ok(());
            }
        }
    }

    /// Returns the target, from the cache if possible.
    async fn target(
        &self,
        grant: &SearchGrant,
        pool: &Arc<rayon::ThreadPool>,
    ) -> Result<Arc<SearchTarget>, Interrupted> {
        let hash = grant.target_hash;
        if let Some(target) = self.targets.get(&hash) {
            return Ok(target);
        }
        let kind: Result<TargetKind, _> = grant.target_kind.parse();
        let kind = kind.map_err(|_| Interrupted::unknown("target", &grant.target_kind))?;
        let bytes = self.client.target(&hash).await;
        let bytes = bytes.map_err(|error| Interrupted::by("download the target", error))?;
        let read = blocking(pool, move || SearchTarget::read(kind, &bytes)).await?;
        let target = Arc::new(read.map_err(Interrupted::Failed)?);
        self.targets.insert(hash, target.clone());
        Ok(target)
    }

    async fn release(&self, ticket: &SearchTicket) -> Result<(), ClientError> {
        match self.granter.release(ticket).await {
            Err(error) if error.is_unanswered() => self.client.release(ticket).await,
            answer => answer,
        }
    }

    async fn renew(&self, ticket: &SearchTicket) -> Result<(), ClientError> {
        match self.granter.heartbeat(ticket).await {
            Err(error) if error.is_unanswered() => self.client.heartbeat(ticket).await,
            answer => answer,
        }
    }

    /// Sends a report, with retries until it arrives: a full disk or a busy server delays a search
    /// and does not fail it.
    async fn report(&self, lease: Lease, update: SearchUpdate) -> Result<Directive, Interrupted> {
        let report = lease.report(update);
        let policy = RetryPolicy { limit: None, repeats_server_errors: true };
        let send = async || match self.granter.report(&report).await {
            Err(error) if error.is_unanswered() => self.client.report(&report).await,
            answer => answer,
        };
        let name = (lease.ticket.job, "report progress");
        let sent = send_with_retry(policy, name, &self.shutdown, send).await;
        sent.map_err(|error| Interrupted::by("report progress", error))
    }
}

fn shutting_down() -> Interrupted {
    Interrupted::Release("shutting down".to_owned())
}

fn weigh(_: &[u8; 32], target: &Arc<SearchTarget>) -> u32 {
    u32::try_from(target.file.bytes() / 1024 + 1).unwrap_or(u32::MAX)
}

/// Runs a closure on the thread pool of a search. A panic fails this search only.
async fn blocking<T: Send + 'static>(
    pool: &Arc<rayon::ThreadPool>,
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<T, Interrupted> {
    let pool = pool.clone();
    let done = tokio::task::spawn_blocking(move || pool.install(work)).await;
    done.map_err(|_| Interrupted::Failed("the search panicked".to_owned()))
}
