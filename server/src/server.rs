//! Server lifecycle: bind, run, drain, close.

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use brood_protocol::{LineageId, PictureKey};
use brood_storage::{BusLink, LostLeases, StorageError, Store};
use bytes::Bytes;
use tokio::net::TcpListener;
use tokio::sync::mpsc;
use tokio::task::JoinSet;
use tokio::time::{Instant, MissedTickBehavior, interval, timeout};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use crate::access::Access;
use crate::breeding::Breeding;
use crate::bus::Peers;
use crate::clock::now_ms;
use crate::config::ServerConfig;
use crate::deferred::Deferred;
use crate::dispatch::{
    Exports, History, JobKind, Jobs, Lane, LeaseTable, PictureService, RenderQueue, Searches,
    Workers, try_end_leases,
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
use crate::worker_reaper::{WorkerReaper, end_all_leases};
use crate::{bus, limit, listen, route};

/// Interval at which waiting workers look for jobs that other servers have queued.
const JOB_POLL: Duration = Duration::from_secs(2);
/// Interval of the checks for expired leases and for a disk that failed.
const LEASE_TICK: Duration = Duration::from_millis(500);
/// Time without a failure to end leases after which an outage of the store is over.
const OUTAGE: Duration = Duration::from_secs(30);
/// Interval of the clean-up of memory.
const TIDY_TICK: Duration = Duration::from_secs(5);
/// Interval of the search for unfinished lineages of other servers.
const LOOK_TICK: Duration = Duration::from_secs(60);
/// Interval of the clean-up of idempotency records.
const PRUNE_TICK: Duration = Duration::from_secs(3600);
/// Time from the start to the first removal of objects without a row, and interval of others.
const FIRST_SWEEP: Duration = Duration::from_secs(600);
const SWEEP_TICK: Duration = Duration::from_secs(2 * 3600);
/// Age at which an object without a row is removed. Rows of objects are written within an hour.
const SWEEP_AGE: Duration = Duration::from_secs(24 * 3600);
/// Age at which an idempotency record is deleted, in milliseconds.
const IDEMPOTENCY_TTL_MS: i64 = 24 * 3600 * 1000;

/// Bound server that is not running yet.
pub struct Server {
    app: App,
    listener: TcpListener,
    address: SocketAddr,
    writes: mpsc::Receiver<(PictureKey, Bytes)>,
    /// Connection with the other servers of the database.
    link: Option<BusLink>,
    still_leased: StillLeased,
}

/// Kinds of jobs with leases of the last run that the start could not end.
struct StillLeased {
    searches: bool,
    exports: bool,
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
        let store = store.with_blobs(config.blobs.as_ref()).await.map_err(ServerError::Blobs)?;
        if !loopback && !store.any_token().await.map_err(failed)? {
            store.close().await?;
            return Err(ServerError::NoToken(config.listen));
        }
        let (still_leased, unfinished) = end_last_run(&store).await.map_err(failed)?;
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
        let library = Arc::new(Library::new(store.clone()));
        let (bus, link) = store.join_bus().await.map_err(failed)?.unzip();
        let peers = Peers::new(bus);
        let poll = store.is_shared().then_some(JOB_POLL);
        let (metrics, events) = (Arc::new(Metrics::new()), Arc::new(Events::new(peers)));
        let (processors, ledger) = (Processors::new(), Ledger::default());
        let pictures = Arc::new(PictureService {
            store: store.clone(),
            library: library.clone(),
            cache,
            batches: Coalescer::new(),
            jobs: Jobs::new(&tasks, &stopping, None),
            leases: LeaseTable::default(),
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
            jobs: Jobs::new(&tasks, &stopping, poll),
            lane: Lane::default(),
            breeding: breeding.clone(),
            pictures: pictures.clone(),
            ledger: ledger.clone(),
            events: events.clone(),
            metrics: metrics.clone(),
        });
        let exports = Arc::new(Exports {
            store: store.clone(),
            jobs: Jobs::new(&tasks, &stopping, poll),
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
            leaving: CancellationToken::new(),
            stopping,
            tasks,
        });
        app.tasks.spawn(remove_lineages(app.clone(), unfinished));
        Ok(Self { app, listener, address, writes, link, still_leased })
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
        WorkerReaper::new(self.app.clone())
    }

    /// Returns a token to cancel some time before `shutdown`: `/readyz` then answers 503, so that a
    /// balancer sends no more requests, while the server still serves them.
    #[must_use]
    pub fn leaving(&self) -> CancellationToken {
        self.app.leaving.clone()
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
        let Self { app, listener, writes, link, still_leased, .. } = self;
        let mut background = JoinSet::new();
        let stopping = app.stopping.clone();
        background.spawn(async move {
            shutdown.cancelled().await;
            stopping.cancel();
        });
        background.spawn(run_maintenance(app.clone()));
        background.spawn(sweep_blobs(app.clone()));
        // A task for each kind: leases of renders expire while the database does not answer.
        background.spawn(sweep_leases(app.clone(), app.pictures.clone(), false));
        background.spawn(sweep_leases(app.clone(), app.searches.clone(), still_leased.searches));
        background.spawn(sweep_leases(app.clone(), app.exports.clone(), still_leased.exports));
        let (mut peers, drained) = (JoinSet::new(), CancellationToken::new());
        if let Some(link) = link {
            peers.spawn(bus::exchange_messages(app.clone(), link, drained.clone()));
        }
        let written = CancellationToken::new();
        let writer = tokio::spawn(write_pictures(app.clone(), writes, written.clone()));
        let check = tokio::spawn(check_after_crash(app.clone()));

        listen::serve(listener, route::router(app.clone()), &app).await;

        // Needed if the accept loop has ended by itself.
        app.stopping.cancel();
        background.shutdown().await;
        if timeout(limit::DRAIN, end_all_leases(&app, LostLeases::OfProcess)).await.is_err() {
            tracing::warn!("the store does not answer: leases of this run are not ended");
        }
        app.tasks.close();
        if timeout(limit::DRAIN, app.tasks.wait()).await.is_err() {
            tracing::warn!(tasks = app.tasks.len(), "background tasks did not finish in time");
        }
        // Leases and tasks that end send messages to the other servers.
        drained.cancel();
        while peers.join_next().await.is_some() {}
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

/// Ends the leases of the last run. Returns the kinds whose leases could not be ended, and the
/// lineages that the last run did not finish to import or to remove.
async fn end_last_run(store: &Store) -> Result<(StillLeased, Vec<LineageId>), StorageError> {
    let mut refusal = None;
    let searches = store.end_search_leases(LostLeases::OfProcess, now_ms()).await;
    let searches = unless_refused(searches, &mut refusal)?;
    let exports = store.end_export_leases(LostLeases::OfProcess, now_ms()).await;
    let exports = unless_refused(exports, &mut refusal)?;
    let unfinished = store.take_unfinished_lineages(true).await;
    let unfinished = unless_refused(unfinished, &mut refusal)?;
    if let Some(error) = refusal {
        tracing::warn!(%error, "jobs of the last run wait until the store takes writes");
    }
    let still_leased = StillLeased { searches: searches.is_none(), exports: exports.is_none() };
    let searches = searches.map_or(0, |ended| ended.len());
    let exports = exports.map_or(0, |ended| ended.len());
    if searches + exports > 0 {
        tracing::info!(
            searches,
            exports,
            "requeued jobs of the last run; searches continue from their checkpoints, and files \
             of exports are kept"
        );
    }
    Ok((still_leased, unfinished.unwrap_or_default()))
}

/// Returns `None`, and keeps the error, if the disk is full or the database does not answer, so
/// that the server starts and serves reads.
fn unless_refused<T>(
    result: Result<T, StorageError>,
    refusal: &mut Option<StorageError>,
) -> Result<Option<T>, StorageError> {
    match result {
        Err(error @ (StorageError::Full | StorageError::Busy | StorageError::Unreachable(_))) => {
            *refusal = Some(error);
            Ok(None)
        }
        result => result.map(Some),
    }
}

/// Removes lineages that another run or another server did not finish to import or to remove.
async fn remove_lineages(app: App, unfinished: Vec<LineageId>) {
    for id in unfinished {
        let removal = app.store.remove_lineage(id);
        let Some(removed) = app.stopping.run_until_cancelled(removal).await else { return };
        bus::genomes_removed(&app);
        match removed {
            Ok(()) => tracing::info!(%id, "removed a lineage that its server had not finished"),
            Err(error) => {
                tracing::warn!(%id, %error, "an unfinished lineage is removed later");
            }
        }
    }
}

/// Ends expired leases of one kind and requeues their jobs, until the server stops. Before them,
/// those of the last run if the start could not end them: their workers have not died.
async fn sweep_leases<K: JobKind>(app: App, kind: Arc<K>, mut of_last_run: bool) {
    let mut ticks = interval(LEASE_TICK);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut failed: Option<Instant> = None;
    loop {
        tokio::select! {
            () = app.stopping.cancelled() => return,
            _ = ticks.tick() => {}
        }
        let lost = if of_last_run { LostLeases::OfProcess } else { LostLeases::Expired };
        match try_end_leases(&*kind, lost).await {
            Ok(workers) => {
                // No lease is looked for some time after a failure: that is no sign of an end.
                if failed.is_some_and(|time| time.elapsed() > OUTAGE)
                    && app.store.any_token().await.is_ok()
                {
                    tracing::info!(kind = K::NAME, "lost leases are ended again");
                    failed = None;
                }
                if of_last_run {
                    let jobs = workers.len();
                    tracing::info!(kind = K::NAME, jobs, "requeued jobs of the last run");
                } else {
                    workers.iter().for_each(|worker| app.workers.lost(worker));
                }
                of_last_run = false;
            }
            Err(error) => {
                // Once an outage.
                if failed.is_none() {
                    let reason = &error.problem().detail;
                    tracing::warn!(kind = K::NAME, reason, "cannot end lost leases; trying again");
                }
                failed = Some(Instant::now());
            }
        }
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
    let mut check = interval(LEASE_TICK);
    let mut tidy = interval(TIDY_TICK);
    let mut look = interval(LOOK_TICK);
    let mut prune = interval(PRUNE_TICK);
    for timer in [&mut check, &mut tidy, &mut look, &mut prune] {
        timer.set_missed_tick_behavior(MissedTickBehavior::Delay);
    }
    loop {
        tokio::select! {
            () = app.stopping.cancelled() => return,
            _ = check.tick() => {
                if app.store.is_poisoned() {
                    // A restart reads from the disk what was stored; until then, answers could
                    // show what is not.
                    app.stopping.cancel();
                    return;
                }
            }
            _ = tidy.tick() => {
                app.events.sweep();
                app.deferred.sweep();
                app.metrics.upkeep();
            }
            _ = look.tick() => match app.store.take_unfinished_lineages(false).await {
                Ok(unfinished) if unfinished.is_empty() => {}
                Ok(unfinished) => {
                    app.tasks.spawn(remove_lineages(app.clone(), unfinished));
                }
                Err(error) => tracing::warn!(%error, "cannot look for unfinished lineages"),
            },
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

/// Removes objects without a row from the object store, until the server stops.
async fn sweep_blobs(app: App) {
    let mut wait = FIRST_SWEEP;
    loop {
        tokio::select! {
            () = app.stopping.cancelled() => return,
            () = tokio::time::sleep(wait) => {}
        }
        wait = SWEEP_TICK;
        match app.store.sweep_blobs(SWEEP_AGE).await {
            Ok(0) => {}
            Ok(objects) => tracing::info!(objects, "removed objects without a row"),
            Err(error) => tracing::warn!(%error, "cannot remove objects without a row"),
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
