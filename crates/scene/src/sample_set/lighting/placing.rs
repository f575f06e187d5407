//! Where lights are: places, directions and lengths of the world in the unit frame, turned on the light circle.

use glam::{DMat3, DVec3};

use crate::Scene;
use crate::angle::{orbit_direction, rotation_y_deg};
use crate::sample_set::view::UnitFrame;

/// Where a light is that is placed relative to the mesh: azimuth and elevation in degrees. 38 degrees from the default
/// camera, to its right and above it: most of the object is lit, and the terminator is in sight.
const PLACED_DEG: [f64; 2] = [65.0, 45.0];
/// How far it is from the centre, in radii of the mesh.
const PLACED_RADII: f64 = 4.0;

/// From the world to the unit frame, for lights.
pub(super) struct Placing<'a> {
    frame: &'a UnitFrame,
    circle: DMat3,
}

impl<'a> Placing<'a> {
    pub fn new(scene: &Scene, frame: &'a UnitFrame) -> Self {
        Self { frame, circle: rotation_y_deg(scene.light_deg) }
    }

    /// A position, or the usual one.
    pub fn position(&self, position: Option<[f64; 3]>) -> DVec3 {
        let placed = orbit_direction(PLACED_DEG[0], PLACED_DEG[1]) * PLACED_RADII;
        let relative = position.map_or(placed, |position| self.frame.relative(position));
        self.frame.place(self.circle * relative)
    }

    /// A direction of any length but 0, as a unit vector.
    pub fn direction(&self, direction: [f64; 3]) -> DVec3 {
        self.frame.direction(self.circle * DVec3::from(direction).normalize())
    }

    /// An axis, or the direction from a place to the centre of the mesh.
    pub fn axis(&self, axis: Option<[f64; 3]>, from: DVec3) -> DVec3 {
        match axis {
            Some(axis) => self.direction(axis),
            None => (-from).try_normalize().unwrap_or_else(|| self.frame.direction(-DVec3::Y)),
        }
    }

    /// Straight down.
    pub fn down(&self) -> DVec3 {
        self.frame.direction(-DVec3::Y)
    }

    /// Right-handed axes whose last is given; the second is as near as can be to `up`.
    pub fn axes(&self, z: DVec3, up: Option<[f64; 3]>) -> [DVec3; 3] {
        let wanted = up.map_or(-self.down(), |up| self.direction(up));
        let aside = |up: DVec3| Some(up.cross(z)).filter(|x| x.length() > 1e-6);
        let x = aside(wanted)
            .or_else(|| aside(self.frame.direction(-DVec3::Z)))
            .or_else(|| aside(self.frame.direction(DVec3::X)))
            .map_or_else(|| z.any_orthonormal_vector(), DVec3::normalize);
        [x, z.cross(x), z]
    }

    /// A length of the world, or one in radii of the mesh.
    pub fn length(&self, length: Option<f64>, radii: f64) -> f64 {
        length.map_or(radii, |length| self.frame.length(length)) / self.frame.scale
    }

    /// A length of 1 of the unit frame in the world.
    pub fn unit(&self) -> f64 {
        self.frame.scale / self.frame.length(1.0)
    }
}
