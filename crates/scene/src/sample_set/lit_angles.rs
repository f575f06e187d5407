//! Lit angles: the angles of the light circle at which point and directional lights reach the
//! points of a picture, or of ray ends. The page draws hard shadows from them while lights move.

use brood_light::{DirectionalLight, Light, LightAssets, PointLight};
use brood_mesh::UnitFrame;
use brood_mesh::trace::{Ray, Stack};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::frame::ShadedPoint;
use super::quadrature::PixelSampler;
use super::render::{ROWS, pixel_sampler};
use super::seen_point::LeavingRay;
use crate::description::Scene;
use crate::stage::{Obstacles, Stage};

/// Angles at which a light begins or ceases to reach each pixel of a square picture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LitAngles {
    side: u32,
    toggles: Vec<Toggles>,
}

/// Angles at which a light begins to reach a point and ceases in turn, ascending; the light is on
/// its circle from [`LitAngles::degrees`] of the first. [`NEVER`] where there are fewer.
pub type Toggles = [u16; 8];

/// Angles at which a light reaches a point, and those at which it does through clear parts.
pub(super) type Passages = [Toggles; 2];

/// Angles of a light that never reaches a point.
const DARK: Passages = [[NEVER; 8]; 2];
/// Number of rays that a thread follows at a time.
const TOGETHER: usize = 64;
/// Number of angles of a circle.
const ANGLES: u32 = 65_535;
/// Stands for no angle.
pub const NEVER: u16 = u16::MAX;
/// Number of angles at which every light is tested, of an object alone and of several, whose
/// shadows on each other are narrower; between two that differ the angle is bisected.
const TESTED: [u32; 2] = [64, 128];

impl LitAngles {
    /// Traces the lights of a scene from the point in the middle of each pixel, as pictures with
    /// one sample a pixel do. The point is that of the nearest object. A pixel whose middle misses
    /// all has the angles of one beside it. If parts of the stage are clear, all lights follow
    /// again with the angles at which nothing but clear parts is between light and point.
    ///
    /// # Domain
    /// The scene has shadows, and all lights are point or directional lights; others are skipped.
    /// Where a surface faces away from a light, its angles mean nothing. A shadow that crosses a
    /// point within 1/64 of the circle, or 1/128 with several objects, may be missed; of more than
    /// eight angles the closest pairs are left out.
    #[must_use]
    pub fn trace<'a>(scene: &Scene, stage: impl Into<Stage<'a>>, side: u32) -> Self {
        let stage = stage.into();
        let tracing = Tracing::new(scene, &stage, side);
        let rows: Vec<Vec<Option<Vec<Passages>>>> =
            (0..side).into_par_iter().with_max_len(1).map(|row| tracing.row(row, side)).collect();
        let near = |x: u32, y: u32| {
            pixels_near((x, y), side).find_map(|(x, y)| rows[y as usize][x as usize].as_ref())
        };
        let lights = tracing.lights.len();
        let kinds = if stage.clear().is_empty() { 1 } else { 2 };
        let mut toggles = Vec::with_capacity((side * side) as usize * lights * kinds);
        for (kind, light) in (0..kinds).flat_map(|kind| (0..lights).map(move |k| (kind, k))) {
            for y in (0..side).rev() {
                for x in 0..side {
                    toggles.push(near(x, y).map_or(DARK, |lights| lights[light])[kind]);
                }
            }
        }
        Self { side, toggles }
    }

    /// Finds the angles of all lights at the ends of rays that leave the subject. `parts` has the
    /// part in which each ray ends; a number beyond all parts has no angles.
    ///
    /// # Domain
    /// As [`LitAngles::trace`]. The rays are in the unit frame of the subject.
    pub(super) fn of_rays(
        scene: &Scene,
        stage: &Stage<'_>,
        side: u32,
        rays: &[(LeavingRay, usize)],
    ) -> Vec<Vec<Passages>> {
        let tracing = Tracing::new(scene, stage, side);
        let changes: Vec<_> =
            (0..stage.count()).map(|part| stage.with_part(part).change_from(0)).collect();
        let of_ray = |(leaving, part): &(LeavingRay, usize), stack: &mut Stack| {
            let change = changes.get(*part)?.as_ref();
            let ray = change.map_or(leaving.ray, |change| change.ray(leaving.ray));
            let point = tracing.parts[*part].point(ray, stack)?;
            Some(tracing.passages(&point, stack))
        };
        let chunks =
            rays.par_chunks(TOGETHER).with_max_len(ROWS).map_init(Stack::default, |stack, rays| {
                let dark = || vec![DARK; tracing.lights.len()];
                rays.iter().map(|ray| of_ray(ray, stack).unwrap_or_else(dark)).collect::<Vec<_>>()
            });
        chunks.flatten_iter().collect()
    }

    /// Side of the picture in pixels.
    #[must_use]
    pub fn side(&self) -> u32 {
        self.side
    }

    /// Angles row by row from the bottom, for one light after the other; with clear parts then
    /// again for all lights, through these parts.
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

/// Returns a pixel of a square picture, then those beside it.
pub(super) fn pixels_near((x, y): (u32, u32), side: u32) -> impl Iterator<Item = (u32, u32)> {
    let range = move |at: u32| at.saturating_sub(1)..=(at + 1).min(side - 1);
    let beside = range(y).flat_map(move |y| range(x).map(move |x| (x, y)));
    std::iter::once((x, y)).chain(beside)
}

/// Scene whose points are traced.
struct Tracing<'a> {
    /// Subject, other objects, ground.
    parts: Vec<Part<'a>>,
    lights: Vec<Lamp<'a>>,
}

/// Light whose angles are found.
enum Lamp<'a> {
    Point(&'a PointLight),
    Directional(&'a DirectionalLight),
}

/// Where a light is, in the unit frame of a part.
#[derive(Debug, Clone, Copy)]
enum Place {
    At(DVec3),
    /// Unit direction towards it.
    Towards(DVec3),
}

/// Part of a scene.
struct Part<'a> {
    sampler: PixelSampler<'a>,
    frame: UnitFrame,
    /// Angles at which each light is tested, with its places.
    circles: Vec<Vec<(u32, Place)>>,
}

/// Surface point in the unit frame of a part.
struct Point<'a> {
    part: &'a Part<'a>,
    position: DVec3,
    /// Start of shadow rays.
    start: DVec3,
    obstacles: &'a Obstacles<'a>,
    n: DVec3,
}

impl<'a> Tracing<'a> {
    fn new(scene: &'a Scene, stage: &Stage<'a>, side: u32) -> Self {
        let lights: Vec<Lamp<'_>> = scene.lights.iter().filter_map(Lamp::of).collect();
        let tested = TESTED[usize::from(stage.count() > 1)];
        let part = |part: usize| {
            let own = stage.with_part(part);
            let sampler = pixel_sampler(&own, scene, &LightAssets::default(), side.into());
            let frame = own.frame(scene);
            let circle = |light: &Lamp<'_>| {
                let place = |angle: u32| (angle, light.place(angle, &frame));
                (0..=tested).map(|k| place(k * ANGLES / tested)).collect()
            };
            let circles = lights.iter().map(circle).collect();
            Part { sampler, frame, circles }
        };
        Self { parts: (0..stage.count()).map(part).collect(), lights }
    }

    /// Returns the angles of all lights for each pixel of a row; `None` where its middle misses.
    fn row(&self, row: u32, side: u32) -> Vec<Option<Vec<Passages>>> {
        let mut stack = Stack::default();
        let of_pixel = |column: u32| {
            let point = self.parts.iter().find_map(|part| {
                let middle = part.sampler.ray(column, row, DVec2::splat(0.5));
                part.point(middle, &mut stack)
            })?;
            Some(self.passages(&point, &mut stack))
        };
        (0..side).map(of_pixel).collect()
    }

    fn passages(&self, point: &Point<'_>, stack: &mut Stack) -> Vec<Passages> {
        let lights = self.lights.iter().zip(&point.part.circles);
        lights.map(|(light, circle)| point.passages(light, circle, stack)).collect()
    }
}

impl Part<'_> {
    /// Returns the point that a ray in the unit frame of the part sees of it; `None` if that is not
    /// on this part.
    fn point(&self, ray: Ray, stack: &mut Stack) -> Option<Point<'_>> {
        let sampler = &self.sampler;
        let hit = sampler.visible_hit(ray, stack)?;
        let surface = &sampler.surface;
        let shaded = ShadedPoint::new(surface.parts, &hit, -ray.direction, surface.tangents);
        let (obstacles, start) = surface.shadow_start(&shaded, &hit)?;
        let position = surface.in_unit_frame(shaded.position);
        Some(Point { part: self, position, start, obstacles, n: shaded.frame.n() })
    }
}

impl Point<'_> {
    /// Returns the angles at which a light begins to reach the point and ceases, without and
    /// through clear parts. `circle` holds the tested angles with places of the light.
    fn passages(&self, light: &Lamp<'_>, circle: &[(u32, Place)], stack: &mut Stack) -> Passages {
        let facing = self.facing(light, circle);
        let mut passed = |place: Place| {
            let (direction, distance) = place.seen_from(self.position);
            let ray = Ray { origin: self.start, direction };
            self.obstacles.passed(ray, distance, stack)
        };
        let tested: Vec<f64> = facing.iter().map(|(_, place)| passed(*place)).collect();
        let is_clear = tested.iter().any(|passed| *passed > 0.0 && *passed < 1.0);
        let mut toggles =
            |is_lit: fn(f64) -> bool| self.toggles(light, (&facing, &tested), is_lit, &mut passed);
        let whole = toggles(|passed| passed >= 1.0);
        [whole, if is_clear { toggles(|passed| passed > 0.0) } else { whole }]
    }

    /// Returns the tested angles at which the surface faces a light, first and last ones of an arc
    /// included.
    fn facing(&self, light: &Lamp<'_>, circle: &[(u32, Place)]) -> Vec<(u32, Place)> {
        let place = |angle: u32| light.place(angle, &self.part.frame);
        let mut facing: Vec<(u32, Place)> = Vec::new();
        let mut before: Option<(u32, bool)> = None;
        for (angle, at) in circle {
            let now = self.faces(*at);
            if let Some((last, _)) = before.filter(|(_, was)| *was != now) {
                let end = bisected((last, *angle), |middle| self.faces(place(middle)) == now);
                let end = if now { end } else { end - 1 };
                facing.push((end, place(end)));
            }
            if now {
                facing.push((*angle, *at));
            }
            before = Some((*angle, now));
        }
        facing.dedup_by_key(|(angle, _)| *angle);
        facing
    }

    fn faces(&self, place: Place) -> bool {
        place.seen_from(self.position).0.dot(self.n) > 0.0
    }

    /// Returns the angles at which a condition on the share of light that passes begins to hold and
    /// ceases. `tested` has the shares at the angles of `facing`.
    fn toggles(
        &self,
        light: &Lamp<'_>,
        (facing, tested): (&[(u32, Place)], &[f64]),
        is_lit: fn(f64) -> bool,
        mut passed: impl FnMut(Place) -> f64,
    ) -> Toggles {
        let place = |angle: u32| light.place(angle, &self.part.frame);
        let mut all = facing.iter().zip(tested).map(|((angle, _), share)| (*angle, is_lit(*share)));
        let Some((mut last, mut present)) = all.next() else { return [NEVER; 8] };
        let mut found: Vec<u32> = if present { vec![0] } else { Vec::new() };
        for (angle, next) in all {
            if next != present {
                // If the surface faces away between the two, the exact angle does not matter.
                let is_arc = self.faces(place(last.midpoint(angle)));
                let of_next = |middle| is_lit(passed(place(middle))) == next;
                found.push(if is_arc { bisected((last, angle), of_next) } else { angle });
                present = next;
            }
            last = angle;
        }
        packed(found)
    }
}

impl<'a> Lamp<'a> {
    /// Returns the lamp of a light; `None` for other lights.
    fn of(light: &'a Light) -> Option<Self> {
        match light {
            Light::Point(light) => Some(Self::Point(light)),
            Light::Directional(light) => Some(Self::Directional(light)),
            _ => None,
        }
    }

    /// Returns the place at an angle.
    fn place(&self, angle: u32, frame: &UnitFrame) -> Place {
        let degrees = 360.0 * f64::from(angle) / f64::from(ANGLES);
        match self {
            Self::Point(light) => Place::At(light.place(degrees, frame)),
            Self::Directional(light) => Place::Towards(light.towards(degrees, frame)),
        }
    }
}

impl Place {
    /// Returns the unit direction to the light from a position, and its distance.
    fn seen_from(self, position: DVec3) -> (DVec3, f64) {
        match self {
            Self::At(place) => {
                let towards = place - position;
                let distance = towards.length();
                (towards / distance, distance)
            }
            Self::Towards(direction) => (direction, f64::INFINITY),
        }
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
    use brood_mesh::{BuiltinMesh, Mesh};

    use super::*;
    use crate::{PixelArea, Raster, SampleSet, Sampling};

    const SIDE: u32 = 48;

    /// Returns for each pixel whether light reaches its middle on some part of the stage.
    fn lit_pixels(scene: &Scene, stage: &Stage<'_>) -> Vec<bool> {
        let mut lit = vec![false; (SIDE * SIDE) as usize];
        for part in 0..stage.count() {
            let area = PixelArea::whole(SIDE);
            let raster = Raster { size_px: SIDE.into(), sampling: Sampling::Fixed(1), area };
            let (own, assets) = (stage.with_part(part), LightAssets::default());
            let set = SampleSet::render_with_assets(own, scene, &assets, raster);
            for span in set.image().unwrap().spans() {
                lit[span.pixel as usize] |= span.end > span.start;
            }
        }
        lit
    }

    /// Compares lit angles with pictures at many angles of the light.
    fn check_angles(scene: &str, others: &[BuiltinMesh]) {
        let scene: Scene = serde_json::from_str(scene).unwrap();
        scene.validate().unwrap();
        let mesh = Mesh::builtin(scene.builtin().unwrap());
        let others: Vec<Mesh> = others.iter().map(|mesh| Mesh::builtin(*mesh)).collect();
        let stage = Stage::new(&scene, &mesh, &others.iter().collect::<Vec<_>>());
        let subject = |share: f64| {
            let mut shares = vec![0.0; stage.count()];
            shares[0] = share;
            stage.with_clear(&shares)
        };
        let angles = LitAngles::trace(&scene, subject(0.5), SIDE);
        let all = scene.lights.len() * (SIDE * SIDE) as usize;
        assert_eq!((angles.side(), angles.toggles().len()), (SIDE, 2 * all));
        let (whole, clear) = angles.toggles().split_at(all);
        assert_eq!(whole, LitAngles::trace(&scene, stage.clone(), SIDE).toggles());
        check(&scene, &stage, whole, Some(50));
        // A subject that takes no light casts no shadow.
        let least = [None, Some(2000), Some(200)][(stage.count() - 1).min(2)];
        check(&scene, &subject(1.0), clear, least);
    }

    /// At least one of `least` points must be in shadow, none if it is `None`.
    fn check(scene: &Scene, stage: &Stage<'_>, angles: &[Toggles], least: Option<u32>) {
        let pixels = (SIDE * SIDE) as usize;
        let (mut shadowed, mut facing, mut differ) = (0, 0, 0);
        for k in 0..40u16 {
            let angle = k * 1638 + 57;
            for (light, own) in scene.lights.iter().zip(angles.chunks(pixels)) {
                let seen = Scene { lights: vec![light.clone()], ..scene.clone() };
                let seen = seen.with_light_deg(LitAngles::degrees(angle));
                let reached = lit_pixels(&seen, stage);
                let faces = lit_pixels(&Scene { shadows: false, ..seen }, stage);
                for (pixel, (reached, faces)) in reached.into_iter().zip(faces).enumerate() {
                    let (x, y) = (pixel % SIDE as usize, pixel / SIDE as usize);
                    let toggles = &own[(SIDE as usize - 1 - y) * SIDE as usize + x];
                    facing += u32::from(faces);
                    shadowed += u32::from(faces && !reached);
                    differ += u32::from(faces && reached != LitAngles::is_lit(toggles, angle));
                }
            }
        }
        let is_expected = least.map_or(shadowed == 0, |least| shadowed >= facing / least);
        assert!(is_expected, "{shadowed} of {facing} are in shadow");
        assert!(differ * 5000 <= facing, "{differ} of {facing} have another shadow");
    }

    #[test]
    fn angles_agree_with_pictures_at_every_angle() {
        check_angles(r#"{"mesh": "knob", "shadows": true}"#, &[]);
        check_angles(
            r#"{"mesh": "torus", "shadows": true,
                "lights": [{"position": [4, 0.5, 1]}, {"position": [-1, 3, 3]}]}"#,
            &[],
        );
        check_angles(
            r#"{"mesh": "knob", "shadows": true, "rotation_deg": [10, 20, 0],
                "lights": [{"kind": "directional", "direction": [-3, -1, -1]},
                    {"kind": "directional"}, {"position": [4, 0.5, 1]}]}"#,
            &[],
        );
    }

    #[test]
    fn angles_agree_with_pictures_of_several_objects() {
        check_angles(
            r#"{"mesh": "knob", "shadows": true, "ground": {}, "rotation_deg": [0, 30, 10],
                "camera": {"orbit_deg": [15, 20]}, "lights": [{}, {"position": [-1, 3, 3]}],
                "objects": [
                    {"mesh": "ball", "stands": true, "position": [1.2, 0, 0.6], "scale": 0.4},
                    {"mesh": "torus", "position": [-0.9, 0.3, 0.9], "scale": 0.5,
                        "rotation_deg": [40, 0, 20]}]}"#,
            &[BuiltinMesh::Ball, BuiltinMesh::Torus, BuiltinMesh::Ground],
        );
        check_angles(
            r#"{"mesh": "knob", "shadows": true, "ground": {}, "camera": {"orbit_deg": [15, 20]},
                "lights": [{"kind": "directional", "direction": [-2, -2, -1]}],
                "objects": [{"mesh": "torus", "stands": true, "position": [1.2, 0, 0.6],
                    "scale": 0.4}]}"#,
            &[BuiltinMesh::Torus, BuiltinMesh::Ground],
        );
        check_angles(
            r#"{"mesh": "cube", "scale": 0.8, "shadows": true, "lights": [{"position": [3, 1, 1]}],
                "objects": [{"mesh": "sphere", "position": [1, 0, 1], "scale": 0.4}]}"#,
            &[BuiltinMesh::Sphere],
        );
    }

    #[test]
    fn closest_angles_are_left_out() {
        assert_eq!(packed(vec![5, 9, ANGLES]), [5, 9, NEVER, NEVER, NEVER, NEVER, NEVER, NEVER]);
        let many = vec![0, 100, 200, 300, 400, 410, 500, 600, 700, 800];
        assert_eq!(packed(many), [0, 100, 200, 300, 500, 600, 700, 800]);
    }
}
