//! Durable facts in one SQLite file: lineages, generations, individuals, genomes, scenes, meshes, what picture keys
//! stand for, the work queue, idempotency records and tokens.
//!
//! This crate owns all SQL, the one write connection and its group commits, the read pool, and the lock of the data
//! directory. It refuses to know routes, status codes, evaluators and pixels.
//!
//! What a write promises: when it returns, its transaction is on disk (WAL, `synchronous=FULL`), together with the
//! writes of others that were committed in the same group. Only movements of the work queue are content with
//! surviving the process; a power cut may undo them, and the work is done again.
//!
//! ```
//! # let runtime = tokio::runtime::Runtime::new().unwrap();
//! # runtime.block_on(async {
//! # let dir = tempfile::tempdir().unwrap();
//! use brood_storage::{Scope, Store};
//!
//! let store = Store::open(dir.path()).await?;
//! store.create_token("laptop", Scope::Breed, [7; 32], None).await?;
//! assert_eq!(store.token_by_hash([7; 32]).await?.unwrap().name, "laptop");
//! store.close().await
//! # }).unwrap();
//! ```

mod connection;
mod error;
mod family;
mod generation;
mod genome;
mod idempotency;
mod import;
mod individual;
mod job;
mod light_asset;
mod lineage;
mod lock;
mod mesh;
mod picture;
mod purge;
mod row;
mod scene;
mod search;
mod search_lease;
mod store;
mod target;
mod token;
mod writer;

#[cfg(test)]
mod tests;

pub use error::StorageError;
pub use generation::{NewGeneration, NewIndividual, StoredGeneration};
pub use genome::{NewGenome, StoredGenome};
pub use idempotency::{Idempotency, Remembered};
pub use import::NewImport;
pub use individual::StoredIndividual;
pub use job::{ClaimedJob, FIRST_EPOCH, JobKind, JobRow, JobState, NewJob, Queue, QueueDepth};
pub use lineage::{BadCursor, LineageCursor, NewLineage};
pub use mesh::{MeshRow, NewMesh};
pub use picture::{NewPicture, PictureRow};
pub use search::{NewSearch, SearchChange, StoredSearch};
pub use search_lease::{ClaimedSearch, SearchEnd, SearchStep};
pub use store::{Store, StoreCounts};
pub use target::NewTarget;
pub use token::{Scope, Token};
pub use writer::Committed;
