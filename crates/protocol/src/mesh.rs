//! Uploaded meshes and stored scenes as they are answered.

use brood_scene::Scene;
use serde::{Deserialize, Serialize};

use crate::{MeshId, SceneId};

/// Something odd in an OBJ file that did not stop it from being read.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct MeshWarning {
    /// Line of the file, from 1.
    pub line: u32,
    /// What was odd.
    pub text: String,
}

/// A mesh that was uploaded.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct MeshAnswer {
    /// Its id, to be put into a scene's `mesh`.
    pub id: MeshId,
    /// Vertices after joining equal corners.
    pub vertices: u64,
    /// Triangles.
    pub triangles: u64,
    /// Whether the file had texture coordinates.
    pub has_uv: bool,
    /// What was odd.
    pub warnings: Vec<MeshWarning>,
}

/// A stored scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SceneAnswer {
    /// Its id; equal scenes have one id.
    pub id: SceneId,
    /// The full scene, every field present.
    #[serde(flatten)]
    pub scene: Scene,
}
