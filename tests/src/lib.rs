//! Tools for tests from outside: the built binary, a real server on a free port, and answers that
//! explain failed assertions.
//!
//! Owns processes and HTTP. Does not use the types behind the answers: a test reads JSON like any
//! other client.

mod answer;
mod binary;
mod database;
mod http;
mod lineage;
mod raw;
mod server;
mod target;

pub use answer::Answer;
pub use binary::{Finished, binary, brood, target_directory};
pub use database::of as database_of;
pub use http::http_client;
pub use lineage::{TestLineage, hashes, ids, seed_of, text_of};
pub use raw::raw_request;
pub use server::{ServerOptions, TestServer};
pub use target::{glossy_csv, upload, upload_parts};
