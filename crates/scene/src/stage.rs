//! The meshes of a scene in their places, and what hides a point from an eye or a light.

use std::sync::Arc;

use brood_mesh::angle::rotation_xyz_deg;
use brood_mesh::trace::{Ray, Stack, Tracer};
use brood_mesh::{FrameChange, GROUND_RADII, Mesh, UnitFrame};
use glam::{DVec2, DVec3};

use crate::description::{Scene, SceneObject};

/// Gap between an object and the ground that stands below it by default, in radii of the object.
/// Without it, rays that leave the base are hidden by the ground.
const GROUND_GAP: f64 = 1e-3;

/// The part of a scene that is sampled, among all parts: the subject (the object that is bred), the
/// other objects, the ground.
///
/// A mesh alone becomes the stage of a scene without other objects.
#[derive(Debug, Clone)]
pub struct Stage<'a> {
    mesh: &'a Mesh,
    /// All parts; `None` if there is only the subject.
    parts: Option<Arc<[Part<'a>]>>,
    part: usize,
    /// Share of light that passes through each part; `None` if all are opaque.
    clear: Option<Arc<[f64]>>,
    /// Bumps of the part's material.
    bumps: Option<Arc<dyn TextureBumps>>,
}

/// Bumps of a material: a height over the texture, which turns the normals of a part.
pub trait TextureBumps: std::fmt::Debug + Send + Sync {
    /// Changes of the height by u and by v at a texture position.
    ///
    /// # Domain
    /// Any finite position; the result is finite.
    fn slopes(&self, uv: DVec2) -> DVec2;
}

#[derive(Debug)]
struct Part<'a> {
    mesh: &'a Mesh,
    frame: UnitFrame,
}

impl<'a> From<&'a Mesh> for Stage<'a> {
    fn from(mesh: &'a Mesh) -> Self {
        Self { mesh, parts: None, part: 0, clear: None, bumps: None }
    }
}

impl<'a> Stage<'a> {
    /// Makes the stage of a scene's subject. `others` are the meshes of the scene's other objects,
    /// then that of its ground if it has one ([`brood_mesh::BuiltinMesh::Ground`]).
    ///
    /// # Panics
    /// If the number of meshes is not that of the scene.
    #[must_use]
    pub fn new(scene: &Scene, subject: &'a Mesh, others: &[&'a Mesh]) -> Self {
        let expected = scene.objects.len() + usize::from(scene.ground.is_some());
        assert_eq!(others.len(), expected, "a scene has one mesh for each object");
        if others.is_empty() {
            return subject.into();
        }
        let own = UnitFrame::new(subject, scene.scale, scene.rotation_deg);
        let gap = GROUND_GAP * subject.radius() * scene.scale;
        let ground = scene.ground.as_ref().map(|ground| {
            let lowest = || lowest(subject, scene.scale, scene.rotation_deg);
            ground.height.unwrap_or_else(|| lowest() - gap)
        });
        let mut frames = vec![own];
        frames.extend(scene.objects.iter().zip(others).map(|(object, mesh)| {
            let SceneObject { scale, rotation_deg, .. } = *object;
            let mut position = DVec3::from(object.position);
            if let (true, Some(ground)) = (object.stands, ground) {
                position.y = ground + gap - lowest(mesh, scale, rotation_deg);
            }
            own.of_object(mesh, position, scale, rotation_deg)
        }));
        let reach = frames[1..].iter().map(UnitFrame::extent).fold(0.0, f64::max);
        if let (Some(height), Some(mesh)) = (ground, others.last()) {
            let at = DVec3 { y: height, ..subject.centre() };
            let half_side = GROUND_RADII * subject.radius() * scene.scale;
            frames.push(own.of_object(mesh, at, half_side, [0.0; 3]));
        }
        let meshes = std::iter::once(subject).chain(others.iter().copied());
        let parts = meshes.zip(frames);
        let parts = parts.map(|(mesh, frame)| Part { mesh, frame: frame.among(reach) });
        Self { parts: Some(parts.collect()), ..subject.into() }
    }

    /// Number of parts.
    #[must_use]
    pub fn count(&self) -> usize {
        self.parts.as_ref().map_or(1, |parts| parts.len())
    }

    /// Returns the stage with another part: 0 for the subject, then the objects, then the ground.
    /// It has no bumps.
    ///
    /// # Panics
    /// If there is no such part.
    #[must_use]
    pub fn with_part(&self, part: usize) -> Self {
        assert!(part < self.count(), "a stage of {} parts has no part {part}", self.count());
        let mesh = self.parts.as_ref().map_or(self.mesh, |parts| parts[part].mesh);
        Self { mesh, parts: self.parts.clone(), part, clear: self.clear.clone(), bumps: None }
    }

    /// Returns the stage whose part has a material with bumps.
    #[must_use]
    pub fn with_bumps(self, bumps: Option<Arc<dyn TextureBumps>>) -> Self {
        Self { bumps, ..self }
    }

    /// Returns the bumps of the part's material.
    pub(crate) fn bumps(&self) -> Option<Arc<dyn TextureBumps>> {
        self.bumps.clone()
    }

    /// Returns the stage with clear parts, which take only a part of the light of what is behind
    /// them. `shares` has the share of light that passes through each part.
    ///
    /// # Domain
    /// Shares within [0, 1]; 0 is opaque.
    ///
    /// # Panics
    /// If there is not one share for each part.
    #[must_use]
    pub fn with_clear(&self, shares: &[f64]) -> Self {
        assert_eq!(shares.len(), self.count(), "one share for each part");
        let is_clear = shares.iter().any(|share| *share > 0.0);
        Self { clear: is_clear.then(|| shares.into()), ..self.clone() }
    }

    /// Returns the share of light that passes through each part; empty if all are opaque.
    #[must_use]
    pub fn clear(&self) -> &[f64] {
        self.clear.as_deref().unwrap_or_default()
    }

    /// Returns the mesh of the part.
    #[must_use]
    pub fn mesh(&self) -> &'a Mesh {
        self.mesh
    }

    /// Returns the number of the part.
    #[must_use]
    pub fn part(&self) -> usize {
        self.part
    }

    /// Returns the frame of the part in a scene, which differs from that of [`Stage::new`] at most
    /// in its lights and camera.
    pub(crate) fn frame(&self, scene: &Scene) -> UnitFrame {
        match &self.parts {
            Some(parts) => parts[self.part].frame,
            None => UnitFrame::new(self.mesh, scene.scale, scene.rotation_deg),
        }
    }

    /// Returns the subject's centre in the unit frame of the part, and the radius of that frame in
    /// radii of the subject.
    pub(crate) fn subject(&self) -> (DVec3, f64) {
        match &self.parts {
            Some(parts) => {
                let own = &parts[self.part].frame;
                (own.pivot(), own.scale() / parts[0].frame.scale())
            }
            None => (DVec3::ZERO, 1.0),
        }
    }

    /// Returns the change from the unit frame of another part to that of this one; `None` if it is
    /// the same part.
    ///
    /// # Panics
    /// If there is no such part.
    pub(crate) fn change_from(&self, part: usize) -> Option<FrameChange> {
        let parts = self.parts.as_ref().filter(|_| part != self.part);
        parts.map(|parts| parts[part].frame.to(&parts[self.part].frame))
    }

    /// Returns the other parts as obstacles of rays in the unit frame of this one.
    pub(crate) fn others(&self) -> Vec<Other<'a>> {
        let Some(parts) = &self.parts else { return Vec::new() };
        let own = &parts[self.part].frame;
        let others = parts.iter().enumerate().filter(|(part, _)| *part != self.part);
        let other = |(_, other): (usize, &Part<'a>)| {
            let back = other.frame.to(own);
            let (change, radius) = (own.to(&other.frame), back.length(1.0));
            Other { tracer: other.mesh.tracer(), change, centre: back.centre(), radius }
        };
        others.map(other).collect()
    }

    /// Returns what hides lights from points of the part.
    pub(crate) fn obstacles(&self) -> Obstacles<'a> {
        let clear = self.clear.as_ref().map(|shares| {
            let others = (0..self.count()).filter(|part| *part != self.part);
            (shares[self.part], others.map(|part| shares[part]).collect())
        });
        Obstacles { own: self.mesh.tracer(), others: self.others(), clear }
    }
}

/// Returns the height of the lowest vertex of a mesh that is scaled and rotated about its centre.
fn lowest(mesh: &Mesh, scale: f64, rotation_deg: [f64; 3]) -> f64 {
    let up = rotation_xyz_deg(rotation_deg).transpose() * DVec3::Y;
    let heights = mesh.parts().positions.iter().map(|at| (*at - mesh.centre()).dot(up));
    mesh.centre().y + heights.fold(f64::INFINITY, f64::min) * scale
}

/// Another part of a stage, as an obstacle.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Other<'a> {
    tracer: &'a Tracer,
    change: FrameChange,
    /// Bounding sphere.
    centre: DVec3,
    radius: f64,
}

/// Margin of bounding spheres, far above rounding errors.
const SPHERE_MARGIN: f64 = 1e-6;

impl Other<'_> {
    /// True if the part crosses a ray at a distance below `reach`, which may be infinite.
    pub fn is_hit(&self, ray: Ray, reach: f64, stack: &mut Stack) -> bool {
        self.may_be_hit(ray)
            && self.tracer.is_occluded(self.change.ray(ray), self.change.length(reach), stack)
    }

    /// False if a ray misses the bounding sphere. Cheaper than to transform the ray.
    fn may_be_hit(&self, ray: Ray) -> bool {
        let to_centre = self.centre - ray.origin;
        let (along, squared) = (to_centre.dot(ray.direction), to_centre.length_squared());
        let margin = SPHERE_MARGIN * (squared + self.radius * self.radius);
        let allowed = self.radius * self.radius + margin;
        let beside = if along > 0.0 { squared - along * along } else { squared };
        beside <= allowed || beside.is_nan()
    }
}

/// Casters of shadows: the part itself and all others.
#[derive(Debug, Clone)]
pub(crate) struct Obstacles<'a> {
    own: &'a Tracer,
    others: Vec<Other<'a>>,
    /// Share of light that passes through the part and through each other; `None` if all are
    /// opaque.
    clear: Option<(f64, Vec<f64>)>,
}

impl Obstacles<'_> {
    /// Returns the share of light that passes along a ray up to a distance `reach`, which may be
    /// infinite. Every clear object that it crosses takes its share once.
    #[inline]
    pub fn passed(&self, ray: Ray, reach: f64, stack: &mut Stack) -> f64 {
        match &self.clear {
            None => f64::from(u8::from(!self.is_occluded(ray, reach, stack))),
            Some(clear) => self.passed_clear((ray, reach), clear, stack),
        }
    }

    fn passed_clear(
        &self,
        (ray, reach): (Ray, f64),
        (own, others): &(f64, Vec<f64>),
        stack: &mut Stack,
    ) -> f64 {
        let mut passed = 1.0;
        if self.own.is_occluded(ray, reach, stack) {
            passed = *own;
        }
        for (other, share) in self.others.iter().zip(others) {
            if passed <= 0.0 {
                break;
            }
            if other.is_hit(ray, reach, stack) {
                passed *= share;
            }
        }
        passed
    }

    /// True if something crosses a ray at a positive distance below `reach`, which may be infinite.
    #[inline]
    pub fn is_occluded(&self, ray: Ray, reach: f64, stack: &mut Stack) -> bool {
        self.own.is_occluded(ray, reach, stack)
            || self.others.iter().any(|other| other.is_hit(ray, reach, stack))
    }
}

#[cfg(test)]
mod tests {
    use brood_light::LightAssets;
    use brood_mesh::BuiltinMesh;

    use super::*;
    use crate::{PixelArea, Raster, SampleSet, Sampling};

    const SIDE: u32 = 48;

    fn set(stage: Stage<'_>, scene: &Scene, sampling: Sampling) -> SampleSet {
        let (size_px, area) = (SIDE.into(), PixelArea::whole(SIDE));
        let raster = Raster { size_px, sampling, area };
        SampleSet::render_with_assets(stage, scene, &LightAssets::default(), raster)
    }

    fn scene(json: &str) -> Scene {
        let scene: Scene = serde_json::from_str(json).unwrap();
        scene.validate().unwrap();
        scene
    }

    fn coverage(set: &SampleSet) -> Vec<f32> {
        set.image().unwrap().coverage.to_vec()
    }

    #[test]
    fn parts_cover_a_pixel_together() {
        let scene = scene(
            r#"{"mesh": "torus", "objects": [{"mesh": "ball", "position": [0.9, 0, 1], "scale": 0.7}],
                "ground": {}, "camera": {"orbit_deg": [20, 25], "distance": 6}}"#,
        );
        let meshes =
            [BuiltinMesh::Torus, BuiltinMesh::Ball, BuiltinMesh::Ground].map(Mesh::builtin);
        let stage = Stage::new(&scene, &meshes[0], &[&meshes[1], &meshes[2]]);
        assert_eq!(stage.count(), 3);
        for sampling in [Sampling::Adaptive, Sampling::Fixed(16)] {
            let sets = [0, 1, 2].map(|part| set(stage.with_part(part), &scene, sampling));
            let [first, second, third] = sets.each_ref().map(coverage);
            let alone = coverage(&set((&meshes[0]).into(), &scene, sampling));
            let (mut hidden, mut off) = (0, 0.0);
            // Each part places its rays along its own edges.
            let most = if sampling == Sampling::Adaptive { 0.3 } else { 1e-5 };
            for pixel in 0..first.len() {
                let sum = first[pixel] + second[pixel] + third[pixel];
                // The ground reaches beyond the picture.
                assert!((sum - 1.0).abs() < most, "{sampling:?} {pixel}: {sum}");
                off += f64::from((sum - 1.0).abs()) / first.len() as f64;
                assert!(first[pixel] <= alone[pixel] + most, "{pixel}");
                hidden += u32::from(first[pixel] < alone[pixel] - 0.5);
            }
            assert!(hidden > 50, "{hidden} pixels of the subject are hidden");
            assert!(off < 2e-3, "{off}");
        }
    }

    /// An object alone, seen as an object of a scene, has the samples that it has as a subject.
    #[test]
    fn object_is_lit_as_a_subject_is() {
        let place = |of: &str| {
            format!(
                r#"{{"mesh": "sphere", "shadows": true, {of}
                    "camera": {{"eye": [3, 4, 9], "target": [2, 0, 0]}},
                    "lights": [{{"position": [5, 6, 4], "intensity": 9}},
                        {{"kind": "sphere", "position": [-1, 5, 2], "radius": 1, "radiance_w_m2_sr": 2}}]}}"#
            )
        };
        let object = r#""mesh": "knob", "scale": 0.8, "rotation_deg": [10, 20, 30]"#;
        let mesh = Mesh::builtin(BuiltinMesh::Knob);
        let centre = mesh.centre();
        let among = scene(&place(&format!(
            r#""scale": 0.001, "objects": [{{"position": [2, 0, 0], {object}}}],"#
        )));
        let alone = scene(&place("").replace(r#""mesh": "sphere""#, object));
        // The subject cannot be moved, so everything else is.
        let moved = |at: [f64; 3]| [at[0] - 2.0, at[1], at[2]];
        let mut alone = alone;
        let json = serde_json::to_value(&alone).unwrap();
        let mut json = json;
        for pointer in ["/camera/eye", "/camera/target", "/lights/0/position", "/lights/1/position"]
        {
            let at: [f64; 3] =
                serde_json::from_value(json.pointer(pointer).unwrap().clone()).unwrap();
            *json.pointer_mut(pointer).unwrap() = serde_json::to_value(moved(at)).unwrap();
        }
        alone = serde_json::from_value(json).unwrap();
        let dot = Mesh::builtin(BuiltinMesh::Sphere);
        let stage = Stage::new(&among, &dot, &[&mesh]).with_part(1);
        let found = set(stage, &among, Sampling::Fixed(4));
        let expected = set((&mesh).into(), &alone, Sampling::Fixed(4));
        let covered = |set: &SampleSet| coverage(set).iter().map(|c| f64::from(*c)).sum::<f64>();
        assert!((covered(&found) - covered(&expected)).abs() < 1.0, "{centre}");
        let light = |set: &SampleSet| {
            let sums = set
                .irradiance()
                .each_ref()
                .map(|channel| channel.iter().map(|e| f64::from(*e)).sum::<f64>());
            sums[0]
        };
        let ratio = light(&found) / light(&expected);
        assert!((ratio - 1.0).abs() < 2e-3, "{ratio}");
    }

    /// Under a light straight above, a ball shades a disc of its own radius on the ground.
    #[test]
    fn ball_shades_the_ground_below_it() {
        let json = r#"{"mesh": "sphere", "shadows": true, "ground": {"height": -2},
            "lights": [{"kind": "directional", "direction": [0, -1, 0]}],
            "camera": {"eye": [0, -1.5, 0], "target": [0, -2, 0], "up": [0, 0, 1], "fov_y_deg": 160}}"#;
        let scene = scene(json);
        let meshes = [BuiltinMesh::Sphere, BuiltinMesh::Ground].map(Mesh::builtin);
        let stage = Stage::new(&scene, &meshes[0], &[&meshes[1]]).with_part(1);
        let set = set(stage, &scene, Sampling::Fixed(1));
        let half = 0.5 * libm::tan(80f64.to_radians());
        let image = set.image().unwrap();
        let mut lit = vec![false; (SIDE * SIDE) as usize];
        for span in image.spans() {
            lit[span.pixel as usize] = span.end > span.start;
        }
        for (pixel, lit) in lit.into_iter().enumerate() {
            let at = |place: usize| 2.0 * (place as f64 + 0.5) / f64::from(SIDE) - 1.0;
            let (x, z) = (at(pixel % SIDE as usize) * half, at(pixel / SIDE as usize) * half);
            let distance = (x * x + z * z).sqrt();
            if (distance - 1.0).abs() > 0.01 {
                assert_eq!(lit, distance > 1.0, "{x} {z}");
            }
        }
    }

    /// Under a clear ball, the ground has the share of light that passes.
    #[test]
    fn clear_objects_shade_in_part() {
        let json = r#"{"mesh": "sphere", "shadows": true, "ground": {"height": -2},
            "lights": [{"kind": "directional", "direction": [0, -1, 0]}],
            "camera": {"eye": [0, -1.5, 0], "target": [0, -2, 0], "up": [0, 0, 1], "fov_y_deg": 20}}"#;
        let scene = scene(json);
        let meshes = [BuiltinMesh::Sphere, BuiltinMesh::Ground].map(Mesh::builtin);
        let stage = Stage::new(&scene, &meshes[0], &[&meshes[1]]);
        let light = |stage: &Stage<'_>| {
            let set = set(stage.with_part(1), &scene, Sampling::Fixed(1));
            set.irradiance()[0].iter().map(|e| f64::from(*e)).sum::<f64>()
        };
        let all = light(&stage.with_clear(&[1.0, 0.0]));
        assert!(all > 0.0);
        assert!((light(&stage.with_clear(&[0.25, 0.0])) / all - 0.25).abs() < 1e-6);
        assert!(light(&stage) <= 0.0 && light(&stage.with_clear(&[0.0; 2])) <= 0.0);
        let (size_px, area) = (SIDE.into(), PixelArea::whole(SIDE));
        let raster = Raster { size_px, sampling: Sampling::Fixed(1), area };
        let ground = stage.with_part(1).with_clear(&[0.25, 0.0]);
        let points = SampleSet::render_points(ground, &scene, &LightAssets::default(), raster);
        let visible = points.input(brood_brdf::Input::Light0Visibility);
        assert!(visible.iter().all(|v| (v - 0.25).abs() < 1e-6), "{visible:?}");
    }

    #[test]
    fn directional_lights_are_parallel_on_all_parts() {
        let json = r#"{"mesh": "cube", "scale": 2, "rotation_deg": [20, 0, 5], "ground": {},
            "objects": [{"mesh": "ball", "position": [4, 7, 0], "rotation_deg": [0, 70, 10]}]}"#;
        let scene = scene(json);
        let meshes = [BuiltinMesh::Cube, BuiltinMesh::Ball, BuiltinMesh::Ground].map(Mesh::builtin);
        let stage = Stage::new(&scene, &meshes[0], &[&meshes[1], &meshes[2]]);
        let light = brood_light::DirectionalLight::default();
        for part in 0..stage.count() {
            let frame = stage.with_part(part).frame(&scene);
            let expected = frame.direction(brood_mesh::angle::orbit_direction(65.0, 45.0));
            let towards = light.towards(0.0, &frame);
            assert!(towards.abs_diff_eq(expected, 1e-12), "{part}: {towards} {expected}");
        }
    }

    #[test]
    fn objects_stand_on_the_ground() {
        let json = r#"{"mesh": "cube", "scale": 2, "ground": {},
            "objects": [{"mesh": "ball", "stands": true, "position": [4, 7, 0], "scale": 0.5}]}"#;
        let scene = scene(json);
        let meshes = [BuiltinMesh::Cube, BuiltinMesh::Ball, BuiltinMesh::Ground].map(Mesh::builtin);
        let stage = Stage::new(&scene, &meshes[0], &[&meshes[1], &meshes[2]]);
        let lowest = |part: usize, mesh: &Mesh| {
            let frame = stage.with_part(part).frame(&scene);
            // The frame maps heights of the world to the object's.
            let of = |y: f64| frame.position(frame.relative([0.0, y, 0.0])).y;
            let own =
                mesh.parts().positions.iter().map(|at| (at.y - mesh.centre().y) / mesh.radius());
            let own = own.fold(f64::INFINITY, f64::min);
            (own - of(0.0)) / (of(1.0) - of(0.0))
        };
        let ground = stage.with_part(2).frame(&scene);
        let origin = ground.position(ground.relative([0.0; 3])).y;
        let per_unit = ground.position(ground.relative([0.0, 1.0, 0.0])).y - origin;
        let height = -origin / per_unit;
        let gap = GROUND_GAP * meshes[0].radius() * 2.0;
        assert!((lowest(0, &meshes[0]) - height - gap).abs() < 1e-9);
        assert!((lowest(1, &meshes[1]) - height - gap).abs() < 1e-9);
    }
}
