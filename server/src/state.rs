//! State shared by all handlers.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicUsize;

use brood_protocol::Backend;
use brood_storage::{Store, StoredPicture};
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
use crate::picture::{Coalescer, PictureCache};
use crate::target_cache::TargetCache;

/// Shared handle of the state.
pub type App = Arc<AppState>;

/// State shared by all handlers.
pub struct AppState {
    /// Durable data.
    pub store: Store,
    /// Token checks.
    pub access: Access,
    /// Host names that the server answers to.
    pub hosts: HostNames,
    /// Backend that renders thumbnails.
    pub backend: Backend,
    /// Directory to serve the page from instead of the embedded copy.
    pub web_dir: Option<PathBuf>,
    /// Caches of materials, scenes and frames.
    pub library: Library,
    /// Cache of pictures and renders in flight.
    pub picture_cache: PictureCache,
    /// Caches of targets and their pictures.
    pub target_cache: TargetCache,
    /// Requested pictures that are about to become jobs.
    pub render_batches: Coalescer<FrameId, Arc<StoredPicture>>,
    /// Leases and workers.
    pub dispatch: Dispatch,
    /// Event streams.
    pub events: Events,
    /// Idempotency keys of running requests.
    pub ledger: Ledger,
    /// Metrics.
    pub metrics: Metrics,
    /// One permit per processor, for CPU-heavy work.
    pub processors: Arc<Semaphore>,
    /// Number of calls waiting for a processor.
    pub waiting: AtomicUsize,
    /// Cancelled when the server begins to stop.
    pub stopping: CancellationToken,
    /// Tasks that outlive their request.
    pub tasks: TaskTracker,
}
