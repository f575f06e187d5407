//! Lit angles: the angles of the light circle at which point and directional lights reach the
//! points of a picture. The page draws hard shadows from them while lights move.

use brood_light::{DirectionalLight, Light, LightAssets, PointLight};
use brood_mesh::UnitFrame;
use brood_mesh::trace::{Ray, Stack};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::frame::ShadedPoint;
use super::quadrature::PixelSampler;
use super::render::pixel_sampler;
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
    /// all has the angles of one beside it.
    ///
    /// # Domain
    /// The scene has shadows, and all lights are point or directional lights; others are skipped.
    /// Where a surface faces away from a light, its angles mean nothing. A shadow that crosses a
    /// point within 1/64 of the circle, or 1/128 with several objects, may be missed; of more than
    /// eight angles the closest pairs are left out.
    #[must_use]
    pub fn trace<'a>(scene: &Scene, stage: impl Into<Stage<'a>>, side: u32) -> Self {
        let stage = stage.into();
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
        let parts = (0..stage.count()).map(part).collect();
        let tracing = Tracing { parts, lights: &lights };
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
    /// Subject, other objects, ground.
    parts: Vec<Part<'a>>,
    lights: &'a [Lamp<'a>],
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

impl Tracing<'_> {
    /// Returns the angles of all lights for each pixel of a row; `None` where its middle misses.
    fn row(&self, row: u32, side: u32) -> Vec<Option<Vec<Toggles>>> {
        let mut stack = Stack::default();
        let of_pixel = |column: u32| {
            let point = self.parts.iter().find_map(|part| part.point((column, row), &mut stack))?;
            let lights = self.lights.iter().zip(&point.part.circles);
            let of_light = |(light, circle): (&Lamp<'_>, &Vec<(u32, Place)>)| {
                point.toggles(light, circle, &mut stack)
            };
            Some(lights.map(of_light).collect())
        };
        (0..side).map(of_pixel).collect()
    }
}

impl Part<'_> {
    /// Returns the point in the middle of a pixel; `None` if that is not on this part.
    fn point(&self, (x, y): (u32, u32), stack: &mut Stack) -> Option<Point<'_>> {
        let sampler = &self.sampler;
        let ray = sampler.ray(x, y, DVec2::splat(0.5));
        let hit = sampler.visible_hit(ray, stack)?;
        let surface = &sampler.surface;
        let shaded = ShadedPoint::new(surface.parts, &hit, -ray.direction, surface.tangents);
        let (obstacles, start) = surface.shadow_start(&shaded, &hit)?;
        let position = surface.in_unit_frame(shaded.position);
        Some(Point { part: self, position, start, obstacles, n: shaded.frame.n() })
    }
}

impl Point<'_> {
    /// Returns the angles at which a light begins to reach the point and ceases. `circle` holds the
    /// tested angles with places of the light.
    fn toggles(&self, light: &Lamp<'_>, circle: &[(u32, Place)], stack: &mut Stack) -> Toggles {
        let place = |angle: u32| light.place(angle, &self.part.frame);
        let faces = |place: Place| place.seen_from(self.position).0.dot(self.n) > 0.0;
        let mut is_lit = |place: Place| {
            let (direction, distance) = place.seen_from(self.position);
            let ray = Ray { origin: self.start, direction };
            !self.obstacles.is_occluded(ray, distance, stack)
        };
        // Angles at which the surface faces the light, first and last ones of an arc included.
        let mut facing: Vec<(u32, Place)> = Vec::new();
        let mut before: Option<(u32, bool)> = None;
        for (angle, at) in circle {
            let now = faces(*at);
            if let Some((last, _)) = before.filter(|(_, was)| *was != now) {
                let end = bisected((last, *angle), |middle| faces(place(middle)) == now);
                let end = if now { end } else { end - 1 };
                facing.push((end, place(end)));
            }
            if now {
                facing.push((*angle, *at));
            }
            before = Some((*angle, now));
        }
        facing.dedup_by_key(|(angle, _)| *angle);
        let Some((first, rest)) = facing.split_first() else { return [NEVER; 8] };
        let mut present = is_lit(first.1);
        let mut found: Vec<u32> = if present { vec![0] } else { Vec::new() };
        let mut last = first.0;
        for (angle, at) in rest {
            let next = is_lit(*at);
            if next != present {
                // If the surface faces away between the two, the exact angle does not matter.
                let is_arc = faces(place(last.midpoint(*angle)));
                let of_next = |middle| is_lit(place(middle)) == next;
                found.push(if is_arc { bisected((last, *angle), of_next) } else { *angle });
                present = next;
            }
            last = *angle;
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
        let angles = LitAngles::trace(&scene, stage.clone(), SIDE);
        let pixels = (SIDE * SIDE) as usize;
        assert_eq!((angles.side(), angles.toggles().len()), (SIDE, scene.lights.len() * pixels));
        let (mut shadowed, mut facing, mut differ) = (0, 0, 0);
        for k in 0..40u16 {
            let angle = k * 1638 + 57;
            for (light, own) in scene.lights.iter().zip(angles.toggles().chunks(pixels)) {
                let seen = Scene { lights: vec![light.clone()], ..scene.clone() };
                let seen = seen.with_light_deg(LitAngles::degrees(angle));
                let reached = lit_pixels(&seen, &stage);
                let faces = lit_pixels(&Scene { shadows: false, ..seen }, &stage);
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
