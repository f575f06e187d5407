//! What all handlers share.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicUsize;
use std::time::{SystemTime, UNIX_EPOCH};

use brood_protocol::Backend;
use brood_storage::{PictureRow, Store};
use tokio::sync::Semaphore;
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use crate::access::Access;
use crate::dispatch::{Dispatch, FrameId};
use crate::event::Events;
use crate::idempotency::Ledger;
use crate::layer::HostNames;
use crate::library::Library;
use crate::metric::Metrics;
use crate::picture::{Coalescer, Gallery};
use crate::shelf::Shelf;

/// What all handlers share.
pub type App = Arc<AppState>;

/// What all handlers share, by concern.
pub struct AppState {
    /// Durable facts.
    pub store: Store,
    /// Who may do what.
    pub access: Access,
    /// Names that the server answers to.
    pub hosts: HostNames,
    /// The evaluator that thumbnails ask for.
    pub backend: Backend,
    /// The page on disk instead of the embedded one.
    pub web_dir: Option<PathBuf>,
    /// Materials, scenes and frames.
    pub library: Library,
    /// Pictures.
    pub gallery: Gallery,
    /// Targets at hand, and pictures of them.
    pub shelf: Shelf,
    /// Pictures that are about to become jobs.
    pub wanted: Coalescer<FrameId, Arc<PictureRow>>,
    /// Leases and workers.
    pub dispatch: Dispatch,
    /// Event streams.
    pub events: Events,
    /// Idempotency keys in use.
    pub ledger: Ledger,
    /// Figures.
    pub metrics: Metrics,
    /// Processors for broods and sheets.
    pub processors: Arc<Semaphore>,
    /// How many wait for a processor.
    pub waiting: AtomicUsize,
    /// Set when the server begins to stop.
    pub stopping: CancellationToken,
    /// Work that outlives its request.
    pub tasks: TaskTracker,
}

/// Milliseconds since 1970.
pub fn now_ms() -> i64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    i64::try_from(since.as_millis()).unwrap_or(i64::MAX)
}
