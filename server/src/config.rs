//! Start-up configuration of a server.

use std::net::SocketAddr;
use std::path::PathBuf;

use brood_protocol::Backend;
use brood_storage::{BlobAddress, DatabaseAddress};

/// Start-up configuration of a server.
#[derive(Debug, Clone)]
pub struct ServerConfig {
    /// Address to listen on; port 0 selects a free port.
    pub listen: SocketAddr,
    /// Data directory, created if missing.
    pub data: PathBuf,
    /// PostgreSQL database for everything but pictures and files of exports; `None` for one in the
    /// data directory.
    pub database: Option<DatabaseAddress>,
    /// Object store for uploads and checkpoints over 1 MiB, beside a PostgreSQL database; `None`
    /// for rows of the database.
    pub blobs: Option<BlobAddress>,
    /// Capacity of the picture cache on disk in MiB; the cache in memory gets a quarter of it.
    pub cache_mib: u64,
    /// Host names accepted besides `localhost`, `127.0.0.1` and `[::1]`.
    pub allow_hosts: Vec<String>,
    /// Backend that renders thumbnails.
    pub backend: Backend,
    /// Directory to serve the page from instead of the embedded copy.
    pub web_dir: Option<PathBuf>,
}

impl ServerConfig {
    /// Returns the defaults for an address and a data directory.
    #[must_use]
    pub fn new(listen: SocketAddr, data: PathBuf) -> Self {
        Self {
            listen,
            data,
            database: None,
            blobs: None,
            cache_mib: 1024,
            allow_hosts: Vec::new(),
            backend: Backend::Auto,
            web_dir: None,
        }
    }
}
