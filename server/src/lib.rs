//! HTTP server of brood: routes, breeding, and dispatch of render jobs and searches to workers.
//!
//! Owns everything about HTTP: routes, status codes, access, limits, event streams and the picture
//! cache. Contains no SQL, which is in `brood-storage`. Workers render the pictures of individuals;
//! the few pictures of search targets, which are not programs, are drawn here.
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
mod answer;
mod breeding;
mod bundle;
mod bus;
mod client;
mod clock;
mod config;
mod connection;
mod control_image;
mod controller;
mod deferred;
mod dispatch;
mod error;
mod event;
mod export_folder;
mod extract;
mod host_name;
mod idempotency;
mod layer;
mod library;
mod limit;
mod listen;
mod metric;
mod open_connections;
mod picture;
mod presenter;
mod problem;
mod processors;
mod route;
mod scene_asset;
mod server;
mod server_timing;
mod state;
mod worker_reaper;

pub use clock::now_ms;
pub use config::ServerConfig;
pub use error::ServerError;
pub use picture::check_pictures;
pub use route::openapi;
pub use server::Server;
pub use worker_reaper::WorkerReaper;
