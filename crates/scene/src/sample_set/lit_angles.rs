//! Lit angles: the angles of the light circle at which point lights reach the points of a picture.
//! The page draws hard shadows from them while lights move.

use brood_light::{Light, PointLight};
use brood_mesh::trace::{Ray, Stack, Tracer};
use brood_mesh::{Mesh, UnitFrame};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::frame::ShadedPoint;
use super::point::START_ABOVE;
use super::size::PictureSize;
use super::view::View;
use crate::description::Scene;

/// Angles at which a light begins or ceases to reach each pixel of a square picture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LitAngles {
    side: u32,
    toggles: Vec<Toggles>,
}

/// Angles at which a light begins to reach a point and ceases in turn, ascending; the light is on
/// its circle from [`LitAngles::degrees`] of the first. [`NEVER`] where there are fewer.
pub type Toggles = [u16; 8];

/// Number of angles of a circle.
const ANGLES: u32 = 65_535;
/// Stands for no angle.
pub const NEVER: u16 = u16::MAX;
/// Number of angles at which every light is tested; between two that differ the angle is bisected.
const TESTED: u32 = 64;

impl LitAngles {
    /// Traces the lights of a scene from the point in the middle of each pixel, as pictures with
    /// one sample a pixel do. A pixel whose middle misses the object has the angles of one beside
    /// it.
    ///
    /// # Domain
    /// All lights are point lights. Where a surface faces away from a light, its angles mean
    /// nothing. A shadow that crosses a point within 1/64 of the circle may be missed; of more than
    /// eight angles the closest pairs are left out.
    #[must_use]
    pub fn trace(scene: &Scene, mesh: &Mesh, side: u32) -> Self {
        let frame = UnitFrame::new(mesh, scene.scale, scene.rotation_deg);
        let points = |light: &Light| match light {
            Light::Point(light) => Some(light.clone()),
            _ => None,
        };
        let lights: Vec<PointLight> = scene.lights.iter().filter_map(points).collect();
        let view = View::new(&scene.camera, &frame, side.into());
        let tracing = Tracing { scene, mesh, tracer: mesh.tracer(), frame, view, lights };
        let rows: Vec<Vec<Option<Vec<Toggles>>>> =
            (0..side).into_par_iter().map(|row| tracing.row(row, side)).collect();
        let beside = |x: u32, y: u32| {
            let near = |at: u32| at.saturating_sub(1)..=(at + 1).min(side - 1);
            let mut pixels = near(y).flat_map(|y| near(x).map(move |x| (x, y)));
            pixels.find_map(|(x, y)| rows[y as usize][x as usize].as_ref())
        };
        let mut toggles = Vec::with_capacity((side * side) as usize * tracing.lights.len());
        for light in 0..tracing.lights.len() {
            for y in (0..side).rev() {
                for x in 0..side {
                    let own = rows[y as usize][x as usize].as_ref().or_else(|| beside(x, y));
                    toggles.push(own.map_or([NEVER; 8], |lights| lights[light]));
                }
            }
        }
        Self { side, toggles }
    }

    /// Side of the picture in pixels.
    #[must_use]
    pub fn side(&self) -> u32 {
        self.side
    }

    /// Angles light after light, row by row from the bottom.
    #[must_use]
    pub fn toggles(&self) -> &[Toggles] {
        &self.toggles
    }

    /// Returns an angle as the `light_deg` of scenes.
    #[must_use]
    pub fn degrees(angle: u16) -> f64 {
        360.0 * f64::from(angle) / f64::from(ANGLES)
    }

    /// True if a light at an angle reaches the point with these toggles.
    #[must_use]
    pub fn is_lit(toggles: &Toggles, angle: u16) -> bool {
        toggles.iter().filter(|toggle| **toggle <= angle).count() % 2 == 1
    }
}

/// Scene whose points are traced.
struct Tracing<'a> {
    scene: &'a Scene,
    mesh: &'a Mesh,
    tracer: &'a Tracer,
    frame: UnitFrame,
    view: View,
    lights: Vec<PointLight>,
}

/// Surface point in the unit frame.
struct Point {
    position: DVec3,
    /// Start of shadow rays.
    start: DVec3,
    n: DVec3,
}

impl Tracing<'_> {
    /// Returns the angles of all lights for each pixel of a row; `None` where its middle misses.
    fn row(&self, row: u32, side: u32) -> Vec<Option<Vec<Toggles>>> {
        let mut stack = Stack::default();
        let size_px = PictureSize::from(side);
        let of_pixel = |column: u32| {
            let ray = self.view.pixel_ray(size_px, (column, row), DVec2::splat(0.5));
            let point = self.point(ray, &mut stack)?;
            let of_light = |light: &PointLight| self.toggles(light, &point, &mut stack);
            Some(self.lights.iter().map(of_light).collect())
        };
        (0..side).map(of_pixel).collect()
    }

    /// Returns the point that a camera ray hits.
    fn point(&self, ray: Ray, stack: &mut Stack) -> Option<Point> {
        let hit = self.tracer.trace(ray, stack)?;
        let parts = self.mesh.parts();
        let shaded = ShadedPoint::new(parts, &hit, -ray.direction, self.scene.tangents);
        let in_unit_frame = |at: DVec3| (at - self.mesh.centre()) / self.mesh.radius();
        let start = in_unit_frame(shaded.shadow_start(self.scene.normals, parts, &hit));
        Some(Point {
            position: in_unit_frame(shaded.position),
            start: start + shaded.face() * START_ABOVE,
            n: shaded.frame.n(),
        })
    }

    fn toggles(&self, light: &PointLight, point: &Point, stack: &mut Stack) -> Toggles {
        let towards = |angle: u32| {
            let degrees = 360.0 * f64::from(angle) / f64::from(ANGLES);
            light.place(degrees, &self.frame) - point.position
        };
        let faces = |angle: u32| towards(angle).dot(point.n) > 0.0;
        let mut is_lit = |angle: u32| {
            let towards = towards(angle);
            let distance = towards.length();
            let ray = Ray { origin: point.start, direction: towards / distance };
            !self.tracer.is_occluded(ray, distance, stack)
        };
        // Angles at which the surface faces the light, first and last ones of an arc included.
        let tested = (0..=TESTED).map(|k| k * ANGLES / TESTED);
        let mut facing: Vec<u32> = Vec::new();
        let mut before: Option<(u32, bool)> = None;
        for angle in tested {
            let now = faces(angle);
            if let Some((last, _)) = before.filter(|(_, was)| *was != now) {
                let end = bisected((last, angle), |middle| faces(middle) == now);
                facing.push(if now { end } else { end - 1 });
            }
            if now {
                facing.push(angle);
            }
            before = Some((angle, now));
        }
        facing.dedup();
        let Some((first, rest)) = facing.split_first() else { return [NEVER; 8] };
        let mut present = is_lit(*first);
        let mut found: Vec<u32> = if present { vec![0] } else { Vec::new() };
        let mut last = *first;
        for angle in rest {
            let next = is_lit(*angle);
            if next != present {
                // If the surface faces away between the two, the exact angle does not matter.
                let is_arc = faces(last.midpoint(*angle));
                let of_next = |middle| is_lit(middle) == next;
                found.push(if is_arc { bisected((last, *angle), of_next) } else { *angle });
                present = next;
            }
            last = *angle;
        }
        packed(found)
    }
}

/// Returns an angle of which a condition is true, and false of the one before. It is false of the
/// first and true of the second.
fn bisected((mut no, mut yes): (u32, u32), mut is_true: impl FnMut(u32) -> bool) -> u32 {
    while yes - no > 1 {
        let middle = no.midpoint(yes);
        if is_true(middle) { yes = middle } else { no = middle }
    }
    yes
}

/// Packs ascending angles. Of more than fit, the closest pairs are left out.
fn packed(mut found: Vec<u32>) -> Toggles {
    found.retain(|angle| *angle < ANGLES);
    while found.len() > 8 {
        let closest = (1..found.len()).min_by_key(|k| found[*k] - found[*k - 1]);
        let at = closest.expect("there are several");
        found.drain(at - 1..=at);
    }
    let mut toggles = [NEVER; 8];
    for (toggle, angle) in toggles.iter_mut().zip(found) {
        *toggle = u16::try_from(angle).expect("angles are below 65,535");
    }
    toggles
}

#[cfg(test)]
mod tests {
    use brood_mesh::BuiltinMesh;

    use super::*;
    use crate::{SampleSet, Sampling};

    const SIDE: u32 = 48;

    /// Returns for each pixel whether light reaches its middle.
    fn lit_pixels(scene: &Scene, mesh: &Mesh) -> Vec<bool> {
        let set = SampleSet::render(mesh, scene, SIDE, Sampling::Fixed(1));
        let mut lit = vec![false; (SIDE * SIDE) as usize];
        for span in set.image().unwrap().spans() {
            lit[span.pixel as usize] = span.end > span.start;
        }
        lit
    }

    #[test]
    fn angles_agree_with_pictures_at_every_angle() {
        for (mesh, lights) in [
            ("knob", r#"[{}]"#),
            ("torus", r#"[{"position": [4, 0.5, 1]}, {"position": [-1, 3, 3]}]"#),
        ] {
            let json = format!(r#"{{"mesh": "{mesh}", "shadows": true, "lights": {lights}}}"#);
            let scene: Scene = serde_json::from_str(&json).unwrap();
            let mesh = Mesh::builtin(BuiltinMesh::from_name(mesh).unwrap());
            let angles = LitAngles::trace(&scene, &mesh, SIDE);
            let pixels = (SIDE * SIDE) as usize;
            assert_eq!(
                (angles.side(), angles.toggles().len()),
                (SIDE, scene.lights.len() * pixels)
            );
            let (mut shadowed, mut facing, mut differ) = (0, 0, 0);
            for k in 0..40u16 {
                let angle = k * 1638 + 57;
                for (light, own) in scene.lights.iter().zip(angles.toggles().chunks(pixels)) {
                    let seen = Scene { lights: vec![light.clone()], ..scene.clone() };
                    let seen = seen.with_light_deg(LitAngles::degrees(angle));
                    let reached = lit_pixels(&seen, &mesh);
                    let faces = lit_pixels(&Scene { shadows: false, ..seen }, &mesh);
                    for (pixel, (reached, faces)) in reached.into_iter().zip(faces).enumerate() {
                        let (x, y) = (pixel % SIDE as usize, pixel / SIDE as usize);
                        let toggles = &own[(SIDE as usize - 1 - y) * SIDE as usize + x];
                        facing += u32::from(faces);
                        shadowed += u32::from(faces && !reached);
                        differ += u32::from(faces && reached != LitAngles::is_lit(toggles, angle));
                    }
                }
            }
            assert!(shadowed * 50 > facing, "{shadowed} of {facing} are in shadow");
            assert!(differ * 5000 <= facing, "{differ} of {facing} have another shadow");
        }
    }

    #[test]
    fn closest_angles_are_left_out() {
        assert_eq!(packed(vec![5, 9, ANGLES]), [5, 9, NEVER, NEVER, NEVER, NEVER, NEVER, NEVER]);
        let many = vec![0, 100, 200, 300, 400, 410, 500, 600, 700, 800];
        assert_eq!(packed(many), [0, 100, 200, 300, 500, 600, 700, 800]);
    }
}
