//! Camera rays in the unit frame of the mesh.

use brood_mesh::UnitFrame;
use brood_mesh::angle::{orbit_direction, sin_cos_deg};
use brood_mesh::trace::Ray;
use glam::{DVec2, DVec3};

use crate::description::{Camera, LookAtCamera, OrbitCamera, OrthographicCamera};

/// Default distance of an orbit camera, divided by the distance at which the bounding sphere
/// touches the picture's edge.
const FRAMING_MARGIN: f64 = 1.04;

/// Camera in the unit frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct View {
    /// Eye, or start of the central ray of a parallel projection.
    origin: DVec3,
    /// `right` and `up` span half the picture's width and height: on the plane at distance 1, or in
    /// positions for a parallel projection.
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    /// `right` and `up` divided by their squared lengths, for projection.
    per_right: DVec3,
    per_up: DVec3,
    parallel: bool,
}

impl View {
    pub fn new(camera: &Camera, frame: &UnitFrame) -> Self {
        match *camera {
            Camera::Orbit(OrbitCamera { orbit_deg: [azimuth, elevation], distance, fov_y_deg }) => {
                let back = orbit_direction(azimuth, elevation);
                // Also defined at elevation 90, unlike a cross product with y.
                let right = orbit_direction(azimuth + 90.0, 0.0);
                let framing = FRAMING_MARGIN / sin_cos_deg(0.5 * fov_y_deg).0;
                let distance = distance.map_or(framing, |distance| frame.length(distance));
                let axes = [right, back.cross(right), back];
                Self::perspective(back * distance, axes, fov_y_deg, frame)
            }
            Camera::LookAt(LookAtCamera { eye, target, up, fov_y_deg }) => {
                let back = (DVec3::from(eye) - DVec3::from(target)).normalize();
                let right = DVec3::from(up).normalize().cross(back).normalize();
                let axes = [right, back.cross(right), back];
                Self::perspective(frame.relative(eye), axes, fov_y_deg, frame)
            }
            Camera::Orthographic(OrthographicCamera { orthographic }) => {
                // Rays start in front of the object, independent of the world's origin.
                let middle = frame.relative([0.0; 3]).truncate().extend(2.0 * frame.scale());
                let half = frame.length(orthographic) / frame.scale();
                let axes = [DVec3::X, DVec3::Y, DVec3::NEG_Z].map(|axis| frame.direction(axis));
                Self::with_axes(frame.position(middle), axes, half, true)
            }
        }
    }

    fn perspective(
        eye: DVec3,
        [right, up, back]: [DVec3; 3],
        fov_y_deg: f64,
        frame: &UnitFrame,
    ) -> Self {
        let (sin, cos) = sin_cos_deg(0.5 * fov_y_deg);
        let half = sin / cos;
        let axes = [right, up, -back].map(|axis| frame.direction(axis));
        Self::with_axes(frame.position(eye), axes, half, false)
    }

    /// Makes a view from orthonormal axes and half the side of the picture.
    fn with_axes(origin: DVec3, axes: [DVec3; 3], half: f64, parallel: bool) -> Self {
        let [right, up, forward] = axes;
        Self {
            origin,
            right: right * half,
            up: up * half,
            forward,
            per_right: right / half,
            per_up: up / half,
            parallel,
        }
    }

    /// Projects a position to picture coordinates, as in [`View::ray`]; `None` if it is not in
    /// front of the eye.
    pub fn project(&self, position: DVec3) -> Option<DVec2> {
        let from_eye = position - self.origin;
        let at = DVec2::new(from_eye.dot(self.per_right), from_eye.dot(self.per_up));
        if self.parallel {
            return Some(at);
        }
        let depth = from_eye.dot(self.forward);
        // Closer points would lose digits.
        (depth > 1e-6).then(|| at / depth)
    }

    /// Returns the ray through a point of the picture: x to the right, y upwards, both in [-1, 1].
    pub fn ray(&self, point: DVec2) -> Ray {
        let offset = self.right * point.x + self.up * point.y;
        if self.parallel {
            return Ray { origin: self.origin + offset, direction: self.forward };
        }
        Ray { origin: self.origin, direction: (self.forward + offset).normalize() }
    }
}

/// Returns positions of rays in a pixel, within [0, 1)^2; the first is the centre.
///
/// # Source
/// Roberts 2018, the R2 sequence: steps of 1/g and 1/g^2 with g^3 = g + 1.
pub(super) fn subpixel_offsets(samples_per_pixel: u32) -> Vec<DVec2> {
    const G: f64 = 1.324_717_957_244_746;
    let step = DVec2::new(1.0 / G, 1.0 / (G * G));
    (0..samples_per_pixel).map(|k| (DVec2::splat(0.5) + step * f64::from(k)).fract()).collect()
}
