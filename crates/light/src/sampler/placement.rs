//! Placement of lights: transform from the world to the unit frame, with the turn by `light_deg`.

use brood_mesh::UnitFrame;
use brood_mesh::angle::{orbit_direction, rotation_y_deg};
use glam::{DMat3, DVec3};

/// Default direction of a light: azimuth and elevation in degrees. It is 38 degrees to the right of
/// and above the default camera: most of the object is lit, and the terminator is visible.
const DEFAULT_DEG: [f64; 2] = [65.0, 45.0];
/// Default distance of a light from the centre, in radii of the mesh.
const DEFAULT_RADII: f64 = 4.0;

/// Transform of lights from the world to the unit frame.
pub(crate) struct LightPlacement<'a> {
    frame: &'a UnitFrame,
    turn: DMat3,
}

impl<'a> LightPlacement<'a> {
    pub fn new(light_deg: f64, frame: &'a UnitFrame) -> Self {
        Self { frame, turn: rotation_y_deg(light_deg) }
    }

    /// Default position, relative to the subject's centre, in radii of the mesh.
    pub fn default_relative() -> DVec3 {
        orbit_direction(DEFAULT_DEG[0], DEFAULT_DEG[1]) * DEFAULT_RADII
    }

    /// Transforms a position; the default position if it is `None`.
    pub fn position(&self, position: Option<[f64; 3]>) -> DVec3 {
        let relative =
            position.map_or_else(Self::default_relative, |position| self.frame.relative(position));
        self.frame.position(self.turn * relative)
    }

    /// Returns the unit direction from the subject's centre to the default position.
    pub fn default_direction(&self) -> DVec3 {
        (self.position(None) - self.frame.pivot()).normalize()
    }

    /// Transforms a direction of nonzero length to a unit vector.
    pub fn direction(&self, direction: [f64; 3]) -> DVec3 {
        self.frame.direction(self.turn * DVec3::from(direction).normalize())
    }

    /// Transforms a direction of nonzero length that `light_deg` does not turn.
    pub fn fixed_direction(&self, direction: [f64; 3]) -> DVec3 {
        self.frame.direction(DVec3::from(direction).normalize())
    }

    /// Transforms an axis; the direction from `from` to the subject's centre if it is `None`.
    pub fn axis(&self, axis: Option<[f64; 3]>, from: DVec3) -> DVec3 {
        match axis {
            Some(axis) => self.direction(axis),
            None => {
                let towards = (-(from - self.frame.pivot())).try_normalize();
                towards.unwrap_or_else(|| self.frame.direction(-DVec3::Y))
            }
        }
    }

    /// Returns the squared distance of a position to the subject's centre.
    pub fn squared_to_pivot(&self, position: DVec3) -> f64 {
        (position - self.frame.pivot()).length_squared()
    }

    /// Returns the direction straight down.
    pub fn down(&self) -> DVec3 {
        self.frame.direction(-DVec3::Y)
    }

    /// Returns right-handed axes with the given z; y is as close as possible to `up`.
    pub fn axes(&self, z: DVec3, up: Option<[f64; 3]>) -> [DVec3; 3] {
        let preferred = up.map_or(-self.down(), |up| self.direction(up));
        let right = |up: DVec3| Some(up.cross(z)).filter(|x| x.length() > 1e-6);
        let x = right(preferred)
            .or_else(|| right(self.frame.direction(-DVec3::Z)))
            .or_else(|| right(self.frame.direction(DVec3::X)))
            .map_or_else(|| z.any_orthonormal_vector(), DVec3::normalize);
        [x, z.cross(x), z]
    }

    /// Converts a world length to the unit frame; `radii` of the mesh if it is `None`.
    pub fn length(&self, length: Option<f64>, radii: f64) -> f64 {
        length.map_or(radii, |length| self.frame.length(length)) / self.frame.scale()
    }

    /// Returns the world length of 1 in the unit frame.
    pub fn unit(&self) -> f64 {
        self.frame.scale() / self.frame.length(1.0)
    }
}
