//! Tests of ray ends against the samples of pictures.

use brood_brdf::Input;
use brood_mesh::{BuiltinMesh, Mesh};

use super::*;
use crate::Seen;

const SIDE: u32 = 48;

fn scene(json: &str) -> Scene {
    let scene: Scene = serde_json::from_str(json).unwrap();
    scene.validate().unwrap();
    scene
}

const AMONG: &str = r#"{"mesh": "torus", "rotation_deg": [50, 20, 0], "ground": {},
    "objects": [{"mesh": "ball", "position": [1.2, 0.1, -0.9], "scale": 0.7}]}"#;

/// Meshes of the objects of [`AMONG`], then of its ground.
fn among() -> [Mesh; 3] {
    [BuiltinMesh::Torus, BuiltinMesh::Ball, BuiltinMesh::Ground].map(Mesh::builtin)
}

/// Points of the subject in a picture with a sample a pixel.
fn points_of(scene: &Scene, stage: &Stage<'_>) -> SampleSet {
    let (size_px, area) = (SIDE.into(), PixelArea::whole(SIDE));
    let raster = Raster { size_px, sampling: Sampling::Fixed(1), area };
    SampleSet::render_clear_points(stage.clone(), scene, &LightAssets::default(), raster)
}

/// Every ray has an end; the ends of a part are those of the samples that its rays see.
#[test]
fn ends_are_the_points_that_rays_see() {
    let scene = scene(AMONG);
    let meshes = among();
    let stage = Stage::new(&scene, &meshes[0], &[&meshes[1], &meshes[2]]);
    let ends = RayEnds::trace((&scene, 1.5), stage.clone(), SIDE);
    assert_eq!(ends.parts().len(), 4, "three parts, and what is behind");
    let seen: Vec<usize> = ends.parts().iter().map(Vec::len).collect();
    assert!(seen[1..].iter().all(|seen| *seen > 20), "all others are seen: {seen:?}");
    let (size_px, assets) = (PictureSize::from(SIDE), LightAssets::default());
    let points = points_of(&scene, &stage);
    let mirrored: Vec<LeavingRay> =
        points.mirrored_ways(&stage, 1.5).iter().map(|way| way.leaving).collect();
    let image = points.image().unwrap();
    for part in 0..3 {
        let own = stage.with_part(part);
        let rays = (size_px, &mirrored[..]);
        let seen = SampleSet::of_rays((&own, 0), (&scene, &assets), rays, Seen::Points);
        let depths = seen.input(Input::Depth);
        let mut next = 0;
        for (span, covered) in image.spans().zip(seen.image().unwrap().coverage.iter()) {
            let end = ends.pixels()[span.pixel as usize].ends[0].unwrap();
            assert_eq!(end.0 == part, *covered > 0.0, "pixel {}", span.pixel);
            if end.0 != part {
                continue;
            }
            let found = ends.parts()[part][end.1];
            assert_eq!(found.own[1].to_bits(), depths[next].to_bits());
            assert!(found.n.dot(found.u).abs() < 1e-5 && found.n.is_normalized());
            next += 1;
        }
        // Rays that meet the body again pass through it.
        assert!(part == 0 || next > 3, "{next} of part {part}");
    }
}

/// Ends lie on their rays, and `eye` is the direction against the ray.
#[test]
fn ends_are_on_their_rays() {
    let scene = scene(AMONG);
    let meshes = among();
    let stage = Stage::new(&scene, &meshes[0], &[&meshes[1], &meshes[2]]);
    let ends = RayEnds::trace((&scene, 1.33), stage.clone(), SIDE);
    let points = points_of(&scene, &stage);
    let ways = points.ways_out(&stage, 1.33);
    let mut tested = [0; 3];
    for (span, ways) in points.image().unwrap().spans().zip(&ways) {
        let pixel = &ends.pixels()[span.pixel as usize];
        for (at, way) in ways.iter().enumerate() {
            assert_eq!(pixel.ends[1 + at].is_some(), way.is_some());
            let (Some(way), Some((part, number))) = (way, pixel.ends[1 + at]) else { continue };
            if part == 3 {
                continue;
            }
            let end = ends.parts()[part][number];
            let ray = way.leaving.ray;
            let from = end.position.as_dvec3() - ray.origin;
            let aside = from.cross(ray.direction).length() / from.length().max(1.0);
            assert!(aside < 1e-5 && from.dot(ray.direction) > 0.0, "part {part}: {aside}");
            let across = end.n.cross(end.u);
            let up = (1.0 - end.eye.length_squared()).max(0.0).sqrt();
            let eye = end.eye.x * end.u + end.eye.y * across + up * end.n;
            assert!(eye.as_dvec3().dot(-ray.direction) > 1.0 - 1e-4, "part {part}");
            tested[part] += 1;
        }
    }
    assert!(tested[1..].iter().all(|tested| *tested > 10), "{tested:?}");
}

/// Where nothing enters a thin body, its first way is the mirrored ray.
#[test]
fn thin_bodies_show_their_mirror_at_the_limb() {
    let (scene, mesh) = (Scene::default(), Mesh::builtin(BuiltinMesh::Sphere));
    let ends = RayEnds::trace((&scene, 0.67), &mesh, SIDE);
    let covered = ends.pixels().iter().filter(|pixel| pixel.ends[0].is_some());
    let limb = covered.clone().filter(|pixel| pixel.ends[0] == pixel.ends[1]).count();
    assert!(limb > 100 && limb < covered.count(), "{limb}");
    assert!(ends.pixels().iter().all(|pixel| pixel.ends[2].is_none_or(|_| pixel.share < 1.0)));
}

/// Pixels whose middle misses the body have the rays of one beside it, as lit angles.
#[test]
fn pixels_beside_the_body_have_rays() {
    let (scene, mesh) = (Scene::default(), Mesh::builtin(BuiltinMesh::Knob));
    let ends = RayEnds::trace((&scene, 1.5), &mesh, SIDE);
    let set = points_of(&scene, &(&mesh).into());
    let covered: Vec<bool> =
        set.image().unwrap().coverage.iter().map(|covered| *covered > 0.0).collect();
    let has_rays = |at: usize| ends.pixels()[at].ends[0].is_some();
    let side = SIDE as usize;
    for at in (0..covered.len()).filter(|at| covered[*at]) {
        assert!(has_rays(at), "{at}");
    }
    let beside: Vec<usize> = (1..covered.len() - 1)
        .filter(|at| at % side > 0 && at % side < side - 1 && !covered[*at])
        .filter(|at| covered[at - 1] || covered[at + 1])
        .collect();
    assert!(beside.len() > 40 && beside.iter().all(|at| has_rays(*at)), "{}", beside.len());
}

/// Lights reach the ends of mirrored rays at their angles as they do in pictures.
#[test]
fn lights_reach_ends_at_their_angles() {
    let scene = scene(&AMONG.replace("\"ground\"", "\"shadows\": true, \"ground\""));
    let meshes = among();
    let stage = Stage::new(&scene, &meshes[0], &[&meshes[1], &meshes[2]]);
    let subject = |share: f64| stage.with_clear(&[share, 0.0, 0.0]);
    let ends = RayEnds::trace((&scene, 1.5), subject(0.5), SIDE);
    assert_eq!(ends.angles().len(), 2, "one light, both kinds");
    let (size_px, assets) = (PictureSize::from(SIDE), LightAssets::default());
    let points = points_of(&scene, &stage);
    let rays: Vec<LeavingRay> =
        points.mirrored_ways(&stage, 1.5).iter().map(|way| way.leaving).collect();
    let first: Vec<(usize, usize)> = points
        .image()
        .unwrap()
        .spans()
        .map(|span| ends.pixels()[span.pixel as usize].ends[0].unwrap())
        .collect();
    let lit_rays = |scene: &Scene, stage: &Stage<'_>, part: usize| -> Vec<bool> {
        let (own, light) = (stage.with_part(part), Seen::Light(None));
        let set = SampleSet::of_rays((&own, 0), (scene, &assets), (size_px, &rays), light);
        let mut lit = vec![false; rays.len()];
        set.image().unwrap().spans().for_each(|span| lit[span.pixel as usize] = true);
        lit
    };
    let (mut faced, mut differ, mut shadowed) = (0, 0, [0; 2]);
    for angle in (57..65_000u16).step_by(4000) {
        let seen = scene.with_light_deg(LitAngles::degrees(angle));
        let plain = Scene { shadows: false, ..seen.clone() };
        for part in 1..3 {
            let faces = lit_rays(&plain, &stage, part);
            for (kind, stage) in [&stage, &subject(1.0)].into_iter().enumerate() {
                let reached = lit_rays(&seen, stage, part);
                for (ray, (own, number)) in first.iter().enumerate() {
                    if *own != part || !faces[ray] {
                        continue;
                    }
                    let toggles = &ends.angles()[kind][part][*number];
                    faced += 1;
                    shadowed[kind] += u32::from(!reached[ray]);
                    differ += u32::from(reached[ray] != LitAngles::is_lit(toggles, angle));
                }
            }
        }
    }
    assert!(shadowed[0] > shadowed[1] && shadowed[1] > 0, "{shadowed:?} of {faced}");
    assert!(differ * 2000 <= faced, "{differ} of {faced} differ");
}

/// A ray that meets two parts at once has one end, and every end has angles.
#[test]
fn coinciding_faces_have_one_end() {
    let scene = scene(
        r#"{"mesh": "ball", "shadows": true, "ground": {}, "objects": [
            {"mesh": "cube", "position": [1.3, 0, 0], "scale": 0.5},
            {"mesh": "cube", "position": [1.3, 0, 0.3], "scale": 0.5}]}"#,
    );
    let meshes = [BuiltinMesh::Ball, BuiltinMesh::Cube, BuiltinMesh::Ground].map(Mesh::builtin);
    let stage = Stage::new(&scene, &meshes[0], &[&meshes[1], &meshes[1], &meshes[2]]);
    let ends = RayEnds::trace((&scene, 1.5), stage.with_clear(&[0.5, 0.0, 0.0, 0.0]), SIDE);
    let counts: Vec<usize> = ends.parts().iter().map(Vec::len).collect();
    assert!(counts[1] > 0 && counts[2] > 0, "both cubes are seen: {counts:?}");
    for set in ends.angles() {
        assert_eq!(set.iter().map(Vec::len).collect::<Vec<_>>(), counts);
    }
}
