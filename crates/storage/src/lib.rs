//! Store of the server, on SQLite or PostgreSQL: lineages, generations, individuals, genomes,
//! scenes, meshes, picture keys, search targets, searches, exports, idempotency records and tokens.
//!
//! All SQL is in this crate. [`Store`] has an engine with its connections, and the lock of the data
//! directory. It does not depend on routes, status codes or evaluators.
//!
//! Durability: when a write returns, its transaction is on disk. SQLite commits waiting writes
//! together (WAL, `synchronous=FULL`); there, steps of searches, exports, imports and removals
//! survive the end of the process only, and the write that ends them makes all of them durable.
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

mod address;
mod backup;
mod blob;
mod blob_address;
mod blob_http;
mod blob_join;
mod blob_store;
mod blob_sweep;
mod check;
mod clock;
mod column;
mod compact;
mod engine;
mod error;
mod export;
mod export_file;
mod family;
mod generation;
mod genome;
mod idempotency;
mod import;
mod individual;
mod island;
mod lease;
mod lease_fault;
mod light_asset;
mod lineage;
mod mesh;
mod migrate;
mod outline;
mod packing;
mod picture;
mod purge;
mod row;
mod scene;
mod search;
mod search_lease;
mod slice;
mod sql;
mod store;
mod target;
mod token;
mod write;

#[cfg(test)]
mod tests;

pub use address::DatabaseAddress;
pub use blob_address::BlobAddress;
pub use check::CheckedStore;
pub use compact::Compacted;
pub use engine::postgres::bus::{Bus, BusEvent, BusLink};
pub use error::StorageError;
pub use export::{ClaimedExport, NewExport, NewExportFile, StoredExport, StoredExportFile};
pub use generation::{NewGeneration, NewIndividual, StoredGeneration};
pub use genome::{NewGenome, StoredGenome};
pub use idempotency::{Idempotency, IdempotencyLookup};
pub use import::NewImport;
pub use individual::StoredIndividual;
pub use island::{IslandEnd, IslandEnded, StoredArrival};
pub use lease::{EndedLease, LostLeases};
pub use lineage::{InvalidCursor, LineageCursor, LineageFilter};
pub use mesh::StoredMesh;
pub use migrate::{Migrated, MigrationStep, migrate};
pub use outline::StoredOutline;
pub use picture::{NewPicture, StoredPicture};
pub use search::{Extreme, NewSearch, SearchChange, SearchEnd, StoredSearch};
pub use search_lease::{ClaimedSearch, SearchStep};
pub use store::{Store, StoreCounts};
pub use target::NewTarget;
pub use token::{Scope, Token};
pub use write::CommitTimes;
