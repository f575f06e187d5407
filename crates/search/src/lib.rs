//! Searches: what is to be matched, how far a material is from it, and the strategies that come closer.
//!
//! This crate owns targets, metrics and strategies; it sees materials as programs and as reflectances for pairs of
//! directions. It refuses to know files, networks, databases and jobs: whoever runs a search hands over samples and keeps
//! what comes back.

pub mod analytic;
mod ask;
mod found;
mod gp;
mod hybrid;
pub mod lobes;
mod method;
pub mod metric;
mod pace;
mod probe;
mod search;
mod solve;
mod target;
#[cfg(test)]
mod test_material;

pub use ask::{AskOptions, AskTell, TellError, Told};
pub use found::Found;
pub use gp::Population;
pub use method::{Candidate, Outcome, Progress};
pub use pace::Pace;
pub use probe::Probe;
pub use search::{DIALECT, Options, Search, SearchError, Strategy};
pub use target::{
    BundleError, BundledView, ImageError, ImageTargetError, ImageView, KnownView, MeasuredFile,
    MeasuredTarget, PictureBundle, Pictures, PicturesError, PixelCounts, PixelFate, Reflected,
    Samples, Setting, TargetError, TargetFile, TargetFileError, TargetKind, UnknownKind, View,
    ViewError, draw_pairs, narrow_pairs, pooled,
};
