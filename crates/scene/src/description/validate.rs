//! Validation of scenes: finite numbers in ranges for which all later steps stay finite.

use brood_light::FieldError;
use brood_light::field::{finite, positive, require};
use brood_mesh::BuiltinMesh;
use glam::DVec3;

use super::camera::{LookAtCamera, OrbitCamera, OrthographicCamera};
use super::film::EV_MAX;
use super::mesh_ref::SCALE_MAX;
use super::object::OBJECTS_MAX;
use super::{Camera, Exposure, Ground, MeshRef, Scene, SpherePole};

/// Largest number of lights.
pub const LIGHTS_MAX: usize = 16;
/// Largest number of samples of all lights at one shading point.
pub const LIGHT_SAMPLES_MAX: u32 = 4096;
/// Bounds of the vertical field of view in degrees, both exclusive.
const FOV_Y_DEG: (f64, f64) = (0.1, 170.0);
/// Sine of the smallest angle between the view direction and up.
const UP_SINE_MIN: f64 = 1e-6;

impl Scene {
    /// Checks every field.
    ///
    /// # Errors
    /// Returns the first field out of its range, in the order of the description.
    pub fn validate(&self) -> Result<(), FieldError> {
        self.mesh.validate("/mesh")?;
        let is_sphere = self.mesh == MeshRef::Builtin(BuiltinMesh::Sphere);
        let reason = "\"z\" needs the mesh \"sphere\"";
        require(is_sphere || self.sphere_pole == SpherePole::Y, "/sphere_pole", reason)?;
        finite(&self.rotation_deg, "/rotation_deg")?;
        let in_range = self.scale > 0.0 && self.scale <= SCALE_MAX;
        require(in_range, "/scale", "must be above 0 and at most 1000")?;
        self.camera.validate()?;
        let count = self.lights.len();
        require((1..=LIGHTS_MAX).contains(&count), "/lights", "must have 1 to 16 lights")?;
        for (index, light) in self.lights.iter().enumerate() {
            light.validate(&format!("/lights/{index}"))?;
        }
        let reason = "have more than 4096 samples together";
        require(self.light_samples() <= LIGHT_SAMPLES_MAX, "/lights", reason)?;
        if let Exposure::Ev(ev) = self.film.exposure {
            require(ev.abs() <= EV_MAX, "/film/exposure", "must be within 64 EV of 0")?;
        }
        finite(&[self.light_deg], "/light_deg")?;
        if let Some(backdrop) = &self.backdrop {
            backdrop.validate(self.has_environment())?;
        }
        if let Some(map) = &self.normal_map {
            map.validate("/normal_map")?;
        }
        require(self.objects.len() <= OBJECTS_MAX, "/objects", "must be at most 8")?;
        for (index, object) in self.objects.iter().enumerate() {
            object.validate(&format!("/objects/{index}"), self.ground.is_some())?;
        }
        self.ground.as_ref().map_or(Ok(()), Ground::validate)
    }
}

impl Camera {
    fn validate(&self) -> Result<(), FieldError> {
        match self {
            Self::Orbit(OrbitCamera { orbit_deg, distance, fov_y_deg }) => {
                finite(orbit_deg, "/camera/orbit_deg")?;
                let elevation = orbit_deg[1].abs() <= 90.0;
                require(elevation, "/camera/orbit_deg/1", "elevation must be within 90 degrees")?;
                if let Some(distance) = distance {
                    positive(*distance, "/camera/distance")?;
                }
                field_of_view(*fov_y_deg)
            }
            Self::LookAt(LookAtCamera { eye, target, up, fov_y_deg }) => {
                finite(eye, "/camera/eye")?;
                finite(target, "/camera/target")?;
                finite(up, "/camera/up")?;
                let back = DVec3::from(*eye) - DVec3::from(*target);
                require(back.length() > 0.0, "/camera/eye", "must differ from the target")?;
                let up = DVec3::from(*up);
                require(up.length() > 0.0, "/camera/up", "must not be zero")?;
                let sine = (back / back.length()).cross(up / up.length()).length();
                let reason = "must not point along the view direction";
                require(sine > UP_SINE_MIN, "/camera/up", reason)?;
                field_of_view(*fov_y_deg)
            }
            Self::Orthographic(OrthographicCamera { orthographic }) => {
                positive(*orthographic, "/camera/orthographic")
            }
        }
    }
}

fn field_of_view(degrees: f64) -> Result<(), FieldError> {
    let holds = degrees > FOV_Y_DEG.0 && degrees < FOV_Y_DEG.1;
    require(holds, "/camera/fov_y_deg", "must be between 0.1 and 170 degrees")
}
