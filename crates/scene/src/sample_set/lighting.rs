//! The lights of a scene in the unit frame of the mesh, and the irradiance that they give.

use std::f64::consts::PI;

use glam::DVec3;

use super::view::UnitFrame;
use crate::angle::{orbit_direction, rotation_y_deg};
use crate::{Light, Scene};

/// Where a light is that is placed relative to the mesh: azimuth and elevation in degrees. 38 degrees from the default
/// camera, to its right and above it: most of the object is lit, and the terminator is in sight.
const PLACED_DEG: [f64; 2] = [65.0, 45.0];
/// How far it is from the centre, in radii of the mesh.
const PLACED_RADII: f64 = 4.0;

/// A point light.
#[derive(Debug, Clone, Copy)]
pub(super) struct PointLight {
    position: DVec3,
    /// Over the square of a distance in the unit frame: irradiance.
    intensity: [f64; 3],
}

impl PointLight {
    /// All lights of a scene, at the scene's position on the light circle.
    pub fn all(scene: &Scene, frame: &UnitFrame) -> Vec<Self> {
        let circle = rotation_y_deg(scene.light_deg);
        let light = |light: &Light| {
            let Light::Point { position, intensity } = light;
            let placed = orbit_direction(PLACED_DEG[0], PLACED_DEG[1]) * PLACED_RADII;
            let relative = position.map_or(placed, |position| frame.relative(position));
            let position = frame.place(circle * relative);
            // Lengths of the unit frame are lengths of the world over this.
            let unit = frame.scale / frame.length(1.0);
            let intensity = intensity.map_or([PI * position.length_squared(); 3], |intensity| {
                intensity.map(|channel| channel / (unit * unit))
            });
            Self { position, intensity }
        };
        scene.lights.iter().map(light).collect()
    }

    /// Direction to the light from a place, and irradiance there at normal incidence; `None` at the light itself.
    pub fn at(&self, place: DVec3) -> Option<(DVec3, [f64; 3])> {
        let towards = self.position - place;
        let squared = towards.length_squared();
        if squared == 0.0 || !squared.is_finite() {
            return None;
        }
        Some((towards / squared.sqrt(), self.intensity.map(|channel| channel / squared)))
    }
}
