//! Searches for a server: the claim loop of a worker that searches, and one search from grant to end.
//!
//! A search runs on threads of its own, so several share the machine as the system shares it out. It refuses to know how a
//! generation is made.

use std::num::NonZeroUsize;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use brood_protocol::{
    ClientError, Directive, SearchGrant, SearchNews, SearchReport, SearchRequest, SearchTicket,
    WorkerClient,
};
use brood_search::{TargetFile, TargetKind};
use moka::sync::Cache;
use tokio::sync::Semaphore;
use tokio::task::JoinSet;
use tokio_util::sync::CancellationToken;

use crate::backoff::Backoff;
use crate::claim::{FAILURES_TOLD, FAREWELL, LONG_POLL, WorkerError};
use crate::job::HEARTBEAT;
use crate::search_run::{Leg, Run};

/// So many searches share a worker; others wait for a turn.
const AT_ONCE: usize = 4;
/// Memory of the targets that stay at hand: pictures are kept with all that their cameras see.
const TARGETS_KIB: u64 = 512 << 10;

/// What a worker that searches needs to know.
#[derive(Debug, Clone)]
pub struct SearcherConfig {
    /// URL of the server.
    pub server: String,
    /// A token of scope work.
    pub token: String,
    /// For logs.
    pub name: String,
    /// Threads of a search that asks for no number; all cores where absent.
    pub threads: Option<NonZeroUsize>,
}

/// Searches until `shutdown`; ends by itself only where the server refuses the token.
pub async fn run_searches(
    config: SearcherConfig,
    shutdown: CancellationToken,
) -> Result<(), WorkerError> {
    let client = WorkerClient::new(&config.server, &config.token).map_err(WorkerError::Client)?;
    let stop = shutdown.child_token();
    let bench = Bench {
        client,
        targets: Cache::builder().max_capacity(TARGETS_KIB).weigher(weigh).build(),
        threads: config.threads,
        shutdown: stop.clone(),
    };
    let mut searches = JoinSet::new();
    let result = claim(&config, &bench, &mut searches).await;
    stop.cancel();
    let farewell = async { while searches.join_next().await.is_some() {} };
    if tokio::time::timeout(FAREWELL, farewell).await.is_err() {
        tracing::warn!("leases of searches left to lapse");
    }
    result
}

async fn claim(
    config: &SearcherConfig,
    bench: &Bench,
    searches: &mut JoinSet<()>,
) -> Result<(), WorkerError> {
    let slots = Arc::new(Semaphore::new(AT_ONCE));
    let mut backoff = Backoff::default();
    tracing::info!(server = config.server, worker = config.name, "asking for searches");
    loop {
        while searches.try_join_next().is_some() {}
        let slot = tokio::select! {
            slot = slots.clone().acquire_owned() => slot.expect("the semaphore is never closed"),
            () = bench.shutdown.cancelled() => return Ok(()),
        };
        let wait_ms = u32::try_from(LONG_POLL.as_millis()).expect("seconds");
        let request = SearchRequest { worker: config.name.clone(), wait_ms };
        let answer = tokio::select! {
            answer = bench.client.lease_search(&request) => answer,
            () = bench.shutdown.cancelled() => return Ok(()),
        };
        match answer {
            Ok(grant) => {
                backoff.reset();
                if let Some(grant) = grant {
                    let bench = bench.clone();
                    searches.spawn(async move {
                        bench.work(grant).await;
                        drop(slot);
                    });
                }
            }
            Err(error @ ClientError::Refused(_)) => return Err(WorkerError::Refused(error)),
            Err(error) => {
                let wait = backoff.next();
                if backoff.failures() == FAILURES_TOLD {
                    tracing::warn!(%error, "the server gives no searches; trying again and again");
                }
                tokio::select! {
                    () = tokio::time::sleep(wait) => {}
                    () = bench.shutdown.cancelled() => return Ok(()),
                }
            }
        }
    }
}

/// What a search needs from its worker.
#[derive(Clone)]
struct Bench {
    client: WorkerClient,
    targets: Cache<[u8; 32], Arc<TargetFile>>,
    threads: Option<NonZeroUsize>,
    shutdown: CancellationToken,
}

/// Why a search is left before its end.
enum Left {
    /// The server said so, or the lease has passed on.
    Told,
    /// It cannot go on, and trying again would not help.
    Failed(String),
    /// Somebody else may go on.
    Release(String),
}

impl From<ClientError> for Left {
    fn from(error: ClientError) -> Self {
        match error {
            ClientError::Stale => Self::Told,
            ClientError::Wire(error) => Self::Failed(error.to_string()),
            ClientError::Status { status, detail } if status.is_client_error() => {
                Self::Failed(format!("the server refuses it ({status}): {detail}"))
            }
            error => Self::Release(error.to_string()),
        }
    }
}

impl Bench {
    /// Works off one grant. Errors end here: the lease is handed back or left to lapse.
    async fn work(self, grant: SearchGrant) {
        let (ticket, job) = (grant.ticket, grant.ticket.job);
        let ttl = Duration::from_millis(grant.ttl_ms.into());
        let stop = Arc::new(AtomicBool::new(false));
        let left = tokio::select! {
            left = self.search(grant, &stop) => left,
            () = self.keep(&ticket, ttl) => Left::Told,
            () = self.shutdown.cancelled() => Left::Release("stopping".to_owned()),
        };
        // What still computes looks at this after each generation.
        stop.store(true, Ordering::Relaxed);
        let told = match left {
            Left::Told => return tracing::debug!(%job, "search left"),
            Left::Failed(reason) => {
                tracing::warn!(%job, reason, "search failed");
                let news = SearchNews::Failed(reason);
                self.client.report_search(&SearchReport { ticket, news }).await.map(drop)
            }
            Left::Release(reason) => {
                tracing::info!(%job, reason, "search given back");
                self.client.release_search(&ticket).await
            }
        };
        if let Err(error) = told {
            tracing::debug!(%job, %error, "lease of a search left to lapse");
        }
    }

    /// Searches until it is over or told to leave.
    async fn search(&self, grant: SearchGrant, stop: &Arc<AtomicBool>) -> Left {
        match self.search_on(grant, stop).await {
            Ok(()) => Left::Told,
            Err(left) => left,
        }
    }

    async fn search_on(&self, grant: SearchGrant, stop: &Arc<AtomicBool>) -> Result<(), Left> {
        let target = self.target(&grant).await?;
        let threads = grant.threads.and_then(|n| usize::try_from(n).ok());
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let threads = threads.or(self.threads.map(usize::from)).unwrap_or(cores).min(cores);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.map_err(|error| Left::Release(error.to_string()))?;
        let pool = Arc::new(pool);
        let ticket = grant.ticket;
        let mut run =
            blocking(&pool, move || Run::new(grant, target)).await?.map_err(Left::Failed)?;
        loop {
            let (back, leg) = blocking(&pool, {
                let stop = stop.clone();
                move || {
                    let leg = run.leg(&stop);
                    (run, leg)
                }
            })
            .await?;
            run = back;
            let Leg { news, is_over } = leg.map_err(Left::Failed)?;
            if let Some(news) = news
                && self.report(ticket, news).await? == Directive::Leave
            {
                return Ok(());
            }
            if is_over {
                let stop = stop.clone();
                let news = blocking(&pool, move || run.finish(&stop)).await?;
                self.report(ticket, news.map_err(Left::Failed)?).await?;
                return Ok(());
            }
        }
    }

    /// The target, read once.
    async fn target(&self, grant: &SearchGrant) -> Result<Arc<TargetFile>, Left> {
        let hash = grant.target_hash;
        if let Some(target) = self.targets.get(&hash) {
            return Ok(target);
        }
        let kind: Result<TargetKind, _> = grant.target_kind.parse();
        let kind = kind
            .map_err(|_| Left::Failed("server and worker are of different versions".to_owned()))?;
        let bytes = self.client.target(&hash).await?;
        let read = tokio::task::spawn_blocking(move || TargetFile::read(kind, &bytes)).await;
        let read = read.map_err(|_| Left::Failed("reading the target panicked".to_owned()))?;
        let target = Arc::new(read.map_err(|error| Left::Failed(error.to_string()))?);
        self.targets.insert(hash, target.clone());
        Ok(target)
    }

    /// Tells the server until it listens: a full disk or a server that is busy makes a search wait, not fail.
    async fn report(&self, ticket: SearchTicket, news: SearchNews) -> Result<Directive, Left> {
        let report = SearchReport { ticket, news };
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
            if backoff.failures() == FAILURES_TOLD {
                tracing::warn!(job = %ticket.job, %error, "a search waits for the server");
            }
            tokio::time::sleep(wait).await;
        }
    }

    /// Renews the lease; ends only when it is lost.
    async fn keep(&self, ticket: &SearchTicket, ttl: Duration) {
        let period = HEARTBEAT.min(ttl / 4).max(Duration::from_millis(50));
        loop {
            tokio::time::sleep(period).await;
            match self.client.keep_search(ticket).await {
                Ok(()) => {}
                Err(ClientError::Stale) => return,
                Err(error) => tracing::debug!(%error, "heartbeat unanswered"),
            }
        }
    }
}

fn weigh(_: &[u8; 32], target: &Arc<TargetFile>) -> u32 {
    u32::try_from(target.bytes() / 1024 + 1).unwrap_or(u32::MAX)
}

/// Runs on the threads of a search; a panic there ends the search alone.
async fn blocking<T: Send + 'static>(
    pool: &Arc<rayon::ThreadPool>,
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<T, Left> {
    let pool = pool.clone();
    let done = tokio::task::spawn_blocking(move || pool.install(work)).await;
    done.map_err(|_| Left::Failed("the search panicked".to_owned()))
}
