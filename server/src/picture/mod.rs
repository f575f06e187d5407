//! Picture cache: in memory over disk, with the renders in flight.
//!
//! Everything here is derived and can be recomputed. Handles keys and bytes only; independent of
//! how pictures are rendered and what a key describes.

mod cache;
mod check;
mod coalesce;
mod disk;
mod segment;
mod url;
mod webp;

pub use cache::{Failure, Lookup, PictureCache};
pub use check::{check, decode};
pub use coalesce::Coalescer;
pub use disk::{DiskCache, FOLDER as CACHE_FOLDER, check_pictures};
pub use url::thumbnail_url;
pub use webp::webp_of_png;
