//! Lease protocol of searches.
//!
//! Messages have the binary form of [`encode`](crate::encode). A ticket is the search and its
//! epoch. Every other change of the search increments the epoch, so that reports under an older
//! epoch are rejected.

use serde::{Deserialize, Serialize};

use crate::{Budget, FoundView, JobId, SceneCorrection};

/// A best material is reported and recorded once its validation error is below this share of the
/// last recorded one.
pub const NOTABLE_RATIO: f64 = 0.9;

/// Request for a search.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct SearchRequest {
    /// Name of the worker.
    pub worker: String,
    /// Longest time that the server may delay its answer if the queue is empty, in milliseconds.
    pub wait_ms: u32,
}

/// Proof of a lease of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct SearchTicket {
    /// Id of the search.
    pub job: JobId,
    /// Epoch of the search; every change of its state increments it.
    pub epoch: u64,
}

/// Search that is leased to a worker.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SearchGrant {
    /// Ticket of the lease.
    pub ticket: SearchTicket,
    /// Time to live: the lease expires unless a heartbeat or report arrives within this time, in
    /// milliseconds.
    pub ttl_ms: u32,
    /// Kind of the target's file.
    pub target_kind: String,
    /// Content hash of the target's file, at `GET /v1/leases/targets/{hash}`.
    pub target_hash: [u8; 32],
    /// Search strategy.
    pub strategy: String,
    /// Error that lobes minimise.
    pub objective: String,
    /// Seed of the search.
    pub seed: u64,
    /// Number of islands of the search.
    pub islands: u32,
    /// Number of this island, from 0.
    pub island: u32,
    /// Arrival from the island before, to be added to the search at the checkpoint.
    pub arrival: Option<Arrival>,
    /// True if the material is fitted as mirror symmetric.
    pub is_mirrored: bool,
    /// Canonical bytes of the genomes to start from.
    pub start: Vec<Vec<u8>>,
    /// Number of threads; `None` for all threads of the worker.
    pub threads: Option<u32>,
    /// Budget of this island.
    pub budget: Budget,
    /// Error at which the search ends early, on the validation samples.
    pub target_error: Option<f64>,
    /// Checkpoint to resume from; `None` at the start.
    pub checkpoint: Option<Vec<u8>>,
    /// Search time before this lease, in seconds.
    pub seconds: f64,
    /// Validation error of the best material that is already an individual.
    pub recorded: Option<f64>,
}

/// Target file, as it is sent to a worker.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct TargetBytes {
    /// Contents of the uploaded file.
    #[serde(with = "crate::lease::octets")]
    pub bytes: Vec<u8>,
}

/// Summary of a generation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct GenerationLine {
    /// Generation, from 1.
    pub generation: u32,
    /// Number of evaluated candidates so far.
    pub evaluations: u64,
    /// E_log of the best candidate on the samples it is fitted to.
    pub fitted: f64,
    /// E_log of the best candidate on the validation samples.
    pub held: f64,
    /// Median E_log of the population on the samples it is fitted to.
    pub median: f64,
    /// Share of the population that differs in more than its parameters, 0 to 1.
    pub diversity: f64,
    /// Total number of candidates that were skipped because an equal program had been evaluated.
    pub repeats: u64,
    /// Search time so far, in seconds.
    pub seconds: f64,
}

/// Found material with its errors.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MeasuredMaterial {
    /// Canonical bytes of the genome.
    pub genome: Vec<u8>,
    /// Scalar operations per sample.
    pub operations: u32,
    /// Number of fitted parameters.
    pub numbers: u32,
    /// E_log on the held-out samples.
    pub e_log: f64,
    /// E_log on the fitted samples.
    pub e_log_fitted: f64,
    /// E_cbrt on the held-out samples.
    pub e_cbrt: f64,
    /// Relative L2 difference on the held-out samples.
    pub relative_l2: f64,
    /// Divisor of the energy limit; 1 or more.
    pub divisor: f64,
    /// Difference from each image of the target; `None` unless the target is an image.
    pub views: Option<Vec<FoundView>>,
}

/// Report of a worker about its search.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SearchReport {
    /// Ticket of the lease.
    pub ticket: SearchTicket,
    /// Time since the grant by the worker's clock, in milliseconds.
    pub held_ms: u64,
    /// Progress or end of the search.
    pub update: SearchUpdate,
}

/// Progress or end of a search.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum SearchUpdate {
    /// Completed generations, or a checkpoint after those that have been reported.
    Generations {
        /// One line per generation.
        lines: Vec<GenerationLine>,
        /// Checkpoint after the last generation: every ten seconds, with a material, at the end of
        /// the budget, on [`Directive::Yield`], and when the worker stops.
        checkpoint: Option<Vec<u8>>,
        /// Best material, if it is notably better than the recorded one.
        best: Option<MeasuredMaterial>,
        /// Canonical bytes of programs for the next island, if the last generation is one after
        /// which they migrate; with a checkpoint.
        emigrants: Option<Vec<Vec<u8>>>,
    },
    /// The search is complete, or one of its islands.
    Finished {
        /// Front of the search, the best first.
        front: Vec<MeasuredMaterial>,
        /// Total search time, in seconds.
        seconds: f64,
        /// True if the target error is reached.
        is_reached: bool,
    },
    /// Permanent failure: the search must not be retried.
    Failed(String),
    /// Corrections of the scenes of all images of the target, at the start of each lease.
    Calibrated(Vec<CalibratedView>),
    /// Spread of the materials that match the pictures, before the end.
    Spread(ReportedSpread),
}

/// Spread of the materials that match the pictures of a target, with the darkest and the brightest
/// picture.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ReportedSpread {
    /// JSON of a [`MaterialSpread`](crate::MaterialSpread), because scenes have fields that need a
    /// self-describing format.
    pub spread: String,
    /// 5 % quantile of each pixel over the materials under other lights, or in the scene of the
    /// first picture if its light cannot be moved; a PNG.
    #[serde(with = "crate::lease::octets")]
    pub darkest: Vec<u8>,
    /// 95 % quantile, at the same exposures.
    #[serde(with = "crate::lease::octets")]
    pub brightest: Vec<u8>,
}

/// Image of a target in its corrected scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CalibratedView {
    /// The corrected scene as JSON.
    pub scene: String,
    /// Corrected numbers; empty if the scene is as stated.
    pub corrections: Vec<SceneCorrection>,
}

/// Arrival from the island before: programs, or its end.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum Arrival {
    /// Canonical bytes of programs of the same generation.
    Migrants(Vec<Vec<u8>>),
    /// The island has ended before that generation.
    Ended {
        /// True if it has reached the target error, so that the other islands end too.
        is_reached: bool,
    },
}

/// Answer of the server to a report.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum Directive {
    /// Continue the search.
    Continue,
    /// Continue with this, after a report with emigrants.
    Take(Arrival),
    /// Report a checkpoint: the search was paused, or another one has waited for a full time slice.
    Yield,
    /// Stop: the search has ended, was paused, or another one has waited for a full time slice.
    Stop,
}
