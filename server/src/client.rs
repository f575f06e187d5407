//! Client of a request: its token or, without one, its address. Clients share the workers fairly.

use std::net::IpAddr;

/// Client of a request.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Client {
    /// Hash of its token.
    Token([u8; 32]),
    /// Address of a request without token.
    Address(IpAddr),
    /// The server itself, for work that belongs to no request.
    Server,
}

tokio::task_local! {
    static CLIENT: Client;
}

impl Client {
    /// Returns the client with this token or address.
    pub fn new(token: Option<&str>, address: Option<IpAddr>) -> Self {
        match (token, address) {
            (Some(token), _) => Self::Token(*blake3::hash(token.as_bytes()).as_bytes()),
            (None, Some(address)) => Self::Address(address),
            (None, None) => Self::Server,
        }
    }

    /// Returns the client of the request that this task handles. Tasks that it spawns are the
    /// server's.
    pub fn current() -> Self {
        CLIENT.try_with(|client| *client).unwrap_or(Self::Server)
    }

    /// Runs a future as this client.
    pub async fn run<F: Future>(self, future: F) -> F::Output {
        CLIENT.scope(self, future).await
    }
}

/// Address of the other end of a connection, an extension of its requests.
#[derive(Debug, Clone, Copy)]
pub struct Peer(pub IpAddr);
