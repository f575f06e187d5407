//! The service: routes, brood making, and the dispatch of pictures to workers.
//!
//! This crate owns HTTP: routes, status codes, access, limits, the event streams and the derived cache of pictures. It
//! refuses to know SQL (that is `brood-storage`) and how pictures of broods are made: workers render them. Targets of searches are no programs;
//! the few pictures that are wanted of them are drawn here.
//!
//! ```no_run
//! # async fn example() -> Result<(), brood_server::ServerError> {
//! use brood_server::{Server, ServerConfig};
//! use tokio_util::sync::CancellationToken;
//!
//! let config = ServerConfig::new("127.0.0.1:7320".parse().expect("an address"), "data".into());
//! let server = Server::bind(config).await?;
//! println!("brood is listening on http://{}", server.local_addr());
//! server.run(CancellationToken::new()).await
//! # }
//! ```

mod access;
mod breeding;
mod config;
mod connection;
mod controller;
mod dispatch;
mod error;
mod event;
mod extract;
mod idempotency;
mod layer;
mod library;
mod lighting;
mod limit;
mod listen;
mod metric;
mod picture;
mod presenter;
mod problem;
mod route;
mod server;
mod shelf;
mod stage;
mod state;

pub use config::ServerConfig;
pub use error::ServerError;
pub use route::openapi;
pub use server::{Server, Undertaker};
