//! A scene as people and scripts write it: mesh, camera, lights and film, with a default for every field.
//!
//! Owns the JSON form (and a compact binary form for formats that are not self-describing) and what is a valid scene.
//! Knows nothing of rays: what a camera sees is the sample set's business.

mod camera;
mod film;
mod light;
mod mesh_ref;
mod normals;
#[cfg(feature = "schema")]
mod schema;
#[cfg(test)]
mod tests;
mod validate;

use serde::ser::SerializeStruct;
use serde::{Deserialize, Serialize, Serializer};

pub use camera::Camera;
pub use film::{Exposure, Film, Tone};
pub(crate) use light::Measure;
pub use light::{
    AREA_SAMPLES, AmbientLight, DirectionalLight, DiskLight, ENVIRONMENT_SAMPLES, EnvironmentLight,
    IesLight, Light, PointLight, Quantity, RectangleLight, SphereLight, SpotLight, Strength,
};
pub use mesh_ref::{BuiltinMesh, MeshRef};
pub use normals::Normals;
pub use validate::{EV_MAX, LIGHT_SAMPLES_MAX, LIGHTS_MAX, SceneError};

/// What is rendered: a mesh, a camera, lights and a film. World right-handed, y up.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Scene {
    /// The mesh: "sphere", "torus", "cube", "knob" or the id of an uploaded one.
    pub mesh: MeshRef,
    /// Rotation of the mesh about its centre, in degrees: about x, then y, then z.
    pub rotation_deg: [f64; 3],
    /// Size of the mesh, scaled about its centre; the camera keeps framing the size 1.
    pub scale: f64,
    /// Where it is seen from.
    pub camera: Camera,
    /// What it is lit by.
    pub lights: Vec<Light>,
    /// What becomes of radiance.
    pub film: Film,
    /// Position on the light circle, in degrees: every light is turned by this angle about the vertical axis
    /// through the centre of the mesh, from +z towards +x. 0 leaves the lights where they are said to be.
    pub light_deg: f64,
    /// Whether what is between a light and a place keeps its light off.
    pub shadows: bool,
    /// What the normals of the mesh's corners tell of.
    pub normals: Normals,
}

impl Default for Scene {
    fn default() -> Self {
        Self {
            mesh: MeshRef::default(),
            rotation_deg: [0.0; 3],
            scale: 1.0,
            camera: Camera::default(),
            lights: vec![Light::default()],
            film: Film::default(),
            light_deg: 0.0,
            shadows: false,
            normals: Normals::default(),
        }
    }
}

impl Scene {
    /// The scene with its lights at another position on the light circle.
    ///
    /// # Units
    /// Degrees, from +z towards +x; 0 is where the scene says the lights are. Replaces [`Scene::light_deg`].
    #[must_use]
    pub fn with_light_deg(&self, degrees: f64) -> Self {
        Self { light_deg: degrees, ..self.clone() }
    }
}

impl Scene {
    /// Samples that all its lights make at each place at most: by so much a picture takes longer than in the light of one
    /// point.
    #[must_use]
    pub fn light_samples(&self) -> u32 {
        self.lights.iter().map(Light::samples).sum()
    }
}

impl Serialize for Scene {
    /// Pictures are found again by the JSON of their scene: what came later is only written where it says something.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let all = !serializer.is_human_readable();
        let (shadows, normals) = (self.shadows || all, self.normals != Normals::default() || all);
        let fields = 7 + usize::from(shadows) + usize::from(normals);
        let mut out = serializer.serialize_struct("Scene", fields)?;
        out.serialize_field("mesh", &self.mesh)?;
        out.serialize_field("rotation_deg", &self.rotation_deg)?;
        out.serialize_field("scale", &self.scale)?;
        out.serialize_field("camera", &self.camera)?;
        out.serialize_field("lights", &self.lights)?;
        out.serialize_field("film", &self.film)?;
        out.serialize_field("light_deg", &self.light_deg)?;
        if shadows {
            out.serialize_field("shadows", &self.shadows)?;
        } else {
            out.skip_field("shadows")?;
        }
        if normals {
            out.serialize_field("normals", &self.normals)?;
        } else {
            out.skip_field("normals")?;
        }
        out.end()
    }
}
