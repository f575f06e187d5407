//! State shared by all request handlers and background tasks.

use std::path::PathBuf;
use std::sync::Arc;

use brood_protocol::Backend;
use brood_storage::Store;
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use crate::access::Access;
use crate::breeding::Breeding;
use crate::deferred::Deferred;
use crate::dispatch::{Exports, PictureService, Searches, Workers};
use crate::event::Events;
use crate::host_name::HostNames;
use crate::idempotency::Ledger;
use crate::library::Library;
use crate::metric::Metrics;
use crate::open_connections::OpenConnections;
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
    /// Pictures, and the render jobs that make them.
    pub pictures: Arc<PictureService>,
    /// Searches.
    pub searches: Arc<Searches>,
    /// Exports that are made as jobs.
    pub exports: Arc<Exports>,
    /// Deferred answers and their jobs.
    pub deferred: Arc<Deferred>,
    /// Workers heard from recently.
    pub workers: Workers,
    /// Open connections.
    pub connections: OpenConnections,
    /// Event streams of lineages and searches.
    pub events: Arc<Events>,
    /// Idempotency keys of running requests: a repeated request has no second effect.
    pub ledger: Ledger,
    /// Metrics that `/metrics` returns.
    pub metrics: Arc<Metrics>,
    /// Permits for CPU-heavy work.
    pub processors: Processors,
    /// Maker of broods.
    pub breeding: Arc<Breeding>,
    /// Cancelled when the server stops soon: it still serves requests, but a balancer must send it
    /// no more.
    pub leaving: CancellationToken,
    /// Cancelled when the server begins to stop.
    pub stopping: CancellationToken,
    /// Tasks that may outlive their request; the server waits for them before it ends.
    pub tasks: TaskTracker,
}
