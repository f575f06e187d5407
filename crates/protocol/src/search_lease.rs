//! Searches in workers' hands: what they get, what they tell after each generation, what they are told.
//!
//! The same binary form as other leases. The ticket is the search and its epoch: whatever else happens to the search counts
//! the epoch up, and a word under an old one changes nothing.

use serde::{Deserialize, Serialize};

use crate::{Budget, FoundView, JobId};

/// Asks for a search.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct SearchRequest {
    /// Who asks.
    pub worker: String,
    /// How long the server may hold the request back when there is nothing to do.
    pub wait_ms: u32,
}

/// Proof of a lease of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct SearchTicket {
    /// The search.
    pub job: JobId,
    /// Counted up by whatever happens to it.
    pub epoch: u64,
}

/// A search in a worker's hands.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SearchGrant {
    /// The lease.
    pub ticket: SearchTicket,
    /// It lapses unless renewed within this time.
    pub ttl_ms: u32,
    /// What kind of file the target is.
    pub target_kind: String,
    /// Hash of the file, which is at `GET /v1/leases/targets/{hash}`.
    pub target_hash: [u8; 32],
    /// How it searches.
    pub strategy: String,
    /// What it draws from.
    pub seed: u64,
    /// Whether left and right are taken for the same.
    pub is_mirrored: bool,
    /// Canonical bytes of the genomes that it starts from.
    pub start: Vec<Vec<u8>>,
    /// Threads to use; all of the worker's where absent.
    pub threads: Option<u32>,
    /// What ends it.
    pub budget: Budget,
    /// The error that ends it before.
    pub target_error: Option<f64>,
    /// The state to go on from; none at the start.
    pub checkpoint: Option<Vec<u8>>,
    /// Time searched before.
    pub seconds: f64,
    /// Error, on what is held back, of the best that was made an individual.
    pub recorded: Option<f64>,
}

/// A target's file for a worker.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct TargetBytes {
    /// As it was uploaded.
    #[serde(with = "crate::lease::octets")]
    pub bytes: Vec<u8>,
}

/// What one generation came to.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct GenerationLine {
    /// Counted from 1.
    pub generation: u32,
    /// How often a material has been held against samples.
    pub evaluations: u64,
    /// E_log of the best where it is fitted.
    pub fitted: f64,
    /// E_log of the best where it is held back.
    pub held: f64,
    /// Time searched.
    pub seconds: f64,
}

/// A material that was found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MeasuredMaterial {
    /// Canonical bytes of its genome.
    pub genome: Vec<u8>,
    /// Scalar operations a sample.
    pub operations: u32,
    /// Numbers that were fitted.
    pub numbers: u32,
    /// E_log on the samples held out.
    pub e_log: f64,
    /// E_log on the samples it was fitted to.
    pub e_log_fitted: f64,
    /// E_cbrt on the samples held out.
    pub e_cbrt: f64,
    /// Relative L2 difference on the samples held out.
    pub relative_l2: f64,
    /// By what the energy limit divides.
    pub divisor: f64,
    /// How far it is from each picture of the target; none where the target is no pictures.
    pub views: Option<Vec<FoundView>>,
}

/// What a worker tells.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SearchReport {
    /// The lease.
    pub ticket: SearchTicket,
    /// What came of it.
    pub news: SearchNews,
}

/// What came of a search.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum SearchNews {
    /// Generations, and the state after the last of them.
    Generations {
        /// One each.
        lines: Vec<GenerationLine>,
        /// The state.
        #[serde(with = "crate::lease::octets")]
        checkpoint: Vec<u8>,
        /// The best, where it is notably better than the one recorded before.
        best: Option<MeasuredMaterial>,
    },
    /// It is over.
    Finished {
        /// The front, the best first.
        front: Vec<MeasuredMaterial>,
        /// Time searched in all.
        seconds: f64,
    },
    /// It cannot go on, and trying again would not help.
    Failed(String),
}

/// What a worker is told after its report.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Directive {
    /// Go on.
    GoOn,
    /// The search is not this worker's any more: it has ended, or others had waited long enough for a turn.
    Leave,
}
