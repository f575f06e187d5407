//! Format of lineage files.

use std::collections::BTreeMap;

use brood_genome::{Dialect, Locks, PaintingPalette, Start, Steer};
use brood_protocol::{
    BreedOptions, Curation, DialectConstraints, IndividualId, LightAssetKind, ParentRef, Seed,
};
use brood_scene::Scene;
use serde::{Deserialize, Serialize};

/// Version of the format.
pub const VERSION: u32 = 1;

/// A whole lineage.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(deny_unknown_fields)]
pub struct LineageFile {
    /// Version of the format: 1.
    pub brood_lineage: u32,
    /// Name of the lineage.
    pub name: String,
    /// Free text.
    #[serde(default)]
    pub notes: String,
    /// Tags.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tags: Vec<String>,
    /// Individual of the file that was chosen as the cover.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cover_individual: Option<IndividualId>,
    /// Source of random children, if it does not follow from the dialect.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start: Option<Start>,
    /// Dialect of the genomes.
    #[schema(value_type = Object)]
    pub dialect: Dialect,
    /// Side of the thumbnails in pixels.
    pub thumbnail_px: u32,
    /// Saturation of random children, 0 to 1.
    pub saturation: f32,
    /// True if random children are under the energy limit.
    #[serde(default)]
    pub energy_limit: bool,
    /// Scene of the thumbnails.
    pub scene: Scene,
    /// Mesh of the scene if it was uploaded: binary, base64.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mesh: Option<String>,
    /// Uploaded meshes of the scene's other objects by their ids in the scene: binary, base64.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub object_meshes: BTreeMap<String, String>,
    /// Files of the scene's lights, and control images of the genomes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub light_assets: Vec<FileLightAsset>,
    // An export writes the two lists below bit by bit, so they come last.
    /// Texts of all genomes by content hash.
    pub genomes: BTreeMap<String, String>,
    /// Generations, oldest first.
    pub generations: Vec<FileGeneration>,
}

/// File of one of the scene's lights, or a control image.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(deny_unknown_fields)]
pub struct FileLightAsset {
    /// Kind of the file.
    pub kind: LightAssetKind,
    /// Contents as uploaded, base64.
    pub bytes: String,
}

/// One brood.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(deny_unknown_fields)]
pub struct FileGeneration {
    /// Seed of the brood.
    pub seed: Seed,
    /// Individuals of earlier generations in the file, or genomes by hash.
    pub parents: Vec<ParentRef>,
    /// Parent shown large in the centre.
    #[serde(default)]
    pub centre: Option<IndividualId>,
    /// Amount of mutation, 0 to 1.
    pub mutation: f32,
    /// Expected share of the second parent, 0 to 1.
    pub recombination: f32,
    /// Curation of the brood.
    pub curation: Curation,
    /// Constraints as requested.
    #[serde(default)]
    pub constraints: DialectConstraints,
    /// Saturation as requested.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub saturation: Option<f32>,
    /// Energy limit as requested.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub energy_limit: Option<bool>,
    /// Parts of the first parent that the children kept.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<Object>)]
    pub locks: Option<Locks>,
    /// Properties that the children kept or changed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub steer: Vec<Steer>,
    /// Colours of the picture that the children were painted with.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub painting: Option<PaintingPalette>,
    /// Time of creation, milliseconds since 1970.
    pub created_ms: i64,
    /// Children by slot.
    pub individuals: Vec<FileIndividual>,
}

impl FileGeneration {
    /// Returns the options of the brood.
    pub fn options(&self) -> BreedOptions {
        BreedOptions {
            mutation: self.mutation,
            recombination: self.recombination,
            curation: self.curation,
            constraints: self.constraints,
            saturation: self.saturation,
            energy_limit: self.energy_limit,
            locks: self.locks.clone(),
            steer: self.steer.clone(),
            painting: self.painting.clone(),
        }
    }
}

/// One child.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(deny_unknown_fields)]
pub struct FileIndividual {
    /// Id in the file; replaced by a new id on import.
    pub id: IndividualId,
    /// Content hash of the genome.
    pub hash: String,
    /// Place in the brood, from 0.
    pub slot: u32,
    /// Operator: `random`, `mutate`, `recombine`, `adopt` or `fit`.
    pub operator: String,
    /// Number of draws for this slot.
    pub attempts: u32,
    /// True if the child is a twin.
    #[serde(default)]
    pub twin: bool,
    /// True if a user marked it as a favourite.
    #[serde(default)]
    pub favourite: bool,
    /// Note of a user.
    #[serde(default)]
    pub note: String,
}
