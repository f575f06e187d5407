//! The form of lineage files.

use std::collections::BTreeMap;

use brood_genome::{Dialect, Locks};
use brood_protocol::{Curation, DialectConstraints, IndividualId, LightAssetKind, ParentRef, Seed};
use brood_scene::Scene;
use serde::{Deserialize, Serialize};

/// Version of the form.
pub const VERSION: u32 = 1;

/// A whole lineage.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(deny_unknown_fields)]
pub struct LineageFile {
    /// Version of the form: 1.
    pub brood_lineage: u32,
    /// Its name.
    pub name: String,
    /// Free text.
    #[serde(default)]
    pub notes: String,
    /// What its genomes may use.
    #[schema(value_type = Object)]
    pub dialect: Dialect,
    /// Side of its thumbnails in pixels.
    pub thumbnail_px: u32,
    /// Colour matrix of random children.
    pub saturation: f32,
    /// Whether random children are under the energy limit.
    #[serde(default)]
    pub energy_limit: bool,
    /// The scene its thumbnails show.
    pub scene: Scene,
    /// The scene's mesh where it was uploaded: binary, base64.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mesh: Option<String>,
    /// The files that the scene's lights refer to.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub light_assets: Vec<FileLightAsset>,
    /// Texts of all genomes by content hash.
    pub genomes: BTreeMap<String, String>,
    /// Its generations, oldest first.
    pub generations: Vec<FileGeneration>,
}

/// A file that a light of the scene refers to.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(deny_unknown_fields)]
pub struct FileLightAsset {
    /// What it is.
    pub kind: LightAssetKind,
    /// As it was uploaded, base64.
    pub bytes: String,
}

/// One brood.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(deny_unknown_fields)]
pub struct FileGeneration {
    /// The seed that was used.
    pub seed: Seed,
    /// Individuals of earlier generations of the file, or genomes by hash.
    pub parents: Vec<ParentRef>,
    /// The parent shown large.
    #[serde(default)]
    pub centre: Option<IndividualId>,
    /// Amount of mutation.
    pub mutation: f32,
    /// Expected share of the second parent.
    pub recombination: f32,
    /// How much was done for variety.
    pub curation: Curation,
    /// Overrides as asked for.
    #[serde(default)]
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
    /// When it was made, milliseconds since 1970.
    pub created_ms: i64,
    /// The children by slot.
    pub individuals: Vec<FileIndividual>,
}

/// One child.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(deny_unknown_fields)]
pub struct FileIndividual {
    /// Its id in the file; it gets a new one when it is taken in.
    pub id: IndividualId,
    /// Content hash of its genome.
    pub hash: String,
    /// Place in its brood.
    pub slot: u32,
    /// `random`, `mutate` or `recombine`.
    pub operator: String,
    /// Draws it took.
    pub attempts: u32,
    /// Whether it is a twin all the same.
    #[serde(default)]
    pub twin: bool,
    /// Marked by a person.
    #[serde(default)]
    pub favourite: bool,
    /// A person's words.
    #[serde(default)]
    pub note: String,
}
