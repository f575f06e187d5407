//! Pictures as the server knows them: a cache in memory over one on disk, and the flights of those being rendered.
//!
//! Everything here is derived and may be thrown away. It knows keys and bytes; how they are rendered and what a key
//! stands for is known elsewhere.

mod check;
mod coalesce;
mod disk;
mod gallery;
mod segment;

pub use check::check;
pub use coalesce::Coalescer;
pub use disk::Disk;
pub use gallery::{Boarding, Failure, Gallery};
