//! Server lifecycle: bind, run, drain, close.

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use brood_protocol::{LineageId, PictureKey};
use brood_storage::{StorageError, Store};
use bytes::Bytes;
use tokio::net::TcpListener;
use tokio::sync::mpsc;
use tokio::task::JoinSet;
use tokio::time::{MissedTickBehavior, interval};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use crate::access::Access;
use crate::breeding::Breeding;
use crate::clock::now_ms;
use crate::config::ServerConfig;
use crate::deferred::Deferred;
use crate::dispatch::{
    Exports, History, Jobs, Lane, LeaseEnd, PictureService, RenderQueue, Searches, Workers,
    end_leases,
};
use crate::error::ServerError;
use crate::event::Events;
use crate::export_folder::ExportFolder;
use crate::host_name::HostNames;
use crate::idempotency::Ledger;
use crate::library::Library;
use crate::metric::Metrics;
use crate::open_connections::OpenConnections;
use crate::picture::{CACHE_FOLDER, Coalescer, DiskCache, PictureCache};
use crate::processors::Processors;
use crate::state::{App, AppState};
use crate::{limit, listen, route};

/// Interval of the check for expired leases.
const LEASE_TICK: Duration = Duration::from_millis(500);
/// Interval of the clean-up of memory.
const TIDY_TICK: Duration = Duration::from_secs(5);
/// Interval of the clean-up of idempotency records.
const PRUNE_TICK: Duration = Duration::from_secs(3600);
/// Age at which an idempotency record is deleted, in milliseconds.
const IDEMPOTENCY_TTL_MS: i64 = 24 * 3600 * 1000;

/// Bound server that is not running yet.
pub struct Server {
    app: App,
    listener: TcpListener,
    address: SocketAddr,
    writes: mpsc::Receiver<(PictureKey, Bytes)>,
}

impl Server {
    /// Binds the address and opens the data directory.
    ///
    /// # Errors
    /// [`ServerError`] if the address cannot be bound, the data or the cache cannot be opened, or
    /// the address is not loopback and there is no token.
    pub async fn bind(config: ServerConfig) -> Result<Self, ServerError> {
        let listener =
            TcpListener::bind(config.listen).await.map_err(|source| match source.kind() {
                std::io::ErrorKind::AddrInUse => ServerError::Taken(config.listen),
                _ => ServerError::Bind { address: config.listen, source },
            })?;
        let address = listener
            .local_addr()
            .map_err(|source| ServerError::Bind { address: config.listen, source })?;
        let hosts = HostNames::new(address.ip(), &config.allow_hosts)?;
        let store = match &config.database {
            Some(address) => {
                Store::connect(address, &config.data).await.map_err(ServerError::Database)?
            }
            None => Store::open_unchecked(&config.data).await?,
        };
        tracing::info!(engine = store.engine_version(), "opened the database");
        let loopback = address.ip().is_loopback();
        let failed = |error| match &config.database {
            Some(_) => ServerError::Database(error),
            None => ServerError::Storage(error),
        };
        if !loopback && !store.any_token().await.map_err(failed)? {
            store.close().await?;
            return Err(ServerError::NoToken(config.listen));
        }
        let requeued = unless_full(store.requeue_all_searches().await).map_err(failed)?;
        if requeued > 0 {
            tracing::info!(
                requeued,
                "requeued searches of the last run; they continue from their checkpoints"
            );
        }
        let requeued = unless_full(store.requeue_all_exports().await).map_err(failed)?;
        if requeued > 0 {
            tracing::info!(requeued, "requeued exports of the last run; made files are kept");
        }
        let unfinished = store.unfinished_lineages().await.map_err(failed)?;
        let known =
            store.exports().await.map_err(failed)?.into_iter().map(|export| export.id).collect();
        let root = config.data.join("exports");
        let opened = tokio::task::spawn_blocking(move || ExportFolder::open(root, &known)).await;
        let folder = opened.map_err(std::io::Error::other).and_then(|folder| folder);
        let folder = folder.map_err(ServerError::Exports)?;
        let (root, bytes) =
            (config.data.join(CACHE_FOLDER), config.cache_mib.saturating_mul(1 << 20));
        let opened = tokio::task::spawn_blocking(move || DiskCache::open(&root, bytes)).await;
        let disk = opened.map_err(std::io::Error::other).and_then(|disk| disk);
        let (cache, writes) = PictureCache::new(disk.map_err(ServerError::Cache)?, bytes / 4);
        let (tasks, stopping) = (TaskTracker::new(), CancellationToken::new());
        tasks.spawn(remove_lineages(store.clone(), unfinished));
        let library = Arc::new(Library::new(store.clone()));
        let (metrics, events) = (Arc::new(Metrics::new()), Arc::new(Events::new()));
        let (processors, ledger) = (Processors::new(), Ledger::default());
        let pictures = Arc::new(PictureService {
            store: store.clone(),
            library: library.clone(),
            cache,
            batches: Coalescer::new(),
            jobs: Jobs::new(&tasks, &stopping),
            interactive: Lane::default(),
            batch: Lane::default(),
            queue: RenderQueue::default(),
            history: History::new(),
            events: events.clone(),
            metrics: metrics.clone(),
        });
        let breeding = Arc::new(Breeding {
            store: store.clone(),
            library: library.clone(),
            processors: processors.clone(),
            backend: config.backend,
            seconds: metrics.brood_seconds.clone(),
        });
        let searches = Arc::new(Searches {
            store: store.clone(),
            jobs: Jobs::new(&tasks, &stopping),
            lane: Lane::default(),
            breeding: breeding.clone(),
            pictures: pictures.clone(),
            ledger: ledger.clone(),
            events: events.clone(),
            metrics: metrics.clone(),
        });
        let exports = Arc::new(Exports {
            store: store.clone(),
            jobs: Jobs::new(&tasks, &stopping),
            lane: Lane::default(),
            library: library.clone(),
            folder,
            events: events.clone(),
            space: tokio::sync::Mutex::new(()),
            most_bytes: limit::EXPORTS_BYTES,
        });
        let deferred = Arc::new(Deferred::new(pictures.clone(), events.clone()));
        let app = Arc::new(AppState {
            access: Access::new(loopback)?,
            hosts,
            backend: config.backend,
            web_dir: config.web_dir,
            library,
            store,
            pictures,
            searches,
            exports,
            deferred,
            workers: Workers::default(),
            connections: OpenConnections::new(limit::CONNECTIONS, limit::WORKER_CONNECTIONS),
            events,
            ledger,
            metrics,
            processors,
            breeding,
            stopping,
            tasks,
        });
        Ok(Self { app, listener, address, writes })
    }

    /// Address with the actual port.
    #[must_use]
    pub fn local_addr(&self) -> SocketAddr {
        self.address
    }

    /// Token for the server's own workers, valid until the process ends.
    #[must_use]
    pub fn worker_token(&self) -> String {
        self.app.access.worker_token().to_owned()
    }

    /// Returns a handle that requeues the jobs of dead workers, before their leases expire.
    #[must_use]
    pub fn worker_reaper(&self) -> WorkerReaper {
        WorkerReaper { app: self.app.clone() }
    }

    /// Returns the state, for tests that serve no requests.
    #[cfg(test)]
    pub(crate) fn app(&self) -> App {
        self.app.clone()
    }

    /// Serves until `shutdown`, then rejects new work, drains, requeues leased jobs and closes the
    /// store.
    ///
    /// # Errors
    /// [`ServerError::Closing`] if a write to the disk has failed, which also ends the server, or
    /// if the store cannot be closed cleanly.
    pub async fn run(self, shutdown: CancellationToken) -> Result<(), ServerError> {
        let Self { app, listener, writes, .. } = self;
        let mut background = JoinSet::new();
        let stopping = app.stopping.clone();
        background.spawn(async move {
            shutdown.cancelled().await;
            stopping.cancel();
        });
        background.spawn(run_maintenance(app.clone()));
        let written = CancellationToken::new();
        let writer = tokio::spawn(write_pictures(app.clone(), writes, written.clone()));
        let check = tokio::spawn(check_after_crash(app.clone()));

        listen::serve(listener, route::router(app.clone()), &app).await;

        // Needed if the accept loop has ended by itself.
        app.stopping.cancel();
        background.shutdown().await;
        end_all_leases(&app, LeaseEnd::Shutdown).await;
        app.tasks.close();
        if tokio::time::timeout(limit::DRAIN, app.tasks.wait()).await.is_err() {
            tracing::warn!(tasks = app.tasks.len(), "background tasks did not finish in time");
        }
        written.cancel();
        if let Err(error) = writer.await {
            tracing::warn!(%error, "the picture cache was not written completely");
        }
        let closed = app.store.clone().close().await.map_err(ServerError::Closing);
        // A check that is still running ends with the process; the next start repeats it.
        if check.is_finished()
            && let Ok(Err(damage)) = check.await
        {
            return Err(damage.into());
        }
        closed?;
        tracing::info!("stopped");
        Ok(())
    }
}

/// Returns 0 if the disk is full, so that the server starts and serves reads.
fn unless_full(requeued: Result<u64, StorageError>) -> Result<u64, StorageError> {
    match requeued {
        Err(StorageError::Full) => {
            tracing::warn!(
                "the disk is full: jobs of the last run wait for a start with free space"
            );
            Ok(0)
        }
        requeued => requeued,
    }
}

/// Removes the lineages that the last run did not finish to import or to remove.
async fn remove_lineages(store: Store, unfinished: Vec<LineageId>) {
    for id in unfinished {
        match store.remove_lineage(id).await {
            Ok(()) => tracing::info!(%id, "removed a lineage that the last run had not finished"),
            Err(error) => {
                tracing::warn!(%id, %error, "an unfinished lineage is removed at the next start");
            }
        }
    }
}

/// Handle that requeues the jobs of dead workers.
#[derive(Clone)]
pub struct WorkerReaper {
    app: App,
}

impl WorkerReaper {
    /// Requeues the jobs of a dead worker.
    pub async fn requeue_jobs_of(&self, worker: &str) {
        // A stopping server releases all leases at once and closes the store.
        if !self.app.stopping.is_cancelled() {
            end_all_leases(&self.app, LeaseEnd::Death(worker)).await;
        }
    }
}

/// Ends leases of all kinds and requeues their jobs.
async fn end_all_leases(app: &App, end: LeaseEnd<'_>) {
    let mut workers = end_leases(&*app.pictures, end).await;
    workers.extend(end_leases(&*app.searches, end).await);
    workers.extend(end_leases(&*app.exports, end).await);
    match end {
        LeaseEnd::Expired => workers.iter().for_each(|worker| app.workers.lost(worker)),
        LeaseEnd::Death(worker) => app.workers.gone(worker),
        LeaseEnd::Shutdown => {}
    }
}

/// Checks the database after an unclean shutdown, and stops the server if it is damaged.
async fn check_after_crash(app: App) -> Result<(), StorageError> {
    let checked = app.store.check_after_crash().await;
    if let Err(error) = &checked {
        tracing::error!(%error, "the check after an unclean shutdown failed; stopping");
        app.stopping.cancel();
    }
    checked
}

/// Runs the periodic maintenance.
async fn run_maintenance(app: App) {
    let mut leases = interval(LEASE_TICK);
    let mut tidy = interval(TIDY_TICK);
    let mut prune = interval(PRUNE_TICK);
    for timer in [&mut leases, &mut tidy, &mut prune] {
        timer.set_missed_tick_behavior(MissedTickBehavior::Delay);
    }
    loop {
        tokio::select! {
            () = app.stopping.cancelled() => return,
            _ = leases.tick() => {
                if app.store.is_poisoned() {
                    // A restart reads from the disk what was stored; until then, answers could
                    // show what is not.
                    app.stopping.cancel();
                    return;
                }
                end_all_leases(&app, LeaseEnd::Expired).await;
            }
            _ = tidy.tick() => {
                app.events.sweep();
                app.deferred.sweep();
                app.metrics.upkeep();
            }
            _ = prune.tick() => {
                if let Err(error) = app.store.prune_idempotency(now_ms() - IDEMPOTENCY_TTL_MS).await {
                    tracing::warn!(%error, "cannot delete old idempotency records");
                }
                if let Err(error) = app.exports.prune().await {
                    let reason = &error.problem().detail;
                    tracing::warn!(reason, "cannot delete old exports");
                }
            }
        }
    }
}

/// Writes pictures to disk in the background.
async fn write_pictures(
    app: App,
    mut queue: mpsc::Receiver<(PictureKey, Bytes)>,
    finish: CancellationToken,
) {
    const BATCH: usize = 256;
    // Delay, so that waiting requests are answered first.
    const LATER: Duration = Duration::from_millis(50);
    let mut batch = Vec::with_capacity(BATCH);
    loop {
        tokio::select! {
            biased;
            count = queue.recv_many(&mut batch, BATCH) => if count == 0 { return },
            () = finish.cancelled() => return,
        }
        tokio::select! {
            () = tokio::time::sleep(LATER) => {}
            () = finish.cancelled() => {}
        }
        while batch.len() < BATCH
            && let Ok(picture) = queue.try_recv()
        {
            batch.push(picture);
        }
        let disk = app.pictures.cache.disk().clone();
        let pictures = std::mem::take(&mut batch);
        let write = move || disk.write_all(&pictures);
        if let Err(error) = tokio::task::spawn_blocking(write).await {
            tracing::warn!(%error, "the task that writes pictures panicked");
        }
    }
}
