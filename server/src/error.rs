//! Errors of starting and running a server, each one line of text.

use std::net::SocketAddr;

use brood_storage::StorageError;

/// Error of starting or running a server.
#[derive(Debug, thiserror::Error)]
pub enum ServerError {
    /// The address is already in use.
    #[error("{0} is in use by another program; choose another address with --listen")]
    Taken(SocketAddr),
    /// The address cannot be bound.
    #[error("cannot listen on {address}: {source}")]
    Bind {
        /// Requested address.
        address: SocketAddr,
        /// Error of the system.
        source: std::io::Error,
    },
    /// The address is reachable from other machines and there is no token.
    #[error(
        "{0} is reachable from other machines, but there is no token; add one with `brood token add NAME --scope admin`"
    )]
    NoToken(SocketAddr),
    /// A name for `--allow-host` is not a host name.
    #[error("'{0}' is not a host name")]
    HostName(String),
    /// The data directory cannot be opened.
    #[error("cannot open the data directory: {0}")]
    Storage(#[from] StorageError),
    /// The PostgreSQL database cannot be opened.
    #[error("cannot open the database: {0}")]
    Database(StorageError),
    /// The object store of large files cannot be used.
    #[error("{0}")]
    Blobs(StorageError),
    /// The data directory cannot be closed.
    #[error("the server stopped: {0}")]
    Closing(StorageError),
    /// The picture cache cannot be opened.
    #[error("cannot open the picture cache: {0}")]
    Cache(std::io::Error),
    /// The folder of exports cannot be opened.
    #[error("cannot open the folder of exports: {0}")]
    Exports(std::io::Error),
    /// The system has no random bytes.
    #[error("the system has no random bytes")]
    Random,
}
