//! Searches: what is to be matched, how far a material is from it, and the strategies that come closer.
//!
//! This crate owns targets, metrics and strategies; it sees materials as programs and as reflectances for pairs of
//! directions. It refuses to know files, networks, databases and jobs: whoever runs a search hands over samples and keeps
//! what comes back.

pub mod lobes;
pub mod metric;
mod target;

pub use target::{MeasuredTarget, Samples, TargetError, draw_pairs, narrow_pairs};
