//! Requests and responses for lineages.

use brood_genome::{Dialect, Start};
use serde::{Deserialize, Deserializer, Serialize};

use crate::{IndividualId, LineageId, SceneId};

/// Body of `POST /v1/lineages`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(deny_unknown_fields)]
pub struct CreateLineage {
    /// Display name, 1 to 200 characters.
    pub name: String,
    /// Notes, up to 10,000 characters. Default: empty.
    #[serde(default)]
    pub notes: String,
    /// Tags: up to 12 of 1 to 30 characters, without commas. Default: none.
    #[serde(default)]
    pub tags: Vec<String>,
    /// Scene of the thumbnails. Default: the built-in scene.
    pub scene: Option<SceneId>,
    /// Side of the thumbnails in pixels, 16 to 1024. Default: 256.
    #[serde(default = "default_thumbnail_px")]
    #[schema(minimum = 16, maximum = 1024)]
    pub thumbnail_px: u32,
    /// Source of random children: `believable` (programs like measured materials), `models`
    /// (reflectance models), `painted` (colours by the amount of light) or `wild` (random
    /// programs). Default: `wild`; `models` if the length of the dialect is 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start: Option<Start>,
    /// Dialect: restricts the programs of all genomes in the lineage. Default: that of the start.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<Object>)]
    pub dialect: Option<Dialect>,
    /// Colour saturation of random children, from 0 (grey) to 1 (unchanged). Default: 1, the only
    /// value for the start `painted`.
    #[serde(default = "default_saturation")]
    #[schema(minimum = 0, maximum = 1)]
    pub saturation: f32,
    /// True to put random children under the energy limit. Default: false; true for the start
    /// `believable`. Must not be true for `painted`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub energy_limit: Option<bool>,
}

/// Reads a field that is present; `Some(None)` if it is null.
fn given<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Option<IndividualId>>, D::Error> {
    Option::deserialize(from).map(Some)
}

fn default_thumbnail_px() -> u32 {
    256
}

fn default_saturation() -> f32 {
    1.0
}

/// Body of `PATCH /v1/lineages/{id}`. Absent fields keep their values.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PatchLineage {
    /// New name, 1 to 200 characters.
    pub name: Option<String>,
    /// New notes, up to 10,000 characters.
    pub notes: Option<String>,
    /// New tags in place of the present ones: up to 12 of 1 to 30 characters, without commas.
    pub tags: Option<Vec<String>>,
    /// True to hide the lineage from lists, false to restore it.
    pub hidden: Option<bool>,
    /// Individual of the lineage whose picture becomes the cover; null for the default cover.
    #[serde(default, deserialize_with = "given", skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<IndividualId>)]
    pub cover_individual: Option<Option<IndividualId>>,
    /// New scene, for all thumbnails of the lineage.
    pub scene: Option<SceneId>,
    /// New colour saturation of random children, 0 to 1.
    #[schema(minimum = 0, maximum = 1)]
    pub saturation: Option<f32>,
    /// New default for the energy limit of random children.
    pub energy_limit: Option<bool>,
}

/// Lineage with its cover, as in lists.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct ListedLineage {
    /// The lineage.
    #[serde(flatten)]
    pub lineage: Lineage,
    /// Path of the cover picture: of the chosen individual, else of the newest favourite, else of
    /// the newest generation's centre or first child.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cover: Option<String>,
}

/// Lineage: a tree of generations with one dialect and scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct Lineage {
    /// Id of the lineage.
    pub id: LineageId,
    /// Display name.
    pub name: String,
    /// Notes.
    pub notes: String,
    /// Tags, as they were written.
    pub tags: Vec<String>,
    /// True if lists leave it out.
    pub hidden: bool,
    /// Individual that was chosen as the cover. Absent if none was.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cover_individual: Option<IndividualId>,
    /// Id of the scene of its thumbnails.
    pub scene: SceneId,
    /// Side of its thumbnails in pixels.
    pub thumbnail_px: u32,
    /// Source of its random children.
    pub start: Start,
    /// Dialect of its genomes.
    #[schema(value_type = Object)]
    pub dialect: Dialect,
    /// Colour saturation of random children, 0 to 1.
    pub saturation: f32,
    /// True if random children are under the energy limit.
    pub energy_limit: bool,
    /// Number of generations.
    pub generations: u64,
    /// Number of favourites.
    pub favourites: u64,
    /// Creation time, in milliseconds since 1970-01-01 UTC.
    pub created_ms: i64,
    /// Number of changes; also the ETag.
    pub version: u64,
}
