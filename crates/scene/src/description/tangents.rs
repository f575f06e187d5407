//! Conventions of texture directions: the tangents of meshes and the pole of the sphere.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Tangent u of the shading frame. It matters for anisotropic materials.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Tangents {
    /// Tangents of the vertices, interpolated.
    #[default]
    Vertex,
    /// Direction of growing u on each triangle, from its own texture coordinates. Mitsuba does the
    /// same; use it to match its pictures of meshes.
    Triangle,
}

/// Axis through the poles of the built-in sphere's texture.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum SpherePole {
    /// The y axis: u grows from -z over -x, +z and +x, v from the bottom to the top.
    #[default]
    Y,
    /// The z axis: u grows from +x over +y, -x and -y, v from +z to -z, as on Mitsuba's sphere.
    Z,
}
