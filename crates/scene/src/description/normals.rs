//! Treatment of interpolated normals.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Meaning of vertex normals. It matters for large triangles near silhouettes and at grazing light.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Normals {
    /// Normals describe a curved surface: shadow rays start on it instead of on the flat triangle,
    /// and a view direction below the horizon of the normal is moved to just above it.
    #[default]
    Curved,
    /// Normals only orient the shading frame: shadow rays start on the flat triangle, and a surface
    /// whose normal faces away from the eye is black. Mitsuba and others do the same; use it to
    /// match their pictures.
    Plain,
}
