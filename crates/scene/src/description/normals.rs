//! What is made of normals that lean away from their triangles.

use serde::{Deserialize, Serialize};

/// What the normals of a mesh's corners tell of. It matters where triangles are large: near silhouettes and where light
/// grazes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum Normals {
    /// Of a curved surface: rays to the lights start on it instead of on the flat triangle, and where a normal turns away
    /// from the eye the direction to the eye is taken for one just above the horizon.
    #[default]
    Curved,
    /// Of directions and nothing else: rays to the lights start on the flat triangle, and where a normal turns away from
    /// the eye nothing is reflected. So do Mitsuba and others; wanted where their pictures are to be met.
    Plain,
}
