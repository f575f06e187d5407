//! Clear bodies with two ways out, compared with the whole tree of mirrored and refracted rays.

use brood_eval::decode_png;
use brood_genome::preset::Preset;
use brood_genome::{Effect, Genome};
use brood_mesh::trace::{Hit, Ray, Stack};
use brood_mesh::{BuiltinMesh, Mesh};
use brood_protocol::{Frame, MeshSource, ObjectSource, PictureFormat};
use brood_scene::{PixelArea, Sampling, Scene};
use glam::DVec3;

use super::*;

const SIDE: u32 = 64;
/// Half of the visible height.
const HALF: f64 = 1.3;
/// Largest number of walls at which the tree divides.
const DEEP: u32 = 100;
/// Share of a pixel below which rays are not followed.
const FAINT: f64 = 1e-4;
/// Distance of new rays from the surface, in radii.
const ABOVE: f64 = 1e-6;

/// Colour of a pixel: a constant, plus the colours of rays times their shares.
#[derive(Default)]
struct Tree {
    color: [f64; 3],
    rays: Vec<(f64, Ray)>,
}

/// Clear body whose tree is followed.
struct Body<'a> {
    mesh: &'a Mesh,
    glass: &'a Effect,
    index: f64,
}

/// Where a ray meets the body.
struct Wall {
    position: DVec3,
    /// Shading normal and normal of the triangle, on the side of the ray.
    n: DVec3,
    face: DVec3,
}

fn mirrored(direction: DVec3, n: DVec3) -> DVec3 {
    direction - 2.0 * direction.dot(n) * n
}

/// Direction behind a wall by Snell's law; `None` if all is mirrored. `eta`: index before over that
/// behind it.
fn bent(direction: DVec3, n: DVec3, eta: f64) -> Option<DVec3> {
    let across = eta * (direction - direction.dot(n) * n);
    let along = 1.0 - across.length_squared();
    (along > 0.0).then(|| across - along.sqrt() * n)
}

/// Share of unpolarised light that a wall mirrors, by the cosines on both sides.
fn fresnel(before: f64, behind: f64, eta: f64) -> f64 {
    let s = (eta * before - behind) / (eta * before + behind);
    let p = (before - eta * behind) / (before + eta * behind);
    0.5 * (s * s + p * p)
}

impl Body<'_> {
    fn hit(&self, ray: Ray, stack: &mut Stack) -> Option<Wall> {
        let hit: Hit = self.mesh.tracer().trace(ray, stack)?;
        let parts = self.mesh.parts();
        let corners = parts.triangles[hit.triangle].map(|corner| corner as usize);
        let at = |values: &[DVec3]| -> DVec3 {
            corners.iter().zip(hit.weights).map(|(corner, weight)| weight * values[*corner]).sum()
        };
        let [a, b, c] = corners.map(|corner| parts.positions[corner]);
        let towards = |n: DVec3| if n.dot(ray.direction) > 0.0 { -n } else { n };
        let face = towards((b - a).cross(c - a).normalize());
        let n = at(&parts.normals).normalize();
        let n = if n.dot(face) < 0.0 { -n } else { n };
        let n = if n.dot(ray.direction) < 0.0 { n } else { face };
        let position = (at(&parts.positions) - self.mesh.centre()) / self.mesh.radius();
        Some(Wall { position, n, face })
    }

    fn depth_color(&self, tree: &mut Tree, share: f64) {
        for (sum, channel) in tree.color.iter_mut().zip(self.glass.color("color")) {
            *sum += share * channel;
        }
    }

    /// Adds what a ray outside of the body sees.
    fn outside(&self, ray: Ray, (deep, share): (u32, f64), tree: &mut Tree, stack: &mut Stack) {
        let Some(wall) = self.hit(ray, stack) else { return tree.rays.push((share, ray)) };
        if deep == 0 || share < FAINT {
            return self.depth_color(tree, share);
        }
        let limb = 1.0 + ray.direction.dot(wall.n);
        let [from, to, exponent] = ["from", "to", "exponent"].map(|name| self.glass.scalar(name));
        let mirror = from + (to - from) * limb.powf(exponent);
        let leaving = |n| mirrored(ray.direction, n);
        let direction = leaving(wall.n);
        let direction = if direction.dot(wall.face) > 0.0 { direction } else { leaving(wall.face) };
        let up = Ray { origin: wall.position + ABOVE * wall.face, direction };
        self.outside(up, (deep - 1, share * mirror), tree, stack);
        let direction = bent(ray.direction, wall.n, 1.0 / self.index)
            .filter(|direction| direction.dot(wall.face) < 0.0)
            .or_else(|| bent(ray.direction, wall.face, 1.0 / self.index))
            .expect("light enters a denser body");
        let down = Ray { origin: wall.position - ABOVE * wall.face, direction };
        self.inside(down, (deep - 1, share * (1.0 - mirror)), tree, stack);
    }

    /// Adds what a ray in the body sees.
    fn inside(&self, ray: Ray, (deep, share): (u32, f64), tree: &mut Tree, stack: &mut Stack) {
        let Some(wall) = self.hit(ray, stack) else { return tree.rays.push((share, ray)) };
        let length = (wall.position - ray.origin).length();
        let clear = (-length / self.glass.scalar("depth")).exp2();
        self.depth_color(tree, share * (1.0 - clear));
        let share = share * clear;
        if deep == 0 || share < FAINT {
            return self.depth_color(tree, share);
        }
        let out = bent(ray.direction, wall.n, self.index);
        let stays = out
            .map_or(1.0, |out| fresnel(-ray.direction.dot(wall.n), -out.dot(wall.n), self.index));
        if let Some(direction) = out {
            let by_face = || bent(ray.direction, wall.face, self.index);
            let is_out = direction.dot(wall.face) < 0.0;
            let direction = if is_out { direction } else { by_face().unwrap_or(direction) };
            let ray = Ray { origin: wall.position - ABOVE * wall.face, direction };
            self.outside(ray, (deep - 1, share * (1.0 - stays)), tree, stack);
        }
        let direction = mirrored(ray.direction, wall.n);
        let is_in = direction.dot(wall.face) > 0.0;
        let direction = if is_in { direction } else { mirrored(ray.direction, wall.face) };
        let ray = Ray { origin: wall.position + ABOVE * wall.face, direction };
        self.inside(ray, (deep - 1, share * stays), tree, stack);
    }
}

fn preset(name: &str) -> Program {
    Program::lower(Preset::find(name).expect("the preset exists").genome())
}

/// Returns the sum of squared differences in codes between a picture and the tree, and the number
/// of channel values.
fn error(mesh: BuiltinMesh, parameters: &str) -> (f64, usize) {
    let text = format!("brood 1\n.effect light\n.effect glass\n{parameters}\nstrength 1\n");
    let style = Program::lower(&text.parse::<Genome>().unwrap());
    let scene: Scene = serde_json::from_str(&format!(
        r#"{{"mesh": "{}", "ground": {{}}, "camera": {{"orthographic": {HALF}}}, "lights": [{{}}],
            "objects": [{{"mesh": "cube", "position": [0.7, 0, -2.5], "stands": true}},
                {{"mesh": "sphere", "position": [-2.3, 0.2, -0.5]}}],
            "backdrop": {{"kind": "color", "color": [0.75, 0.85, 0.95]}},
            "film": {{"exposure": 0}}}}"#,
        mesh.name(),
    ))
    .unwrap();
    scene.validate().unwrap();
    let materials = ["paint-toon", "red-plastic", "matt-clay"].map(preset);
    let object =
        |program: &Program| ObjectSource { mesh: MeshSource::Builtin, words: program.to_words() };
    let options = (PictureFormat::Png, Backend::Cpu);
    let frame = Frame::new(&scene, MeshSource::Builtin, SIDE, Sampling::Fixed(1), options)
        .with_objects(materials.iter().map(object).collect());
    let renderer = Renderer::new(Backend::Cpu);
    let loaded = renderer.builtin(mesh);
    let picture = renderer.render(&frame, &loaded, &[&style]).unwrap().remove(0);
    let (_, _, rgba) = decode_png(&picture.bytes).unwrap();

    let body = Body {
        mesh: loaded.mesh(),
        glass: style.glass().unwrap(),
        index: style.glass().unwrap().index_of_refraction().unwrap(),
    };
    let (centre, radius) = (body.mesh.centre(), body.mesh.radius());
    let mut stack = Stack::default();
    let mut trees: Vec<(usize, Tree)> = Vec::new();
    for pixel in 0..SIDE * SIDE {
        let across = |at: u32| HALF * ((2 * at + 1) as f64 / f64::from(SIDE) - 1.0);
        let eye = DVec3::new(across(pixel % SIDE), -across(pixel / SIDE), 3.0);
        let ray = Ray { origin: (eye - centre) / radius, direction: DVec3::NEG_Z };
        if body.hit(ray, &mut stack).is_some() {
            let mut tree = Tree::default();
            body.outside(ray, (DEEP, 1.0), &mut tree, &mut stack);
            trees.push((pixel as usize, tree));
        }
    }
    let rays = trees.iter().flat_map(|(_, tree)| &tree.rays);
    let rays: Vec<LeavingRay> = rays.map(|(_, ray)| LeavingRay { ray: *ray, seed: 0 }).collect();
    let (assets, others) = (renderer.loaded_assets(), renderer.objects(&frame, &scene).unwrap());
    let view = SceneView::among(&scene, &loaded, &others, &assets);
    let area = PixelArea::whole(SIDE);
    let shot = Shot { view, frame: &frame, film: scene.film, area, subject: None };
    let mut colors = renderer.seen_around(&shot, &rays, Gain::fixed(0.0)).unwrap().into_iter();
    let mut sum = 0.0;
    for (pixel, tree) in &trees {
        let mut expected = tree.color;
        for (share, _) in &tree.rays {
            let color = colors.next().unwrap().expect("there is a backdrop");
            expected.iter_mut().zip(color).for_each(|(sum, c)| *sum += share * f64::from(c));
        }
        for (code, expected) in rgba[4 * pixel..].iter().zip(expected) {
            sum += (f64::from(*code) - 255.0 * expected).powi(2);
        }
    }
    (sum, 3 * trees.len())
}

/// A larger `depth` or `to` makes more of the tree visible.
#[test]
fn two_ways_out_show_nearly_the_whole_tree() {
    let glass = "color #2f7f86\nfrom 0.06\nto 0.9\nexponent 4\nindex 1.5\ndepth 6";
    let jelly = "color #7d1024\nfrom 0.02\nto 0.5\nexponent 3\nindex 1.33\ndepth 0.9";
    let clear = "color #ffffff\nfrom 0.04\nto 1\nexponent 5\nindex 1.5\ndepth 64";
    let meshes = [BuiltinMesh::Sphere, BuiltinMesh::Torus, BuiltinMesh::Knob, BuiltinMesh::Ball];
    for (parameters, most) in [(glass, 3.5), (jelly, 1.8), (clear, 4.4)] {
        let (mut sum, mut pixels) = (0.0, 0);
        for mesh in meshes {
            let (squared, own) = error(mesh, parameters);
            let rms = (squared / own as f64).sqrt();
            println!("{mesh:?}: {rms:.2} codes");
            assert!(rms < 1.3 * most, "{mesh:?}: {rms:.2} codes apart");
            (sum, pixels) = (sum + squared, pixels + own);
        }
        let rms = (sum / pixels as f64).sqrt();
        println!("all: {rms:.2} codes");
        assert!(rms < most, "{rms:.2} codes apart");
    }
}
