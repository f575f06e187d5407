//! Tests of adaptive sampling, areas and picks.

use std::f64::consts::PI;

use brood_brdf::{Input, InputMask};
use brood_light::{Light, LightAssets};
use brood_mesh::{BuiltinMesh, Mesh};

use super::{PictureSize, PixelArea, SampleSet, Sampling};
use crate::{Camera, OrthographicCamera, Scene};

/// Parallel projection, in which the sphere is a disc of radius 0.8 half sides of the picture.
fn disc() -> Scene {
    Scene {
        camera: Camera::Orthographic(OrthographicCamera { orthographic: 1.25 }),
        ..Scene::default()
    }
}

/// Returns red irradiance times cosine of each pixel: the picture of a Lambertian surface.
fn received(set: &SampleSet) -> Vec<f64> {
    let layout = set.image().unwrap();
    let mut pixels = vec![0.0; layout.coverage.len()];
    for span in layout.spans() {
        let samples = span.radiance_start as usize..span.end as usize;
        let sum: f64 = set.irradiance()[0][samples].iter().map(|e| f64::from(*e)).sum();
        pixels[span.pixel as usize] = sum * f64::from(layout.scale);
    }
    pixels
}

fn rmse(a: &[f64], b: &[f64]) -> f64 {
    let sum: f64 = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum();
    (sum / a.len() as f64).sqrt()
}

#[test]
fn coverage_of_sphere_is_area_of_its_disc() {
    let mesh = Mesh::builtin(BuiltinMesh::Sphere);
    for size_px in [31, 64, 200] {
        let covered = |sampling: Sampling| {
            let set = SampleSet::render(&mesh, &disc(), size_px, sampling);
            let layout = set.image().unwrap();
            layout.coverage.iter().map(|share| f64::from(*share)).sum::<f64>()
        };
        let radius = 0.4 * f64::from(size_px);
        // The mesh's outline is a polygon of 192 sides; its area relative to the circle is
        // sin(t) / t.
        let corners = 2.0 * PI / 192.0;
        let area = PI * radius * radius * corners.sin() / corners;
        let off = (covered(Sampling::Adaptive) - area).abs();
        // The rest depends on the orientation of the outline's corners to the view.
        assert!(off < 1e-4 * area, "{size_px}: error {off} of area {area}");
        let plain = (covered(Sampling::Fixed(1)) - area).abs();
        assert!(off < plain, "{size_px}: {off} {plain}");
    }
}

#[test]
fn adaptive_error_is_below_half_of_sixteen_fixed_rays() {
    let mut scene = Scene::default();
    scene.lights.push(Light::point_at([-4.0, 1.0, 2.0]));
    for name in BuiltinMesh::ALL {
        let mesh = Mesh::builtin(name);
        let picture =
            |sampling: Sampling| received(&SampleSet::render(&mesh, &scene, 40, sampling));
        let many = picture(Sampling::Fixed(512));
        let own = rmse(&picture(Sampling::Adaptive), &many);
        let sixteen = rmse(&picture(Sampling::Fixed(16)), &many);
        assert!(own < 0.5 * sixteen, "{}: {own} {sixteen}", name.name());
    }
}

#[test]
fn adaptive_centres_equal_single_ray_set() {
    let mut scene = Scene::default();
    scene.lights.push(Light::point_at([-4.0, 1.0, 2.0]));
    let mesh = Mesh::builtin(BuiltinMesh::Knob);
    let (one, own) = (
        SampleSet::render(&mesh, &scene, 50, 1),
        SampleSet::render(&mesh, &scene, 50, Sampling::Adaptive),
    );
    let centres = |set: &SampleSet| -> Vec<_> {
        let spans = set.image().unwrap().spans().filter(|span| span.centre_end > span.start);
        let samples = |span: super::PixelSpan| {
            (span.start as usize..span.centre_end as usize).map(move |at| (span.pixel, at))
        };
        spans.flat_map(samples).map(|(pixel, at)| (pixel, set.pair(at))).collect()
    };
    assert_eq!(centres(&one), centres(&own));
    // Nearly all pixels of such a small picture are edges; at most six groups per light bound the
    // cost.
    assert!(own.len() < 5 * one.len(), "{} {}", own.len(), one.len());
}

#[test]
fn area_is_bit_identical_to_part_of_whole_picture() {
    let scene = Scene { rotation_deg: [10.0, 20.0, 30.0], ..Scene::default() };
    let mesh = Mesh::builtin(BuiltinMesh::Knob);
    for sampling in [Sampling::Adaptive, Sampling::Fixed(1), Sampling::Fixed(5)] {
        let whole = SampleSet::render(&mesh, &scene, 48, sampling);
        for area in ["0,0,48,48", "13,9,20,17", "0,20,48,1", "47,47,1,1", "24,0,1,48"] {
            let area: PixelArea = area.parse().unwrap();
            let part = SampleSet::render_area(&mesh, &scene, 48, sampling, area);
            let numbers: Vec<u32> = (area.y..area.y + area.height)
                .flat_map(|y| (area.x..area.x + area.width).map(move |x| y * 48 + x))
                .collect();
            let mask: InputMask = [Input::P1, Input::U].into_iter().collect();
            let picked = SampleSet::pick(&[(&whole, &numbers)], mask, false);
            assert_eq!(part.len(), picked.len(), "{area} {sampling}");
            assert_eq!(part.irradiance(), picked.irradiance(), "{area} {sampling}");
            let (own, other) = (part.image().unwrap(), picked.image().unwrap());
            assert!(own.spans().eq(other.spans()), "{area} {sampling}");
            assert_eq!(own.coverage, other.coverage, "{area} {sampling}");
            for input in [Input::P1, Input::U] {
                assert_eq!(part.input(input), picked.input(input), "{area} {sampling}");
                assert_eq!(picked.input_range(input), whole.input_range(input));
            }
        }
    }
}

#[test]
fn pick_concatenates_pixels_of_several_sets() {
    let mesh = Mesh::builtin(BuiltinMesh::Sphere);
    let tile = |area: &str| {
        let area = area.parse().unwrap();
        SampleSet::render_area(&mesh, &Scene::default(), 32, Sampling::Fixed(3), area)
    };
    let (left, right) = (tile("8,8,8,16"), tile("16,8,8,16"));
    // The first pixel has no hit.
    let (of_left, of_right) = ([0, 41, 42, 90], [3, 60]);
    let mask: InputMask = [Input::P1].into_iter().collect();
    let picked = SampleSet::pick(&[(&left, &of_left), (&right, &of_right)], mask, true);
    let each = of_left.map(|pixel| (&left, pixel)).into_iter();
    let each = each.chain(of_right.map(|pixel| (&right, pixel)));
    let samples = |set: &SampleSet, pixel: u32| -> Vec<f32> {
        let span = set.image().unwrap().spans().find(|span| span.pixel == pixel);
        let range = span.map_or(0..0, |span| span.start as usize..span.end as usize);
        set.input(Input::P1)[range].to_vec()
    };
    let expected: Vec<Vec<f32>> = each.map(|(set, pixel)| samples(set, pixel)).collect();
    let found: Vec<Vec<f32>> = (0..6).map(|pixel| samples(&picked, pixel)).collect();
    assert_eq!(found, expected);
    assert!(expected.iter().filter(|samples| samples.len() == 3).count() >= 3, "{expected:?}");
    assert_eq!(picked.len(), expected.iter().map(Vec::len).sum::<usize>());
}

#[test]
#[should_panic(expected = "was not picked")]
fn input_panics_when_it_was_not_picked() {
    let set = SampleSet::render(
        &Mesh::builtin(BuiltinMesh::Sphere),
        &Scene::default(),
        16,
        Sampling::Fixed(1),
    );
    let _ = SampleSet::pick(&[(&set, &[120])], InputMask::default(), false).input(Input::P1);
}

#[test]
fn adaptive_set_is_bit_identical_for_any_number_of_threads() {
    let make = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mesh = Mesh::builtin(BuiltinMesh::Torus);
        pool.install(|| SampleSet::render(&mesh, &Scene::default(), 64, Sampling::Adaptive))
    };
    let (one, four) = (make(1), make(4));
    assert_eq!(one.image(), four.image());
    assert_eq!((one.pairs, one.uvs), (four.pairs, four.uvs));
    assert_eq!(one.irradiance, four.irradiance);
}

#[test]
fn listed_pixels_equal_those_of_the_whole_picture() {
    let (mesh, scene) = (Mesh::builtin(BuiltinMesh::Knob), Scene::default());
    let size_px = PictureSize { width: 40, height: 24 };
    let whole = SampleSet::render(&mesh, &scene, size_px, Sampling::Fixed(5));
    // More pixels than a thread samples at a time, in any order, with and without hits.
    let pixels: Vec<(u32, u32)> = (0..60).map(|k| (k * 7 % 40, k * 5 % 24)).collect();
    let assets = LightAssets::default();
    let listed = SampleSet::render_pixels(&mesh, &scene, &assets, (size_px, 5), &pixels, None);
    let samples = |set: &SampleSet, pixel: u32| -> Vec<(f32, f32)> {
        let span = set.image().unwrap().spans().find(|span| span.pixel == pixel);
        let range = span.map_or(0..0, |span| span.start as usize..span.end as usize);
        range.map(|sample| (set.input(Input::P1)[sample], set.irradiance()[0][sample])).collect()
    };
    let coverage = |set: &SampleSet, pixel: u32| set.image().unwrap().coverage[pixel as usize];
    let mut hits = 0;
    for (index, (x, y)) in (0..).zip(pixels) {
        let pixel = y * size_px.width + x;
        assert_eq!(samples(&listed, index), samples(&whole, pixel), "{x}, {y}");
        assert_eq!(coverage(&listed, index), coverage(&whole, pixel), "{x}, {y}");
        hits += usize::from(coverage(&listed, index) > 0.0);
    }
    assert!(hits > 10 && hits < 60, "{hits}");
}
