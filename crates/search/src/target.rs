//! Targets of searches: pairs of directions and the reflectance to match there.

mod bundle;
mod draw;
mod file;
mod image;
mod known;
mod measured;
mod reflected;
mod samples;

pub use bundle::{BundleError, BundledView, PictureBundle};
pub use draw::{draw_pairs, narrow_pairs};
pub(crate) use draw::{from_half, grazing_pairs};
pub use file::{MeasuredFile, TargetFile, TargetFileError, TargetKind, UnknownKind};
pub use image::{ImageError, ImageTargetError, ImageView, PixelCounts, PixelStatus, View, pooled};
pub use known::{KnownView, Pictures, PicturesError, ViewError, ViewSetup};
pub(crate) use measured::LARGEST;
pub use measured::{MeasuredTarget, TargetError};
pub use reflected::Reflected;
pub use samples::Samples;
