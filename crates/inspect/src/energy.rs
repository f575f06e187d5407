//! How much a genome reflects.

use brood_eval::energy_limit;
use brood_genome::Genome;
use brood_program::Program;
use serde::{Deserialize, Serialize};

/// The largest share of the light from one direction that is reflected.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct Energy {
    /// The largest directional albedo over incident directions, channels and, where they are read, texture positions of
    /// [0, 1]^2, as the genome is seen: under the energy limit where it asks for that.
    pub max_albedo: f64,
    /// The same without the limit.
    pub unlimited_albedo: f64,
    /// Relative error bound of both, estimated (docs/maths/energy.md).
    pub error_bound: f64,
    /// What f is divided by: 1 without the limit.
    pub divisor: f64,
    /// Where it is largest: degrees from the normal.
    pub theta_deg: f64,
    /// Whether the genome asks for the limit.
    pub limited: bool,
    /// Reflectances that this took.
    pub samples: usize,
}

impl Energy {
    /// Of a genome.
    pub(crate) fn of(genome: &Genome) -> Self {
        let free = energy_limit(&Program::lower(genome));
        let limited = genome.is_limited();
        let divisor = if limited { free.divisor } else { 1.0 };
        Self {
            max_albedo: free.albedo / divisor,
            unlimited_albedo: free.albedo,
            error_bound: free.error_bound,
            divisor,
            theta_deg: free.theta_deg,
            limited,
            samples: free.samples,
        }
    }
}
