//! Targets of searches: what is fitted, and how errors are measured.
//!
//! A [`MeasuredTarget`] holds samples of reflectance ([`Samples`]), split into a fitted and a
//! held-out part. [`TargetFile`] reads one from a file of measurements, or from pictures of known
//! scenes ([`PictureBundle`]). [`metric`] measures errors between reflectances. [`Strategy`] names
//! the search strategies.
//!
//! The crate does not depend on strategies, networks or databases; files arrive as bytes. A server
//! that only stores and shows targets therefore links no search.
//!
//! # Example
//! ```
//! use brood_brdf::{Model, ModelKind};
//! use brood_target::{MeasuredTarget, Samples, metric};
//!
//! let model = Model::new(ModelKind::Conductor);
//! let target = MeasuredTarget::of(&*model.brdf())?;
//! let matt = Samples::of(&*Model::new(ModelKind::Lambert).brdf(), target.held.pairs().to_vec());
//! assert!(metric::e_log(&target.held.weighted(), &matt.weighted()) > 0.1);
//! # Ok::<(), brood_target::TargetError>(())
//! ```

mod as_measured;
mod bundle;
mod draw;
mod file;
mod image;
mod known;
mod means;
mod measured;
pub mod metric;
mod reflected;
mod samples;
mod strategy;

pub use as_measured::AsMeasured;
pub use bundle::{BundleError, BundledView, PictureBundle};
pub use draw::{draw_pairs, grazing_pairs, narrow_pairs, pair_of_half};
pub use file::{MeasuredFile, TargetFile, TargetFileError, TargetKind, UnknownKind};
pub use image::{
    ImageError, ImageTargetError, ImageView, PixelCounts, PixelStatus, View, highlights, pooled,
};
pub use known::{KnownView, Pictures, PicturesError, ViewError, ViewSetup};
pub use means::{LightMeans, MeanValue, PixelRadiance};
pub use measured::{MeasuredTarget, TargetError};
pub use reflected::Reflected;
pub use samples::{LowerBound, Samples};
pub use strategy::{
    FewPixels, NoObjective, Objective, Strategy, UnknownObjective, UnknownStrategy,
};
