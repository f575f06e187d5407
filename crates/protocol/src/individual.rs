//! Generations and individuals as they are answered.

use brood_genome::{GenomeHash, Locks};
use serde::{Deserialize, Serialize};

use crate::{Curation, DialectConstraints, GenerationId, IndividualId, LineageId, ParentRef, Seed};

/// One material that was born.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct Individual {
    /// Its id.
    pub id: IndividualId,
    /// Content hash of its genome, 64 hexadecimal digits.
    #[schema(value_type = String)]
    pub hash: GenomeHash,
    /// Place in its brood.
    pub slot: u32,
    /// Its parents.
    pub parents: Vec<ParentRef>,
    /// `random`, `mutate` or `recombine`.
    pub operator: String,
    /// Instructions that can change the result.
    pub live_instructions: u32,
    /// Names of the models that it has besides its program, lowest first; absent where there are none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub layers: Vec<String>,
    /// Where its picture is.
    pub thumbnail: String,
    /// Marked by a person.
    pub favourite: bool,
    /// A person's words.
    pub note: String,
    /// True where no draw gave a program unlike its parents' and siblings'.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub twin: bool,
    /// Counted up by each change; the ETag.
    pub version: u64,
}

/// An individual with its place in the world.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct IndividualDetail {
    /// The individual.
    #[serde(flatten)]
    pub individual: Individual,
    /// Its lineage.
    pub lineage: LineageId,
    /// Its generation.
    pub generation: GenerationId,
    /// Automatic exposure over the whole light circle of its lineage's scene, in EV; where one individual is asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exposure_ev: Option<f64>,
}

/// One brood.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct Generation {
    /// Its id.
    pub id: GenerationId,
    /// Its lineage.
    pub lineage: LineageId,
    /// Position in the lineage, from 0.
    pub index: u64,
    /// The seed that was used; the same seed gives the same children.
    pub seed: Seed,
    /// The parents as asked for.
    pub parents: Vec<ParentRef>,
    /// The parent shown large; null after a random start.
    pub centre: Option<Individual>,
    /// Amount of mutation.
    pub mutation: f32,
    /// Expected share of the second parent.
    pub recombination: f32,
    /// How much was done for variety.
    pub curation: Curation,
    /// Overrides as asked for.
    pub constraints: DialectConstraints,
    /// Colour matrix as asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub saturation: Option<f32>,
    /// Energy limit as asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub energy_limit: Option<bool>,
    /// Parts of the first parent that were kept.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<Object>)]
    pub locks: Option<Locks>,
    /// The children by slot.
    pub individuals: Vec<Individual>,
    /// When it was made, milliseconds since 1970.
    pub created_ms: i64,
}

/// Body of `PATCH /v1/individuals/{id}`: what is absent stays.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PatchIndividual {
    /// Mark or unmark.
    #[serde(default)]
    pub favourite: Option<bool>,
    /// New note, up to 10,000 characters.
    #[serde(default)]
    pub note: Option<String>,
}
