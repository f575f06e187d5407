//! Camera rays in the unit frame of the mesh.

use brood_mesh::UnitFrame;
use brood_mesh::angle::{orbit_direction, sin_cos_deg};
use brood_mesh::trace::Ray;
use glam::{DVec2, DVec3};

use super::size::PictureSize;
use crate::description::{Camera, LookAtCamera, OrbitCamera, OrthographicCamera};

/// Default distance of an orbit camera, divided by the distance at which the bounding sphere
/// touches the nearer edges of the picture.
const FRAMING_MARGIN: f64 = 1.04;

/// Camera in the unit frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct View {
    /// Eye, or start of the central ray of a parallel projection.
    origin: DVec3,
    /// `right` and `up` are as long as half the picture's height: on the plane at distance 1, or in
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
    /// Makes the view of a picture of a size. `fov_y_deg` and `orthographic` set the height; pixels
    /// are square, so the width follows.
    pub fn new(camera: &Camera, frame: &UnitFrame, size_px: PictureSize) -> Self {
        match *camera {
            Camera::Orbit(ref camera) => {
                let (distance, axes) = orbit(camera, frame, size_px);
                Self::perspective(axes[2] * distance, axes, camera.fov_y_deg, frame)
            }
            Camera::LookAt(LookAtCamera { eye, target, up, fov_y_deg }) => {
                let back = (DVec3::from(eye) - DVec3::from(target)).normalize();
                let right = DVec3::from(up).normalize().cross(back).normalize();
                let axes = [right, back.cross(right), back];
                Self::perspective(frame.relative(eye), axes, fov_y_deg, frame)
            }
            Camera::Orthographic(OrthographicCamera { orthographic }) => {
                // Rays start in front of the object, independent of the world's origin.
                let middle = frame.relative([0.0; 3]).truncate().extend(2.0 * frame.reach());
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

    /// Makes a view from orthonormal axes and half the height of the picture.
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

    /// Direction to the right in the picture, of any length.
    pub fn right(&self) -> DVec3 {
        self.right
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

    /// Returns the point where a ray meets a plane, projected as by [`View::project`]. The plane is
    /// perpendicular to the view, at a distance behind a centre. The component of a ray towards the
    /// eye is reversed. A ray that starts behind the plane meets it at its origin.
    pub fn on_plane_behind(&self, (centre, distance): (DVec3, f64), ray: Ray) -> DVec2 {
        let along = ray.direction.dot(self.forward);
        let direction = ray.direction - self.forward * (along - along.abs());
        let gap = distance - (ray.origin - centre).dot(self.forward);
        // A level ray ends far aside.
        let length = (gap.max(0.0) / along.abs().max(1e-9)).min(1e9);
        self.project(ray.origin + direction * length).unwrap_or_default()
    }

    /// Returns the angle of a pixel in radians, and its width at a position.
    pub fn pixel_width(&self, size_px: PictureSize, position: DVec3) -> (f64, f64) {
        let at_one = 2.0 * self.right.length() / f64::from(size_px.height);
        match self.parallel {
            true => (0.0, at_one),
            false => (at_one, at_one * (position - self.origin).length()),
        }
    }

    /// Returns the ray through a point of a pixel, within [0, 1]^2 from its upper left corner.
    pub fn pixel_ray(&self, size_px: PictureSize, (x, y): (u32, u32), offset: DVec2) -> Ray {
        let at = (DVec2::new(f64::from(x), f64::from(y)) + offset)
            * (2.0 / f64::from(size_px.height))
            - DVec2::new(size_px.aspect(), 1.0);
        self.ray(DVec2::new(at.x, -at.y))
    }

    /// Returns the ray through a point of the picture: x to the right, y upwards, in units of half
    /// the height.
    pub fn ray(&self, point: DVec2) -> Ray {
        let offset = self.right * point.x + self.up * point.y;
        if self.parallel {
            return Ray { origin: self.origin + offset, direction: self.forward };
        }
        Ray { origin: self.origin, direction: (self.forward + offset).normalize() }
    }
}

/// Returns the distance of a camera from the subject's centre in radii of its mesh, and its right,
/// up and back.
fn orbit(camera: &OrbitCamera, frame: &UnitFrame, size_px: PictureSize) -> (f64, [DVec3; 3]) {
    let OrbitCamera { orbit_deg: [azimuth, elevation], distance, fov_y_deg } = *camera;
    let back = orbit_direction(azimuth, elevation);
    // Also defined at elevation 90, unlike a cross product with y.
    let right = orbit_direction(azimuth + 90.0, 0.0);
    let framing = frame.framed() * FRAMING_MARGIN / sin_of_narrower(fov_y_deg, size_px);
    let distance = distance.map_or(framing, |distance| frame.length(distance));
    (distance, [right, back.cross(right), back])
}

/// Returns the camera in the form with eye, target and up; `None` for parallel rays.
pub(crate) fn looking_at(
    camera: &Camera,
    frame: &UnitFrame,
    size_px: PictureSize,
) -> Option<LookAtCamera> {
    match camera {
        Camera::Orbit(own) => {
            let (distance, [_, up, back]) = orbit(own, frame, size_px);
            let (eye, target) = (frame.world(back * distance), frame.world(DVec3::ZERO));
            Some(LookAtCamera { eye, target, up: up.to_array(), fov_y_deg: own.fov_y_deg })
        }
        Camera::LookAt(own) => Some(own.clone()),
        Camera::Orthographic(_) => None,
    }
}

/// Returns the sine of half the narrower angle of view, so that a sphere seen under it fits into
/// the shorter side.
fn sin_of_narrower(fov_y_deg: f64, size_px: PictureSize) -> f64 {
    let (sin, cos) = sin_cos_deg(0.5 * fov_y_deg);
    if size_px.aspect() >= 1.0 {
        return sin;
    }
    let across = size_px.aspect() * sin;
    across / (across * across + cos * cos).sqrt()
}

/// Returns positions of at least `samples` rays in a pixel, within [0, 1)^2: an odd number of them,
/// symmetric about the centre, which is the first.
///
/// Their mean is the centre, so a linear gradient has no error and pictures of different numbers of
/// samples are not shifted against each other. From five on, their second moments are those of a
/// square of cells, so a quadratic has no more error than on a regular grid. An even number of
/// symmetric positions cannot include the centre, which automatic exposure reads, so one ray is
/// added.
///
/// # Source
/// The Fibonacci lattice with steps of 1/n and of 1/phi, phi the golden ratio: no other ratio is
/// approximated worse by fractions, so the lattice is even for every n. Niederreiter 1992, *Random
/// Number Generation and Quasi-Monte Carlo Methods*, section 5.2. Centred, sheared and scaled here
/// (docs/maths/film.md).
pub(super) fn subpixel_offsets(samples: u32) -> Vec<DVec2> {
    const INVERSE_GOLDEN_RATIO: f64 = 0.618_033_988_749_894_8;
    let pairs = samples / 2;
    let n = f64::from(2 * pairs + 1);
    // One of each pair, from the centre.
    let offset = |k: u32| {
        let down = (f64::from(k) * INVERSE_GOLDEN_RATIO + 0.5).fract() - 0.5;
        DVec2::new(f64::from(k) / n, down)
    };
    let mut half: Vec<DVec2> = (1..=pairs).map(offset).collect();
    // Three symmetric positions are on a line, whatever their moments.
    if pairs > 1 {
        correct_second_moments(&mut half, n);
    }
    let centre = DVec2::splat(0.5);
    let both = half.into_iter().flat_map(|offset| [centre + offset, centre - offset]);
    std::iter::once(centre).chain(both).collect()
}

/// Shears and scales y so that over the `n` symmetric positions the mean of x y is 0 and that of
/// y^2 is that of x^2. Positions move by about 1/n and stay in the pixel.
fn correct_second_moments(half: &mut [DVec2], n: f64) {
    // Just below 1/2, where clamped positions would leave the pixel.
    const MOST: f64 = 0.5 - 1e-9;
    // A clamped position changes the moments again; three rounds reach the rounding of f64.
    for _ in 0..3 {
        let mean = |value: fn(&DVec2) -> f64| 2.0 * half.iter().map(value).sum::<f64>() / n;
        let expected = mean(|at| at.x * at.x);
        let shear = mean(|at| at.x * at.y) / expected;
        half.iter_mut().for_each(|at| at.y = (at.y - shear * at.x).clamp(-MOST, MOST));
        let found = 2.0 * half.iter().map(|at| at.y * at.y).sum::<f64>() / n;
        let scale = (expected / found).sqrt();
        half.iter_mut().for_each(|at| at.y = (at.y * scale).clamp(-MOST, MOST));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offsets_are_in_the_pixel_with_the_centre_first_and_as_mean() {
        for samples in (1..=300).chain([1023, 1024, 32767, 32768]) {
            let offsets = subpixel_offsets(samples);
            assert_eq!(offsets.len() as u32, samples | 1);
            assert_eq!(offsets[0], DVec2::splat(0.5));
            assert!(
                offsets.iter().all(|at| at.cmpge(DVec2::ZERO).all() && at.cmplt(DVec2::ONE).all())
            );
            let mean = offsets.iter().sum::<DVec2>() / offsets.len() as f64;
            assert!((mean - 0.5).length() < 1e-12, "{samples}: {mean}");
            if samples < 4 {
                continue;
            }
            let n = offsets.len() as f64;
            let moment = |value: fn(DVec2) -> f64| {
                offsets.iter().map(|at| value(*at - 0.5)).sum::<f64>() / n
            };
            let cells = (1.0 - 1.0 / (n * n)) / 12.0;
            let found =
                [moment(|at| at.x * at.x), moment(|at| at.y * at.y), moment(|at| at.x * at.y)];
            for (found, expected) in found.into_iter().zip([cells, cells, 0.0]) {
                // Positions clamped to the pixel leave a small rest.
                assert!((found - expected).abs() < 1e-4, "{samples}: {found} {expected}");
            }
        }
    }

    /// Area of the unit square where `normal` times position is below `distance`.
    fn half_plane_area(normal: DVec2, distance: f64) -> f64 {
        let DVec2 { x: a, y: b } = normal.abs();
        let above = distance - normal.min(DVec2::ZERO).element_sum();
        let square = |t: f64| t.max(0.0) * t.max(0.0);
        (square(above) - square(above - a) - square(above - b) + square(above - a - b))
            / (2.0 * a * b)
    }

    #[test]
    fn error_of_edges_is_near_the_optimum_and_falls_with_every_power_of_two() {
        let edges: Vec<(DVec2, f64)> = (0..4000)
            .map(|k| {
                let angle = std::f64::consts::PI * (0.5 + f64::from(k) * 0.754_877_666).fract();
                let normal = DVec2::from_angle(angle);
                let across = 1.42 * ((0.5 + f64::from(k) * 0.569_840_291).fract() - 0.5);
                (normal, across + 0.5 * normal.element_sum())
            })
            .collect();
        let rmse = |samples: u32| {
            let offsets = subpixel_offsets(samples);
            let error = |(normal, distance): &(DVec2, f64)| {
                let below = offsets.iter().filter(|at| normal.dot(**at) < *distance).count();
                below as f64 / offsets.len() as f64 - half_plane_area(*normal, *distance)
            };
            let sum: f64 = edges.iter().map(error).map(|e| e * e).sum();
            (sum / edges.len() as f64).sqrt()
        };
        let mut least = f64::INFINITY;
        for samples in (1..64).step_by(2).chain((65..1024).step_by(48)) {
            let found = rmse(samples);
            // Close to the optimum of n^-3/4 everywhere, and so never far above fewer samples.
            let scaled = found * f64::from(samples).powf(0.75);
            assert!((0.2..0.31).contains(&scaled), "{samples}: {scaled}");
            assert!(found < 1.05 * least, "{samples}: {found} {least}");
            least = least.min(found);
        }
        let powers: Vec<f64> = (0..11).map(|k| rmse(1 << k)).collect();
        assert!(powers.is_sorted_by(|before, after| before > after), "{powers:?}");
    }
}
