//! A scene as people and scripts write it: mesh, camera, lights and film, with a default for every field.
//!
//! Owns the JSON form (and a compact binary form for formats that are not self-describing) and what is a valid scene.
//! Knows nothing of rays: what a camera sees is the sample set's business.

mod camera;
mod film;
mod light;
mod mesh_ref;
#[cfg(feature = "schema")]
mod schema;
#[cfg(test)]
mod tests;
mod validate;

use serde::{Deserialize, Serialize};

pub use camera::Camera;
pub use film::{Exposure, Film, Tone};
pub use light::Light;
pub use mesh_ref::{BuiltinMesh, MeshRef};
pub use validate::{EV_MAX, LIGHTS_MAX, SceneError};

/// What is rendered: a mesh, a camera, lights and a film. World right-handed, y up.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
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
    /// Position on the light circle, in degrees: every point light is turned by this angle about the vertical axis
    /// through the centre of the mesh, from +z towards +x. 0 leaves the lights where they are said to be.
    pub light_deg: f64,
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
