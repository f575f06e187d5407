//! The request that makes a generation.

use std::fmt;
use std::str::FromStr;

use brood_genome::{GenomeHash, Locks};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

use crate::{IndividualId, Seed};

/// A parent: an individual of any lineage, or a genome by its hash. In JSON the id or the hash as a string.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ParentRef {
    /// By individual.
    Individual(IndividualId),
    /// By genome.
    Genome(GenomeHash),
}

/// Text that names no parent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("a parent is the id of an individual or the hash of a genome")]
pub struct ParentRefError;

impl utoipa::PartialSchema for ParentRef {
    fn schema() -> utoipa::openapi::RefOr<utoipa::openapi::Schema> {
        String::schema()
    }
}

impl utoipa::ToSchema for ParentRef {}

impl FromStr for ParentRef {
    type Err = ParentRefError;

    fn from_str(text: &str) -> Result<Self, ParentRefError> {
        if let Ok(hash) = text.parse() {
            return Ok(Self::Genome(hash));
        }
        text.parse().map(Self::Individual).map_err(|_| ParentRefError)
    }
}

impl fmt::Display for ParentRef {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Individual(id) => id.fmt(f),
            Self::Genome(hash) => hash.fmt(f),
        }
    }
}

impl Serialize for ParentRef {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for ParentRef {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(de::Error::custom)
    }
}

/// How much the server does for the variety of a brood.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum Curation {
    /// First draws as they are.
    Off,
    /// Redraws until the program hash is new among parents and siblings.
    #[default]
    Distinct,
    /// Redraws also until a small preview is not black and unlike those of parents and siblings.
    Diverse,
}

/// Overrides of the lineage's switches; the child's genome carries the result.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(deny_unknown_fields)]
pub struct DialectConstraints {
    /// p5 and p6 read as 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub isotropic: Option<bool>,
    /// u and v read as 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub homogeneous: Option<bool>,
}

/// Body of `POST /v1/lineages/{id}/generations`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Breed {
    /// None: a random start. One: mutation. Two: recombination, then mutation; the first is the centre.
    #[serde(default)]
    pub parents: Vec<ParentRef>,
    /// 1 to 256.
    #[serde(default = "default_count")]
    pub count: u32,
    /// 0 to 1.
    #[serde(default = "default_mutation")]
    pub mutation: f32,
    /// 0 to 1: expected share of the second parent.
    #[serde(default = "default_recombination")]
    pub recombination: f32,
    /// How much is done for variety.
    #[serde(default)]
    pub curation: Curation,
    /// Drawn and reported where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<Seed>,
    /// Overrides of isotropic and homogeneous.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub constraints: Option<DialectConstraints>,
    /// Colour matrix of the children, 0 grey to 1 as evolved; absent: the first parent's, or the lineage's default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub saturation: Option<f32>,
    /// Whether the children are under the energy limit; absent: as the first parent is, or the lineage's default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub energy_limit: Option<bool>,
    /// Parts of the first parent that its children keep: `instructions` by position, `constants` by number, `channels` of
    /// `r`, `g` and `b`, `layers` by position, `parameters` by `layer` and `name`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<Object>)]
    pub locks: Option<Locks>,
}

/// Body of `POST /v1/lineages/{id}/adoptions`; 1 to 256 genomes and presets together.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Adopt {
    /// Hashes of genomes that were saved or bred. Shorter ones than the lineage's dialect says are padded with instructions
    /// that change nothing.
    #[serde(default)]
    pub genomes: Vec<String>,
    /// Names of presets.
    #[serde(default)]
    pub presets: Vec<String>,
}

fn default_count() -> u32 {
    20
}

fn default_mutation() -> f32 {
    0.3
}

fn default_recombination() -> f32 {
    0.5
}

impl Default for Breed {
    fn default() -> Self {
        Self {
            parents: Vec::new(),
            count: default_count(),
            mutation: default_mutation(),
            recombination: default_recombination(),
            curation: Curation::default(),
            seed: None,
            constraints: None,
            saturation: None,
            energy_limit: None,
            locks: None,
        }
    }
}
