//! Why a server does not start or does not go on, each in one line.

use std::net::SocketAddr;

use brood_storage::StorageError;

/// Why a server does not start or does not go on.
#[derive(Debug, thiserror::Error)]
pub enum ServerError {
    /// The port is taken.
    #[error("{0} is taken by another program; choose another address with --listen")]
    Taken(SocketAddr),
    /// The address cannot be bound.
    #[error("cannot listen on {address}: {source}")]
    Bind {
        /// The address asked for.
        address: SocketAddr,
        /// What the system says.
        source: std::io::Error,
    },
    /// Not loopback, and nobody could be let in.
    #[error(
        "{0} is reachable from other machines, but no token has been made; make one with `brood token add NAME --scope admin`"
    )]
    NoToken(SocketAddr),
    /// A name for `--allow-host` that is none.
    #[error("'{0}' is not a host name")]
    HostName(String),
    /// The data directory cannot be opened.
    #[error("cannot open the data directory: {0}")]
    Storage(#[from] StorageError),
    /// The picture cache cannot be opened.
    #[error("cannot open the picture cache: {0}")]
    Cache(std::io::Error),
    /// The system gives no random bytes.
    #[error("the system gives no random numbers")]
    Random,
}
