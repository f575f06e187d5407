//! A server's life: bound, run, drained, closed.

use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::AtomicUsize;
use std::time::Duration;

use brood_protocol::PictureKey;
use brood_storage::Store;
use bytes::Bytes;
use tokio::net::TcpListener;
use tokio::sync::{Semaphore, mpsc};
use tokio::task::JoinSet;
use tokio::time::{MissedTickBehavior, interval};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use crate::access::Access;
use crate::config::ServerConfig;
use crate::dispatch::Dispatch;
use crate::error::ServerError;
use crate::event::Events;
use crate::idempotency::Ledger;
use crate::layer::HostNames;
use crate::library::Library;
use crate::metric::Metrics;
use crate::picture::{Coalescer, Disk, Gallery};
use crate::shelf::Shelf;
use crate::state::{App, AppState, now_ms};
use crate::{limit, listen, route};

/// Lapsed leases are looked for this often.
const LEASE_TICK: Duration = Duration::from_millis(500);
/// Memory is tidied this often.
const TIDY_TICK: Duration = Duration::from_secs(5);
/// Old idempotency records are dropped this often, when they are this old.
const PRUNE_TICK: Duration = Duration::from_secs(3600);
const REMEMBER_MS: i64 = 24 * 3600 * 1000;

/// A server that is bound and not yet running.
pub struct Server {
    app: App,
    listener: TcpListener,
    address: SocketAddr,
    writes: mpsc::Receiver<(PictureKey, Bytes)>,
}

impl Server {
    /// Takes the address and opens the data directory.
    ///
    /// # Errors
    /// Each a clear line: see [`ServerError`].
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
        let store = Store::open(&config.data).await?;
        let loopback = address.ip().is_loopback();
        if !loopback && !store.any_token().await? {
            store.close().await?;
            return Err(ServerError::NoToken(config.listen));
        }
        let requeued = store.requeue_all_leased().await?;
        if requeued > 0 {
            tracing::info!(requeued, "jobs of the last run are queued again");
        }
        let requeued = store.requeue_all_searches().await?;
        if requeued > 0 {
            tracing::info!(requeued, "searches of the last run go on from their checkpoints");
        }
        let (root, bytes) = (config.data.join("cache"), config.cache_mib.saturating_mul(1 << 20));
        let opened = tokio::task::spawn_blocking(move || Disk::open(&root, bytes)).await;
        let disk = opened.map_err(std::io::Error::other).and_then(|disk| disk);
        let (gallery, writes) = Gallery::new(disk.map_err(ServerError::Cache)?, bytes / 4);
        let processors = std::thread::available_parallelism().map_or(1, usize::from);
        let app = Arc::new(AppState {
            access: Access::new(loopback)?,
            hosts,
            backend: config.backend,
            web_dir: config.web_dir,
            library: Library::new(store.clone()),
            store,
            gallery,
            shelf: Shelf::default(),
            wanted: Coalescer::new(),
            dispatch: Dispatch::new(),
            events: Events::new(),
            ledger: Ledger::default(),
            metrics: Metrics::new(),
            processors: Arc::new(Semaphore::new(processors)),
            waiting: AtomicUsize::new(0),
            stopping: CancellationToken::new(),
            tasks: TaskTracker::new(),
        });
        Ok(Self { app, listener, address, writes })
    }

    /// The address, with the port that was taken.
    #[must_use]
    pub fn local_addr(&self) -> SocketAddr {
        self.address
    }

    /// The token for the server's own workers; it dies with the process.
    #[must_use]
    pub fn worker_token(&self) -> String {
        self.app.access.worker_token().to_owned()
    }

    /// Tells the server of workers that are known to be dead, so that their jobs need not wait for leases to lapse.
    #[must_use]
    pub fn undertaker(&self) -> Undertaker {
        Undertaker { app: self.app.clone() }
    }

    /// Serves until `shutdown`; then refuses new work, drains, puts leased jobs back and closes the store.
    ///
    /// # Errors
    /// Where the store cannot be closed in order.
    pub async fn run(self, shutdown: CancellationToken) -> Result<(), ServerError> {
        let Self { app, listener, writes, .. } = self;
        let mut background = JoinSet::new();
        let stopping = app.stopping.clone();
        background.spawn(async move {
            shutdown.cancelled().await;
            stopping.cancel();
        });
        background.spawn(tend(app.clone()));
        let written = CancellationToken::new();
        let writer = tokio::spawn(write_pictures(app.clone(), writes, written.clone()));

        listen::serve(listener, route::router(app.clone()), app.stopping.clone()).await;

        // Also where the accept loop should ever end by itself.
        app.stopping.cancel();
        background.shutdown().await;
        app.release_all().await;
        app.tasks.close();
        if tokio::time::timeout(limit::DRAIN, app.tasks.wait()).await.is_err() {
            tracing::warn!(tasks = app.tasks.len(), "work is left behind");
        }
        written.cancel();
        if let Err(error) = writer.await {
            tracing::warn!(%error, "the picture cache was not written to its end");
        }
        app.store.clone().close().await?;
        tracing::info!("stopped");
        Ok(())
    }
}

/// Whom the keeper of a worker process tells that it is dead.
#[derive(Clone)]
pub struct Undertaker {
    app: App,
}

impl Undertaker {
    /// The jobs of the worker of that name are given to others at once.
    pub async fn bury(&self, worker: &str) {
        // Once the server stops, its leases are released as a whole and the store is closed.
        if !self.app.stopping.is_cancelled() {
            self.app.bury(worker).await;
        }
    }
}

/// What has to happen now and then.
async fn tend(app: App) {
    let mut leases = interval(LEASE_TICK);
    let mut tidy = interval(TIDY_TICK);
    let mut prune = interval(PRUNE_TICK);
    for timer in [&mut leases, &mut tidy, &mut prune] {
        timer.set_missed_tick_behavior(MissedTickBehavior::Delay);
    }
    loop {
        tokio::select! {
            () = app.stopping.cancelled() => return,
            _ = leases.tick() => app.expire_leases().await,
            _ = tidy.tick() => {
                app.events.sweep();
                app.metrics.upkeep();
            }
            _ = prune.tick() => {
                if let Err(error) = app.store.prune_idempotency(now_ms() - REMEMBER_MS).await {
                    tracing::warn!(%error, "old idempotency records could not be dropped");
                }
            }
        }
    }
}

/// Writes pictures to disk behind the backs of those who wait for them.
async fn write_pictures(
    app: App,
    mut queue: mpsc::Receiver<(PictureKey, Bytes)>,
    finish: CancellationToken,
) {
    const BATCH: usize = 256;
    // Those who wait for the pictures go first.
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
        let disk = app.gallery.disk().clone();
        let pictures = std::mem::take(&mut batch);
        let write = move || disk.write_all(&pictures);
        if let Err(error) = tokio::task::spawn_blocking(write).await {
            tracing::warn!(%error, "pictures could not be written");
        }
    }
}
