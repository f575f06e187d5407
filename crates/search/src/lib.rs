//! Search strategies that fit materials to measured targets.
//!
//! A [`Search`] fits samples of reflectance with one of the strategies of
//! [`Strategy`](brood_target::Strategy), generation by generation; it is deterministic, and its
//! state can be saved and resumed with the same bits. [`AskTell`] is a genetic search whose errors
//! are measured by the caller. [`Found`] measures the results on a target. Searches do not fit its
//! held-out samples; [`Search::reporting`] keeps the result of least error on them.
//!
//! The crate sees materials as programs and as reflectances for pairs of directions. It does not
//! depend on files, networks, databases or jobs: the caller passes samples in and keeps the
//! results.
//!
//! # Example
//! ```
//! use brood_brdf::{Model, ModelKind};
//! use brood_search::{Options, Search};
//! use brood_target::{Samples, Strategy, draw_pairs};
//!
//! let brdf = Model::new(ModelKind::Lambert).brdf();
//! let samples = Samples::of(&*brdf, draw_pairs(200, 1));
//! let options = Options { strategy: Strategy::Analytic, is_mirrored: true, ..Options::default() };
//! let mut search = Search::with_kinds(&samples, &options, vec![ModelKind::Lambert]);
//! let progress = search.step();
//! assert!(progress.held < 1e-3);
//! assert_eq!(search.best().unwrap().genome.layers()[0].kind(), ModelKind::Lambert);
//! ```

pub mod analytic;
mod ask;
mod calibration;
mod found;
mod front;
mod gp;
mod guided;
mod hybrid;
mod islands;
mod kept;
mod levenberg_marquardt;
pub mod lobes;
mod method;
#[cfg(test)]
mod picture_tests;
mod probe;
mod search;
mod solve;
mod spread;
#[cfg(test)]
mod test_material;
mod time_budget;

pub use ask::{AskOptions, AskTell, Evaluated, TellError};
pub use calibration::{Calibrated, Corrected, calibrate};
pub use found::Found;
pub use gp::Population;
pub use islands::{MIGRATION, island_seed};
pub use method::{Candidate, Outcome, Posterior, Progress};
pub use probe::Probe;
pub use search::{Options, Search, SearchError};
pub use spread::{NextPicture, Spread, SpreadMap};
pub use time_budget::TimeBudget;
