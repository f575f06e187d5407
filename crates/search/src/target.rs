//! What a search is to match: pairs of directions and the reflectance wanted there.

mod draw;
mod file;
mod image;
mod measured;
mod samples;

pub(crate) use draw::from_half;
pub use draw::{draw_pairs, narrow_pairs};
pub use file::{TargetFile, TargetFileError, TargetKind, UnknownKind};
pub use image::{ImageError, ImageTargetError, ImageView, PixelCounts, View, pooled};
pub use measured::{MeasuredTarget, TargetError};
pub use samples::Samples;
