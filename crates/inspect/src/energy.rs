//! Largest directional albedo of a genome.

use brood_eval::energy_limit;
use brood_genome::Genome;
use brood_program::Program;
use serde::{Deserialize, Serialize};

/// Largest directional albedo: the share of light from one direction that is reflected.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct Energy {
    /// Upper bound of the directional albedo over incident directions, channels and, if the program
    /// reads them, texture positions in [0, 1]^2; after the energy limit if the genome has one.
    pub max_albedo: f64,
    /// The same bound before the energy limit.
    pub unlimited_albedo: f64,
    /// Part of both bounds that allows for what the search may have missed, relative to the largest
    /// albedo found (docs/maths/energy.md).
    pub error_bound: f64,
    /// Divisor of f; 1 without the limit.
    pub divisor: f64,
    /// Angle of incidence of the largest albedo, in degrees from the normal.
    pub theta_deg: f64,
    /// True if the genome has the energy limit.
    pub limited: bool,
    /// Number of reflectances evaluated.
    pub samples: usize,
}

impl Energy {
    /// Searches for the largest directional albedo of a genome, without its limit, and applies the
    /// limit to the result.
    pub(crate) fn of(genome: &Genome) -> Self {
        let free = energy_limit(&Program::lower(genome));
        let limited = genome.is_limited();
        let divisor = if limited { free.divisor } else { 1.0 };
        Self {
            max_albedo: free.bound() / divisor,
            unlimited_albedo: free.bound(),
            error_bound: free.error_bound,
            divisor,
            theta_deg: free.theta_deg,
            limited,
            samples: free.samples,
        }
    }
}
