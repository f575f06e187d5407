//! Requests and responses for searches.

use brood_genome::GenomeHash;
use brood_scene::Scene;
use serde::{Deserialize, Serialize};

use crate::schema::FitKind;
use crate::{
    DeferredAnswer, ExportAnswer, IndividualId, JobAnswer, JobId, LineageId, Seed, TargetId,
};

/// Body of `POST /v1/jobs`. Exactly one of `seconds`, `generations` and `evaluations` must be
/// given.
#[derive(Debug, Clone, PartialEq, Deserialize, utoipa::ToSchema)]
#[serde(deny_unknown_fields)]
pub struct CreateSearch {
    /// Must be `fit`.
    #[schema(value_type = FitKind)]
    pub kind: String,
    /// Id of the target to match.
    pub target: TargetId,
    /// Display name, 1 to 200 characters. Default: the name of the target.
    pub name: Option<String>,
    /// Search strategy: `auto`, `lobes`, `analytic`, `gp` or `hybrid`. `auto`, the default, is
    /// `analytic` for pictures and otherwise `hybrid`; with individuals to start from `hybrid`, or
    /// `gp` if no other strategy can start from them.
    pub strategy: Option<String>,
    /// Error that lobes minimise: `seen` or `e_log`. `seen` is E_log with differences of dark
    /// values added, which pictures show; the strategies `lobes` and `hybrid` minimise it by
    /// default. `e_log` is E_log alone, which the other strategies minimise.
    pub objective: Option<String>,
    /// Seed of the search. Default: 1.
    pub seed: Option<Seed>,
    /// Number of threads, 1 to 256. Default: all threads of the worker. Does not affect the result.
    #[schema(minimum = 1, maximum = 256)]
    pub threads: Option<u64>,
    /// Time budget in seconds, above 0 and at most 604,800 (7 days).
    #[schema(exclusive_minimum = 0, maximum = 604_800)]
    pub seconds: Option<f64>,
    /// Number of generations, 1 to 100,000. The result is the same on every machine.
    #[schema(minimum = 1, maximum = 100_000)]
    pub generations: Option<u64>,
    /// Number of evaluated candidates, 1 to 10^12. The search ends after the generation that
    /// reaches it. The result is the same on every machine.
    #[schema(minimum = 1, maximum = 1_000_000_000_000_u64)]
    pub evaluations: Option<u64>,
    /// Error at which the search ends before its budget is used up: E_log on the validation
    /// samples, above 0. Islands after the one that reaches it end at their next migrations.
    /// Default: none.
    pub target_error: Option<f64>,
    /// Number of islands, 1 to 64, for the strategies `gp` and `hybrid`: searches with different
    /// seeds, on up to as many workers, which take over each other's best programs every 32
    /// generations. Seconds and generations of the budget are those of each island, evaluations
    /// are divided among them. The front depends on the seed and on this number. Default: 1.
    #[schema(minimum = 1, maximum = 64)]
    pub islands: Option<u64>,
    /// True if the material is mirror symmetric, so that the fit need not distinguish left from
    /// right. Default: false.
    #[serde(default)]
    pub mirrored: bool,
    /// Lineage of the results. Default: a new lineage.
    pub lineage: Option<LineageId>,
    /// Individuals to start from, at most 64. Not every strategy can use every individual.
    #[serde(default)]
    pub start: Vec<IndividualId>,
}

/// Budget of a search.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum Budget {
    /// Time in seconds, without pauses and restarts.
    Seconds(f64),
    /// Number of generations.
    Generations(u32),
    /// Number of evaluated candidates. The search ends after the generation that reaches it.
    Evaluations(u64),
}

impl Budget {
    /// Returns the budget of one of several islands.
    #[must_use]
    pub fn of_island(self, islands: u32) -> Self {
        match self {
            Self::Evaluations(all) => Self::Evaluations(all.div_ceil(u64::from(islands.max(1)))),
            own => own,
        }
    }

    /// Returns the share of the budget, 0 to 1, that generations, evaluations and seconds have
    /// used.
    #[must_use]
    pub fn used_share(self, generation: u32, evaluations: u64, seconds: f64) -> f64 {
        let share = match self {
            Self::Seconds(budget) => seconds / budget,
            Self::Generations(budget) => f64::from(generation) / f64::from(budget),
            Self::Evaluations(budget) => evaluations as f64 / budget as f64,
        };
        share.clamp(0.0, 1.0)
    }
}

brood_brdf::named_enum! {
    /// State of a search.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, utoipa::ToSchema)]
    #[serde(rename_all = "lowercase")]
    pub enum SearchState {
        /// Waiting for a worker.
        Queued => "queued",
        /// Leased to a worker.
        Running => "running",
        /// Paused by a user.
        Paused => "paused",
        /// Ended: the budget is used up or the target error is reached.
        Succeeded => "succeeded",
        /// Failed for good.
        Failed => "failed",
        /// Cancelled by a user. Results found so far are kept.
        Cancelled => "cancelled",
    }
}

impl SearchState {
    /// True if the search has ended for good.
    #[must_use]
    pub fn is_final(self) -> bool {
        matches!(self, Self::Succeeded | Self::Failed | Self::Cancelled)
    }
}

/// Material that a search has found and added to its lineage as an individual.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct FoundMaterial {
    /// Id of the individual.
    pub individual: IndividualId,
    /// Content hash of the genome.
    #[schema(value_type = String)]
    pub hash: GenomeHash,
    /// E_log on the held-out samples: root mean square difference of ln(1 + f cos_i).
    pub e_log: f64,
    /// E_log on the fitted samples.
    pub e_log_fitted: f64,
    /// E_cbrt on the held-out samples: root mean square difference of the cube root of f cos_i.
    pub e_cbrt: f64,
    /// Relative L2 difference of f cos_i on the held-out samples.
    pub relative_l2: f64,
    /// Scalar operations per sample, including the energy limit.
    pub operations: u32,
    /// Number of fitted parameters.
    pub numbers: u32,
    /// Divisor that the energy limit applies to f; 1 or more.
    pub divisor: f64,
    /// Generation of the search in which the material was found, from 1.
    pub generation: u32,
    /// Difference from each image of the target, in the target's order; null unless the target is
    /// an image.
    pub views: Option<Vec<FoundView>>,
    /// Path of the thumbnail.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub thumbnail: Option<String>,
}

/// Difference of a found material's picture from an image of the target.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct FoundView {
    /// Root mean square difference of linear radiance over all pixels that are neither masked nor
    /// clipped.
    pub rmse: f64,
    /// Mean FLIP error at equal exposure, 0 to 1.
    pub flip: f64,
    /// Factor applied to the material's picture before the comparison; 1 unless the brightness of
    /// the image is unknown.
    pub gain: f64,
    /// True if the image was held out: it was not fitted.
    pub held_out: bool,
}

/// Options of a search, as requested.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct SearchOptions {
    /// Display name.
    pub name: String,
    /// Search strategy: `lobes`, `analytic`, `gp` or `hybrid`; never `auto`.
    pub strategy: String,
    /// Error that the search minimises: `seen` or `e_log`; null in searches of earlier versions.
    #[serde(default)]
    pub objective: Option<String>,
    /// Seed of the search.
    pub seed: Seed,
    /// Number of threads; null for all threads of the worker.
    pub threads: Option<u32>,
    /// True if the material is fitted as mirror symmetric.
    pub mirrored: bool,
    /// Budget.
    pub budget: Budget,
    /// Number of islands.
    #[serde(default = "one_island")]
    #[schema(required = true)]
    pub islands: u32,
    /// Error at which the search ends early: E_log on the validation samples; null if not given.
    pub target_error: Option<f64>,
    /// Individuals that the search starts from.
    pub start: Vec<IndividualId>,
}

/// Searches of earlier versions have one.
fn one_island() -> u32 {
    1
}

/// Island of a search.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct IslandAnswer {
    /// Number of the island, from 0.
    pub island: u32,
    /// State of the island. `succeeded`: its budget is used up, or the target error is reached.
    pub state: SearchState,
    /// Number of generations so far.
    pub generation: u32,
    /// Number of evaluated candidates so far.
    pub evaluations: u64,
    /// E_log of its best candidate on the samples it is fitted to.
    pub fitted: Option<f64>,
    /// E_log of its best candidate on the validation samples.
    pub held: Option<f64>,
    /// Search time in seconds, without waiting for other islands.
    pub seconds: f64,
}

/// Search.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct SearchAnswer {
    /// Id of the search.
    pub id: JobId,
    /// Always `fit`.
    #[schema(value_type = FitKind)]
    pub kind: String,
    /// State of the search.
    pub state: SearchState,
    /// Reason of a failure. `worker_lost`: its workers died repeatedly.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// Id of the target.
    pub target: TargetId,
    /// Lineage of the results.
    pub lineage: LineageId,
    /// Options, as requested.
    #[serde(flatten)]
    pub options: SearchOptions,
    /// Share of the budget that is used up, 0 to 1.
    pub progress: f64,
    /// Number of generations so far; of several islands, the least.
    pub generation: u32,
    /// Number of evaluated candidates so far, on all islands.
    pub evaluations: u64,
    /// E_log of the best candidate on the samples it is fitted to.
    pub fitted: Option<f64>,
    /// E_log of the best candidate on the validation samples: samples not used by the fit, but used
    /// to choose between fits.
    pub held: Option<f64>,
    /// Best material that has been added to the lineage.
    pub best: Option<FoundMaterial>,
    /// Search time in seconds, without pauses and restarts; of several islands, the longest.
    pub seconds: f64,
    /// Progress of each of several islands; empty for a single one.
    pub each_island: Vec<IslandAnswer>,
    /// Hash of the search state at the last checkpoint, which a worker reports about every ten
    /// seconds and at the end. It depends on the samples, the options and the generation
    /// alone, so it is unchanged by pauses and restarts. Of several islands, the hash of their
    /// hashes, once each has a checkpoint.
    pub population: Option<String>,
    /// Creation time, in milliseconds since 1970-01-01 UTC.
    pub created_ms: i64,
    /// Time of the first lease, in milliseconds since 1970-01-01 UTC.
    pub started_ms: Option<i64>,
    /// Time of the end, in milliseconds since 1970-01-01 UTC.
    pub ended_ms: Option<i64>,
}

/// Response of `GET /v1/jobs/{id}`: a search, an export, a render job or a deferred answer.
#[derive(Debug, Clone, PartialEq, Serialize, utoipa::ToSchema)]
#[serde(untagged)]
pub enum AnyJob {
    /// A search.
    Search(Box<SearchAnswer>),
    /// An export.
    Export(Box<ExportAnswer>),
    /// A render job.
    Render(Box<JobAnswer>),
    /// A deferred answer.
    Answer(Box<DeferredAnswer>),
}

/// Response of `GET /v1/jobs/{id}/front`.
#[derive(Debug, Clone, PartialEq, Serialize, utoipa::ToSchema)]
pub struct Front {
    /// Materials of the front: the best first, then by decreasing length. Empty until the search
    /// has ended.
    pub items: Vec<FoundMaterial>,
    /// Spread of the materials that match the pictures of the target. Null until the search has
    /// ended, and unless models were fitted to pictures.
    pub spread: Option<MaterialSpread>,
}

/// Spread of the materials that match the pictures of a target about as well as the best.
///
/// The maps have `cells` rows over theta_d and as many columns over theta_h, both from 0 to 90
/// degrees, at phi_d = 90 degrees, row by row.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct MaterialSpread {
    /// Expected E_log over all directions.
    pub e_log: f64,
    /// Number of rows, and of columns.
    pub cells: u32,
    /// Share of the samples in each cell.
    pub seen: Vec<f64>,
    /// Standard deviation of ln f in each cell; 0 below the surface.
    pub deviation: Vec<f64>,
    /// The picture after which the least error is expected. Null if no picture lowers it by a
    /// tenth, and without lamps without size and environments that `light_deg` turns.
    pub next: Option<NextScene>,
    /// True if `GET /v1/jobs/{id}/darkest.png` and `brightest.png` exist. False for searches of
    /// earlier versions.
    #[serde(default)]
    pub pictures: bool,
}

/// A picture that would tell more about a material.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct NextScene {
    /// Scene of the first picture with the light elsewhere.
    pub scene: Scene,
    /// Direction of the lamp from the object with the eye in front: to the right and upwards,
    /// degrees. Null if the environment is turned.
    pub light_deg: Option<[f64; 2]>,
    /// Expected E_log over all directions after it.
    pub e_log: f64,
}

/// Line of `GET /v1/jobs/{id}/log`: one generation of a search.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct SearchLine {
    /// Generation, from 1.
    pub generation: u32,
    /// Number of evaluated candidates so far.
    pub evaluations: u64,
    /// E_log of the best candidate on the samples it is fitted to.
    pub fitted: Option<f64>,
    /// E_log of the best candidate on the validation samples.
    pub held: Option<f64>,
    /// Median E_log of the population on the samples it is fitted to; null if not reported.
    pub median: Option<f64>,
    /// Share of the population that differs in more than its parameters, 0 to 1; null if not
    /// reported.
    pub diversity: Option<f64>,
    /// Total number of candidates that were skipped because an equal program had been evaluated;
    /// null if not reported.
    pub repeats: Option<u64>,
    /// Search time so far, in seconds.
    pub seconds: f64,
    /// Genome hash of the best individual so far.
    #[schema(value_type = Option<String>)]
    pub best: Option<GenomeHash>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn share_of_a_budget_ends_at_one() {
        assert_eq!(Budget::Seconds(40.0).used_share(9, 90, 10.0), 0.25);
        assert_eq!(Budget::Generations(12).used_share(9, 90, 10.0), 0.75);
        assert_eq!(Budget::Evaluations(180).used_share(9, 90, 10.0), 0.5);
        // A generation is finished when the budget is used up within it.
        assert_eq!(Budget::Evaluations(80).used_share(9, 90, 10.0), 1.0);
    }
}
