//! Responses for generations and individuals.

use brood_genome::GenomeHash;
use serde::{Deserialize, Serialize};

use crate::{BreedOptions, GenerationId, IndividualId, LineageId, ParentRef, Seed};

/// Individual: a genome in its place in a brood.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct Individual {
    /// Id of the individual.
    pub id: IndividualId,
    /// Content hash of the genome: 64 hexadecimal digits.
    #[schema(value_type = String)]
    pub hash: GenomeHash,
    /// Slot in the brood, from 0.
    pub slot: u32,
    /// Parents, as they were given in the request.
    pub parents: Vec<ParentRef>,
    /// Origin: `random`, `mutate`, `recombine`, `adopt` or `fit`.
    pub operator: String,
    /// Number of live instructions, those that can change the result.
    pub live_instructions: u32,
    /// Names of the genome's layers (analytic models added to the program), lowest first. Absent if
    /// there are none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub layers: Vec<String>,
    /// Path of the thumbnail.
    pub thumbnail: String,
    /// True if a user marked the individual as a favourite.
    pub favourite: bool,
    /// Note of a user.
    pub note: String,
    /// True if no draw gave a program that differs from those of its parents and siblings.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub twin: bool,
    /// Number of changes; also the ETag.
    pub version: u64,
}

/// Individual with its lineage and generation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct IndividualDetail {
    /// The individual.
    #[serde(flatten)]
    pub individual: Individual,
    /// Id of its lineage.
    pub lineage: LineageId,
    /// Id of its generation.
    pub generation: GenerationId,
    /// Position of its generation in the lineage, from 0.
    pub generation_index: u64,
    /// Automatic exposure over the whole light circle of the lineage's scene, in EV. Present only
    /// in `GET /v1/individuals/{id}`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exposure_ev: Option<f64>,
}

/// Generation: one brood, with everything needed to breed it again.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct Generation {
    /// Id of the generation.
    pub id: GenerationId,
    /// Id of its lineage.
    pub lineage: LineageId,
    /// Position in the lineage, from 0.
    pub index: u64,
    /// Seed that was used. The same request with this seed gives the same children.
    pub seed: Seed,
    /// Parents, as requested.
    pub parents: Vec<ParentRef>,
    /// Parent that is shown large; null after a random start.
    pub centre: Option<Individual>,
    /// Options that were used.
    #[serde(flatten)]
    pub options: BreedOptions,
    /// Children, by slot.
    pub individuals: Vec<Individual>,
    /// Creation time, in milliseconds since 1970-01-01 UTC.
    pub created_ms: i64,
}

/// Outline of a generation: its place in the history, and the individuals that stand for it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct GenerationOutline {
    /// Id of the generation.
    pub id: GenerationId,
    /// Position in the lineage, from 0.
    pub index: u64,
    /// Generation of the lineage in which the first parent was born; absent if there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<GenerationId>,
    /// Parent that is shown large; null after a random start.
    pub centre: Option<Individual>,
    /// Children that are favourites or were adopted, and the first one if there is no centre, by
    /// slot.
    pub individuals: Vec<Individual>,
}

/// Body of `PATCH /v1/individuals/{id}`. Absent fields keep their values.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PatchIndividual {
    /// Sets or clears the favourite mark.
    #[serde(default)]
    pub favourite: Option<bool>,
    /// New note, up to 10,000 characters.
    #[serde(default)]
    pub note: Option<String>,
}
