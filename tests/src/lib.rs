//! What every test from outside needs: the built binary, a real server on a free port, and answers that explain
//! themselves when they are not what was expected.
//!
//! Owns processes and HTTP. Refuses to know the types behind the answers: a test reads the JSON that a stranger reads.

mod answer;
mod binary;
mod lineage;
mod raw;
mod server;
mod target;

pub use answer::Answer;
pub use binary::{Finished, binary, brood, target_directory};
pub use lineage::{TestLineage, hashes, ids, seed_of, text_of};
pub use raw::raw_request;
pub use server::{ServerOptions, TestServer};
pub use target::{glossy_csv, upload, upload_parts};
