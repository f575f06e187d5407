//! State shared by all request handlers and background tasks.

use std::path::PathBuf;
use std::sync::Arc;

use brood_protocol::Backend;
use brood_storage::{Store, StoredPicture};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use crate::access::Access;
use crate::breeding::Breeding;
use crate::dispatch::{Dispatch, FrameId};
use crate::event::Events;
use crate::host_name::HostNames;
use crate::idempotency::Ledger;
use crate::library::Library;
use crate::metric::Metrics;
use crate::picture::{Coalescer, PictureCache};
use crate::processors::Processors;

/// Shared handle of the state.
pub type App = Arc<AppState>;

/// State shared by all request handlers and background tasks.
pub struct AppState {
    /// Database.
    pub store: Store,
    /// Access control: tokens and their scopes.
    pub access: Access,
    /// Host names that the server answers to.
    pub hosts: HostNames,
    /// Backend that renders thumbnails.
    pub backend: Backend,
    /// Directory from which the web page is served; `None` for the copy embedded in the server.
    pub web_dir: Option<PathBuf>,
    /// Caches of materials, scenes and frames (all else that a picture depends on).
    pub library: Arc<Library>,
    /// Cache of pictures in memory and on disk, and list of pictures being rendered.
    pub picture_cache: PictureCache,
    /// Requested pictures, collected by frame for a short time before they become render jobs.
    pub render_batches: Coalescer<FrameId, Arc<StoredPicture>>,
    /// Leases (jobs given to workers for a time), finished jobs and known workers.
    pub dispatch: Dispatch,
    /// Event streams of lineages and searches.
    pub events: Events,
    /// Idempotency keys of running requests: a repeated request has no second effect.
    pub ledger: Ledger,
    /// Metrics that `/metrics` returns.
    pub metrics: Metrics,
    /// Permits for CPU-heavy work.
    pub processors: Processors,
    /// Maker of broods.
    pub breeding: Breeding,
    /// Cancelled when the server begins to stop.
    pub stopping: CancellationToken,
    /// Tasks that may outlive their request; the server waits for them before it ends.
    pub tasks: TaskTracker,
}
