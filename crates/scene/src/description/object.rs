//! Other objects of a scene, and the ground.

use brood_light::FieldError;
use brood_light::field::{finite, require};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::mesh_ref::{MeshRef, SCALE_MAX};
use super::normal_map::NormalMap;

/// Largest number of objects beside the one that is bred.
pub const OBJECTS_MAX: usize = 8;
/// Longest name of a material, in bytes.
const MATERIAL_BYTES_MAX: usize = 128;
/// Largest distance of an object along an axis.
const POSITION_MAX: f64 = 1e6;

/// Object beside the one that is bred, with a material of its own.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(default, deny_unknown_fields, expecting = "an object")]
pub struct SceneObject {
    /// Mesh: "ball", "sphere", "torus", "cube", "knob" or the id of an uploaded mesh.
    pub mesh: MeshRef,
    /// Position that the origin of the mesh is moved to, world units.
    pub position: [f64; 3],
    /// True if it stands on the ground: its lowest point decides its height, not its position.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub stands: bool,
    /// Rotation of the mesh about its centre: about x, then y, then z, in degrees.
    pub rotation_deg: [f64; 3],
    /// Scale of the mesh about its centre.
    pub scale: f64,
    /// Material: the hash of a stored genome, or the name of a preset. Default: neutral grey.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// Normal map; none by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normal_map: Option<NormalMap>,
}

impl Default for SceneObject {
    fn default() -> Self {
        Self {
            mesh: MeshRef::default(),
            position: [0.0; 3],
            stands: false,
            rotation_deg: [0.0; 3],
            scale: 1.0,
            material: None,
            normal_map: None,
        }
    }
}

/// Level ground below the object that is bred.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(default, deny_unknown_fields, expecting = "an object")]
pub struct Ground {
    /// Material: the hash of a stored genome, or the name of a preset. Default: neutral grey. Its
    /// texture repeats after one diameter of the object.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// Height in world units. Default: the lowest point of the object.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub height: Option<f64>,
    /// Normal map; none by default. It repeats with the texture.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normal_map: Option<NormalMap>,
}

impl SceneObject {
    pub(super) fn validate(&self, pointer: &str, has_ground: bool) -> Result<(), FieldError> {
        require(has_ground || !self.stands, &format!("{pointer}/stands"), "needs a ground")?;
        self.mesh.validate(&format!("{pointer}/mesh"))?;
        finite(&self.position, &format!("{pointer}/position"))?;
        let near = self.position.iter().all(|at| at.abs() <= POSITION_MAX);
        require(near, &format!("{pointer}/position"), "must be within 1,000,000 of the origin")?;
        finite(&self.rotation_deg, &format!("{pointer}/rotation_deg"))?;
        let in_range = self.scale > 0.0 && self.scale <= SCALE_MAX;
        require(in_range, &format!("{pointer}/scale"), "must be above 0 and at most 1000")?;
        if let Some(map) = &self.normal_map {
            map.validate(&format!("{pointer}/normal_map"))?;
        }
        check_material(self.material.as_deref(), pointer)
    }
}

impl Ground {
    pub(super) fn validate(&self) -> Result<(), FieldError> {
        if let Some(height) = self.height {
            finite(&[height], "/ground/height")?;
            let reason = "must be within 1,000,000 of the origin";
            require(height.abs() <= POSITION_MAX, "/ground/height", reason)?;
        }
        if let Some(map) = &self.normal_map {
            map.validate("/ground/normal_map")?;
        }
        check_material(self.material.as_deref(), "/ground")
    }
}

fn check_material(material: Option<&str>, pointer: &str) -> Result<(), FieldError> {
    let length = material.map_or(1, str::len);
    let reason = "must be the hash of a genome or the name of a preset";
    let in_range = (1..=MATERIAL_BYTES_MAX).contains(&length);
    require(in_range, &format!("{pointer}/material"), reason)
}
