//! Searches as they are asked for and answered: the jobs that people start. Pictures have jobs of their own.

use brood_genome::GenomeHash;
use serde::{Deserialize, Serialize};

use crate::schema::FitKind;
use crate::{IndividualId, JobAnswer, JobId, LineageId, Seed, TargetId};

/// Body of `POST /v1/jobs`. Exactly one of `seconds`, `generations` and `evaluations` is given.
#[derive(Debug, Clone, PartialEq, Deserialize, utoipa::ToSchema)]
#[serde(deny_unknown_fields)]
pub struct CreateSearch {
    /// `fit`.
    #[schema(value_type = FitKind)]
    pub kind: String,
    /// What is to be matched.
    pub target: TargetId,
    /// What people call it; the target's name unless said.
    #[serde(default)]
    pub name: Option<String>,
    /// How to search.
    #[serde(default)]
    pub strategy: Option<String>,
    /// What it draws from; 1 unless said.
    #[serde(default)]
    pub seed: Option<Seed>,
    /// Threads to use; all of the worker's unless said. They change no result.
    #[serde(default)]
    pub threads: Option<u64>,
    /// Ends after so much time.
    #[serde(default)]
    pub seconds: Option<f64>,
    /// Ends after so many generations: the same result on every machine.
    #[serde(default)]
    pub generations: Option<u64>,
    /// Ends with the generation in which so many materials have been held against samples: the same result on every machine.
    #[serde(default)]
    pub evaluations: Option<u64>,
    /// Ends before its budget is used up where the error on samples held back from the fit is no more than this.
    #[serde(default)]
    pub target_error: Option<f64>,
    /// The material is its own mirror image, so that the fit need not tell left from right.
    #[serde(default)]
    pub mirrored: bool,
    /// Where its results are born; one is made where none is given.
    #[serde(default)]
    pub lineage: Option<LineageId>,
    /// Individuals to start from, by the strategies that can.
    #[serde(default)]
    pub start: Vec<IndividualId>,
}

/// What ends a search.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum Budget {
    /// So much time, not counting pauses and restarts.
    Seconds(f64),
    /// So many generations.
    Generations(u32),
    /// The generation in which so many materials have been held against samples.
    Evaluations(u64),
}

/// Where a search stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum SearchState {
    /// Waiting for a worker.
    Queued,
    /// In a worker's hands.
    Running,
    /// Waiting for somebody to resume it.
    Paused,
    /// Its budget is used up, or its target error reached.
    Succeeded,
    /// It cannot go on.
    Failed,
    /// Somebody ended it; what it had found is there.
    Cancelled,
}

impl SearchState {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::Queued, Self::Running, Self::Paused, Self::Succeeded, Self::Failed, Self::Cancelled];

    /// Its word.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Queued => "queued",
            Self::Running => "running",
            Self::Paused => "paused",
            Self::Succeeded => "succeeded",
            Self::Failed => "failed",
            Self::Cancelled => "cancelled",
        }
    }

    /// The state of that word.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|state| state.name() == name)
    }

    /// Whether nothing follows.
    #[must_use]
    pub fn is_final(self) -> bool {
        matches!(self, Self::Succeeded | Self::Failed | Self::Cancelled)
    }
}

/// A material that a search has found and made an individual of its lineage.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct FoundMaterial {
    /// The individual.
    pub individual: IndividualId,
    /// Hash of its genome.
    #[schema(value_type = String)]
    pub hash: GenomeHash,
    /// E_log on the samples held out.
    pub e_log: f64,
    /// E_log on the samples it was fitted to.
    pub e_log_fitted: f64,
    /// E_cbrt on the samples held out.
    pub e_cbrt: f64,
    /// Relative L2 difference on the samples held out.
    pub relative_l2: f64,
    /// Scalar operations a sample, under the energy limit.
    pub operations: u32,
    /// Numbers that were fitted.
    pub numbers: u32,
    /// By what the energy limit divides.
    pub divisor: f64,
    /// The generation of the search in which it was found.
    pub generation: u32,
    /// How far it is from each picture of the target, in their order; null where the target is no pictures.
    #[serde(default)]
    pub views: Option<Vec<FoundView>>,
    /// Where its picture is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub thumbnail: Option<String>,
}

/// How far a material that was found is from a picture.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct FoundView {
    /// Root mean square difference of linear radiance, over all pixels that are neither masked nor clipped.
    pub rmse: f64,
    /// Mean FLIP error of both pictures at one exposure.
    pub flip: f64,
    /// What the material's picture was multiplied by: 1 unless brightness is not known.
    pub gain: f64,
    /// Whether nothing was fitted to the picture.
    pub held_out: bool,
}

/// How a search goes about it, as it was asked for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct SearchOptions {
    /// What people call it.
    pub name: String,
    /// How it searches.
    pub strategy: String,
    /// What it draws from.
    pub seed: Seed,
    /// Threads that it uses; null where it takes what its worker has.
    pub threads: Option<u32>,
    /// Whether left and right are taken for the same.
    pub mirrored: bool,
    /// What ends it.
    pub budget: Budget,
    /// The error that ends it before.
    pub target_error: Option<f64>,
    /// What it started from.
    pub start: Vec<IndividualId>,
}

/// A search as it is answered.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct SearchAnswer {
    /// Its id.
    pub id: JobId,
    /// `fit`.
    #[schema(value_type = FitKind)]
    pub kind: String,
    /// Where it stands.
    pub state: SearchState,
    /// Why it failed; `worker_lost` where workers died over it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// What is to be matched.
    pub target: TargetId,
    /// Where its results are born.
    pub lineage: LineageId,
    /// How it goes about it.
    #[serde(flatten)]
    pub options: SearchOptions,
    /// How much of the budget is used up, 0 to 1.
    pub progress: f64,
    /// Generations so far.
    pub generation: u32,
    /// How often a material has been held against samples.
    pub evaluations: u64,
    /// E_log of the best on the samples it is fitted to.
    pub fitted: Option<f64>,
    /// On those of them that are held back from the fit, to choose by.
    pub held: Option<f64>,
    /// The best that was made an individual.
    pub best: Option<FoundMaterial>,
    /// Time searched, across pauses and restarts.
    pub seconds: f64,
    /// Hash of the state that it would go on from: the same for the same samples, options and generation, whatever happened
    /// in between.
    pub population: Option<String>,
    /// When it was asked for, milliseconds since 1970.
    pub created_ms: i64,
    /// When a worker first had it.
    pub started_ms: Option<i64>,
    /// When it ended.
    pub ended_ms: Option<i64>,
}

/// Answer of `GET /v1/jobs/{id}`: a search, or the job that renders a brood's pictures.
#[derive(Debug, Clone, PartialEq, Serialize, utoipa::ToSchema)]
#[serde(untagged)]
pub enum AnyJob {
    /// A search.
    Search(Box<SearchAnswer>),
    /// Pictures.
    Render(Box<JobAnswer>),
}

/// Answer of `GET /v1/jobs/{id}/front`.
#[derive(Debug, Clone, PartialEq, Serialize, utoipa::ToSchema)]
pub struct Front {
    /// The best first, then by length; empty until the search has ended.
    pub items: Vec<FoundMaterial>,
}

/// A line of `GET /v1/jobs/{id}/log`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct SearchLine {
    /// Counted from 1.
    pub generation: u32,
    /// How often a material has been held against samples.
    pub evaluations: u64,
    /// E_log of the best on the samples it is fitted to.
    pub fitted: Option<f64>,
    /// On those of them that are held back from the fit.
    pub held: Option<f64>,
    /// E_log of the middle one of the population on the samples it is fitted to; null where it was not told.
    pub median: Option<f64>,
    /// Share of the population that differs in more than its numbers, 0 to 1; null where it was not told.
    pub diversity: Option<f64>,
    /// Candidates in all that were not evaluated, because the same program had been; null where it was not told.
    pub repeats: Option<u64>,
    /// Time searched.
    pub seconds: f64,
    /// The best individual so far.
    #[schema(value_type = Option<String>)]
    pub best: Option<GenomeHash>,
}
