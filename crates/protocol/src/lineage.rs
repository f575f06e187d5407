//! Lineages as they are asked for and answered.

use brood_genome::Dialect;
use serde::{Deserialize, Serialize};

use crate::{LineageId, SceneId};

/// Body of `POST /v1/lineages`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(deny_unknown_fields)]
pub struct CreateLineage {
    /// Shown to people; 1 to 200 characters.
    pub name: String,
    /// Free text, up to 10,000 characters.
    #[serde(default)]
    pub notes: String,
    /// The default scene where absent.
    #[serde(default)]
    pub scene: Option<SceneId>,
    /// 16 to 1024.
    #[serde(default = "default_thumbnail_px")]
    pub thumbnail_px: u32,
    /// What genomes of the lineage may use.
    #[serde(default)]
    #[schema(value_type = Object)]
    pub dialect: Dialect,
    /// Colour matrix of random children: 0 grey to 1 as evolved.
    #[serde(default = "default_saturation")]
    pub saturation: f32,
    /// Whether random children are under the energy limit.
    #[serde(default)]
    pub energy_limit: bool,
}

fn default_thumbnail_px() -> u32 {
    256
}

fn default_saturation() -> f32 {
    1.0
}

/// Body of `PATCH /v1/lineages/{id}`: what is absent stays.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PatchLineage {
    /// New name.
    #[serde(default)]
    pub name: Option<String>,
    /// New notes.
    #[serde(default)]
    pub notes: Option<String>,
    /// New scene for all thumbnails of the lineage.
    #[serde(default)]
    pub scene: Option<SceneId>,
    /// New colour matrix of random children.
    #[serde(default)]
    pub saturation: Option<f32>,
    /// Whether random children are under the energy limit from now on.
    #[serde(default)]
    pub energy_limit: Option<bool>,
}

/// A lineage as one of a list.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct ListedLineage {
    /// The lineage.
    #[serde(flatten)]
    pub lineage: Lineage,
    /// Where the picture is that stands for it: of its newest favourite, else of the newest generation's centre or first child.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cover: Option<String>,
}

/// A lineage.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct Lineage {
    /// Its id.
    pub id: LineageId,
    /// Its name.
    pub name: String,
    /// Free text.
    pub notes: String,
    /// The scene its thumbnails show.
    pub scene: SceneId,
    /// Side of its thumbnails in pixels.
    pub thumbnail_px: u32,
    /// What its genomes may use.
    #[schema(value_type = Object)]
    pub dialect: Dialect,
    /// Colour matrix of random children.
    pub saturation: f32,
    /// Whether random children are under the energy limit.
    pub energy_limit: bool,
    /// How many generations it has.
    pub generations: u64,
    /// When it was made, milliseconds since 1970.
    pub created_ms: i64,
    /// Counted up by each change; the ETag.
    pub version: u64,
}
