//! Request that breeds a generation.

use std::fmt;
use std::str::FromStr;

use brood_genome::{
    Dialect, DialectConstraints, Genome, GenomeHash, Locks, Output, PaintingPalette, Start, Steer,
    SteerError, Variation,
};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

use crate::{IndividualId, Seed};

/// Reference to a parent: the id of an individual of any lineage, or the hash of a genome. A string
/// in JSON.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ParentRef {
    /// Id of an individual.
    Individual(IndividualId),
    /// Hash of a genome.
    Genome(GenomeHash),
}

/// Error of parsing a [`ParentRef`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("a parent must be the id of an individual or the hash of a genome")]
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

brood_brdf::named_enum! {
    /// Effort that the server makes for the variety of a brood.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, utoipa::ToSchema)]
    #[serde(rename_all = "lowercase")]
    pub enum Curation {
        /// Keeps the first draw of every child.
        Off => "off",
        /// Redraws a child until its program differs from those of its parents and siblings.
        #[default]
        Distinct => "distinct",
        /// Like `distinct`, and redraws a child also if a small preview of it is black or resembles
        /// those of its parents and siblings.
        Diverse => "diverse",
    }
}

/// Options of a brood: everything that its children depend on besides parents, seed, dialect and
/// start.
///
/// [`Breed`] and lineage files list the same fields in their own objects, because serde's `flatten`
/// would lose the JSON pointer of an error.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct BreedOptions {
    /// Visible amount of mutation, 0 to 1.
    pub mutation: f32,
    /// Expected share of the second parent's blocks, 0 to 1.
    pub recombination: f32,
    /// Curation that was used.
    pub curation: Curation,
    /// Overrides of the dialect, as requested.
    pub constraints: DialectConstraints,
    /// Colour saturation, 0 to 1, as requested.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub saturation: Option<f32>,
    /// Energy limit, as requested.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub energy_limit: Option<bool>,
    /// Locked parts of the first parent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<Object>)]
    pub locks: Option<Locks>,
    /// Properties that the children keep or change, compared with the first parent.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub steer: Vec<Steer>,
    /// Colours of a picture that the children are painted with.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub painting: Option<PaintingPalette>,
}

/// Error of [`BreedOptions::check_steer`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum SteerRefusal {
    /// The words do not fit together or do not fit the parents.
    #[error(transparent)]
    Words(#[from] SteerError),
    /// Children are not chosen.
    #[error(
        "`steer` chooses among several draws of each child: set `curation` to `distinct` or \
         `diverse`, got `off`"
    )]
    Curation,
}

impl SteerRefusal {
    /// Field of [`BreedOptions`] that is to be changed.
    #[must_use]
    pub fn field(self) -> &'static str {
        match self {
            Self::Words(_) => "steer",
            Self::Curation => "curation",
        }
    }
}

/// Error of an amount outside 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("`{field}` must be between 0 and 1, got {amount}")]
pub struct AmountError {
    /// Field of [`BreedOptions`].
    pub field: &'static str,
    /// Value of the field.
    pub amount: f32,
}

impl Default for BreedOptions {
    /// Options of a brood of given genomes: no variation and no curation.
    fn default() -> Self {
        Self {
            mutation: 0.0,
            recombination: 0.0,
            curation: Curation::Off,
            constraints: DialectConstraints::default(),
            saturation: None,
            energy_limit: None,
            locks: None,
            steer: Vec::new(),
            painting: None,
        }
    }
}

impl BreedOptions {
    /// Checks that all amounts are between 0 and 1.
    ///
    /// # Errors
    /// [`AmountError`] for the first amount that is not.
    pub fn check_amounts(&self) -> Result<(), AmountError> {
        let amounts = [
            ("mutation", Some(self.mutation)),
            ("recombination", Some(self.recombination)),
            ("saturation", self.saturation),
        ];
        match amounts
            .into_iter()
            .find(|(_, amount)| amount.is_some_and(|x| !(0.0..=1.0).contains(&x)))
        {
            Some((field, Some(amount))) => Err(AmountError { field, amount }),
            _ => Ok(()),
        }
    }

    /// Checks that the children of these parents can follow the steer.
    ///
    /// # Errors
    /// [`SteerRefusal`] for the first reason why they cannot.
    pub fn check_steer(&self, parents: &[&Genome]) -> Result<(), SteerRefusal> {
        Steer::check(&self.steer, parents, self.constraints)?;
        if !self.steer.is_empty() && self.curation == Curation::Off {
            return Err(SteerRefusal::Curation);
        }
        Ok(())
    }

    /// Returns the variation of 0, 1 or 2 parents in a lineage with this start and dialect.
    ///
    /// # Panics
    /// If an amount is outside 0 to 1, and as the constructors of [`Variation`].
    #[must_use]
    pub fn variation<'a>(
        &'a self,
        (start, dialect): (Start, Dialect),
        parents: &[&'a Genome],
    ) -> Variation<'a> {
        let variation = match *parents {
            [] => Variation::random(dialect),
            [parent] => Variation::mutate(parent, self.mutation),
            [first, second, ..] => {
                Variation::crossover(first, second, self.recombination, self.mutation)
            }
        };
        let output = |saturation| Output::saturation(saturation).expect("saturation is 0 to 1");
        variation
            .with_constraints(self.constraints)
            .with_output(self.saturation.map(output))
            .with_limit(self.energy_limit)
            .with_locks(self.locks.as_ref())
            .with_steer(&self.steer)
            .with_painting(self.painting.as_ref())
            .with_start(start)
    }
}

/// Body of `POST /v1/lineages/{id}/generations`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Breed {
    /// Parents, at most 2. None: random children. One: mutation. Two: recombination, then mutation;
    /// the first parent is the centre.
    #[serde(default)]
    pub parents: Vec<ParentRef>,
    /// Number of children, 1 to 256. Default: 20.
    #[serde(default = "default_count")]
    #[schema(minimum = 1, maximum = 256)]
    pub count: u32,
    /// Visible amount of mutation: mean difference of children from their parent, from just
    /// noticeable at 0.02 to unrelated at 1. Default: 0.3.
    #[serde(default = "default_mutation")]
    #[schema(minimum = 0, maximum = 1)]
    pub mutation: f32,
    /// Expected share of the second parent's blocks, 0 to 1. Default: 0.5.
    #[serde(default = "default_recombination")]
    #[schema(minimum = 0, maximum = 1)]
    pub recombination: f32,
    /// Effort for variety. Default: `distinct`.
    #[serde(default)]
    pub curation: Curation,
    /// Seed of the brood. Default: a random seed, which the response reports.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<Seed>,
    /// Overrides of the dialect's `isotropic` and `homogeneous`, and of bumps.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub constraints: Option<DialectConstraints>,
    /// Colour saturation of the children, from 0 (grey) to 1 (unchanged). Default: that of the
    /// first parent, or the lineage's default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 0, maximum = 1)]
    pub saturation: Option<f32>,
    /// True to put the children under the energy limit. Default: as the first parent, or the
    /// lineage's default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub energy_limit: Option<bool>,
    /// Parts of the first parent that its children keep: `instructions` by position, `constants` by
    /// number, `channels` of `r`, `g` and `b`, `layers` by position, `parameters` by `layer` and
    /// `name`, `effects` by kind, `effect_parameters` by `effect` and `name`, which may be
    /// `palette` or `edges`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<Object>)]
    pub locks: Option<Locks>,
    /// Properties that the children keep or change, compared with the first parent. More draws are
    /// made for each child, and the first that follows all of them is taken. Needs a parent and a
    /// `curation` other than `off`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub steer: Vec<Steer>,
    /// Colours of a picture, as `POST /v1/palettes` answers. The palette of each child, unless it
    /// is locked, has those of one region, or the dark ones of a region and the bright ones of
    /// another. Painted children only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub painting: Option<PaintingPalette>,
}

/// Body of `POST /v1/lineages/{id}/adoptions`: 1 to 256 genomes and presets together.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Adopt {
    /// Hashes of stored genomes. A genome shorter than the dialect's length is padded with
    /// instructions that change nothing.
    #[serde(default)]
    pub genomes: Vec<String>,
    /// Names of presets.
    #[serde(default)]
    pub presets: Vec<String>,
    /// Individual of the lineage that becomes the parent of all of them, for example because they
    /// are edits of it. Default: they have no parents.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parent: Option<IndividualId>,
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

impl From<Breed> for BreedOptions {
    fn from(breed: Breed) -> Self {
        Self {
            mutation: breed.mutation,
            recombination: breed.recombination,
            curation: breed.curation,
            constraints: breed.constraints.unwrap_or_default(),
            saturation: breed.saturation,
            energy_limit: breed.energy_limit,
            locks: breed.locks.filter(|locks| !locks.is_empty()),
            steer: breed.steer,
            painting: breed.painting,
        }
    }
}
