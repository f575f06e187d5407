//! What a server is told at start.

use std::net::SocketAddr;
use std::path::PathBuf;

use brood_protocol::Backend;

/// What a server is told at start.
#[derive(Debug, Clone)]
pub struct ServerConfig {
    /// Where to listen; port 0 takes a free one.
    pub listen: SocketAddr,
    /// The data directory; made where it is missing.
    pub data: PathBuf,
    /// Bound of the picture cache on disk, and of a quarter of it in memory.
    pub cache_mib: u64,
    /// Host names to answer to besides localhost, 127.0.0.1 and [::1].
    pub allow_hosts: Vec<String>,
    /// The evaluator that thumbnails ask for.
    pub backend: Backend,
    /// Serves the page from this directory instead of the embedded copy.
    pub web_dir: Option<PathBuf>,
}

impl ServerConfig {
    /// The defaults for an address and a data directory.
    #[must_use]
    pub fn new(listen: SocketAddr, data: PathBuf) -> Self {
        Self {
            listen,
            data,
            cache_mib: 1024,
            allow_hosts: Vec::new(),
            backend: Backend::Auto,
            web_dir: None,
        }
    }
}
