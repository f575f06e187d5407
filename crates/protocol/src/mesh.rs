//! Responses for uploaded meshes and stored scenes.

use brood_scene::Scene;
use serde::{Deserialize, Serialize};

use crate::{MeshId, SceneId};

/// Warning of the OBJ parser: the file was read nevertheless.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct MeshWarning {
    /// Line of the file, from 1.
    pub line: u32,
    /// Description of the problem.
    pub text: String,
}

/// Uploaded mesh.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct MeshAnswer {
    /// Id of the mesh, to be used as a scene's `mesh`.
    pub id: MeshId,
    /// Number of vertices after merging equal corners.
    pub vertices: u64,
    /// Number of triangles.
    pub triangles: u64,
    /// True if the file has texture coordinates.
    pub has_uv: bool,
    /// Warnings of the parser.
    pub warnings: Vec<MeshWarning>,
}

/// Stored scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SceneAnswer {
    /// Id of the scene. Equal scenes have the same id.
    pub id: SceneId,
    /// The scene with every field present.
    #[serde(flatten)]
    pub scene: Scene,
}
