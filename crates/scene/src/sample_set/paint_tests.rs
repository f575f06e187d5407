//! Points of painted materials: columns, gradients, shadows, and parts of pictures.

use brood_brdf::{Input, LightInput, Lighting};
use brood_light::LightAssets;
use brood_mesh::{BuiltinMesh, Mesh};

use super::{PixelArea, Raster, SampleSet, Sampling};
use crate::Scene;

fn scene(json: &str) -> Scene {
    serde_json::from_str(json).unwrap()
}

fn points(mesh: BuiltinMesh, scene: &Scene, size_px: u32, sampling: Sampling) -> SampleSet {
    let raster = Raster { size_px: size_px.into(), sampling, area: PixelArea::whole(size_px) };
    SampleSet::render_points(&Mesh::builtin(mesh), scene, &LightAssets::default(), raster)
}

const TWO_LIGHTS: &str = r#"{"lights": [
    {"kind": "directional", "direction": [0, 0, 1], "irradiance_w_m2": [2, 1, 0.5]},
    {"kind": "directional", "direction": [0, 1, -0.2], "irradiance_w_m2": 0.5}]}"#;

#[test]
fn every_covered_pixel_has_a_point_whether_lit_or_not() {
    let scene = scene(r#"{"lights": [{"kind": "directional", "direction": [0, 0, 1]}]}"#);
    let set = points(BuiltinMesh::Sphere, &scene, 32, Sampling::Adaptive);
    assert_eq!(set.lighting(), Some(Lighting { lights: 1, has_shadows: false }));
    let image = set.image().unwrap();
    let pixels: Vec<u32> = image.spans().map(|span| span.pixel).collect();
    let covered = image.coverage.iter().filter(|coverage| **coverage > 0.0).count();
    assert_eq!(pixels.len(), covered);
    // The shares of each pixel's points are its coverage.
    for span in image.spans() {
        let shares = &set.irradiance()[0][span.radiance_start as usize..span.end as usize];
        let sum: f32 = shares.iter().sum();
        assert!((sum - image.coverage[span.pixel as usize]).abs() < 1e-5);
    }
    let away = set.input(Input::Light0Cos).iter().filter(|cosine| **cosine < 0.0).count();
    assert!(away > set.len() * 9 / 10, "{away} of {}", set.len());
}

#[test]
fn columns_are_those_of_a_sphere() {
    let scene = scene(TWO_LIGHTS);
    let set = points(BuiltinMesh::Sphere, &scene, 33, Sampling::Fixed(1));
    let image = set.image().unwrap();
    let centre = image.spans().find(|span| span.pixel == 16 * 33 + 16).unwrap().start as usize;
    let value = |input: Input| set.input(input)[centre];
    let near = |input: Input, expected: f32| {
        assert!((value(input) - expected).abs() < 0.02, "{input:?}: {}", value(input));
    };
    near(Input::NormalDotEye, 1.0);
    near(Input::Depth, 0.0);
    near(Input::Light0Visibility, 1.0);
    // Colours are relative to the largest channel of all lights.
    near(Input::Light0Red, 1.0);
    near(Input::Light0Green, 0.5);
    near(Input::Light0Blue, 0.25);
    near(Input::Light0Level, 1.0);
    near(Input::Light1Level, 0.25);
    let depths = set.input(Input::Depth);
    assert!(depths.iter().all(|depth| (-0.01..=0.6).contains(depth)));
}

#[test]
fn gradients_are_differences_of_neighbours() {
    let scene = scene(r#"{"lights": [{"kind": "directional", "direction": [0, 0, 1]}]}"#);
    let size = 65;
    let set = points(BuiltinMesh::Sphere, &scene, size, Sampling::Fixed(1));
    let image = set.image().unwrap();
    let mut sample = vec![None; (size * size) as usize];
    image.spans().for_each(|span| sample[span.pixel as usize] = Some(span.start as usize));
    for (value, gradient) in [
        (Input::Light0Cos, Input::Light0CosStep),
        (Input::NormalDotEye, Input::NormalDotEyeStep),
        (Input::Light0Mirror, Input::Light0MirrorStep),
        (Input::Depth, Input::DepthStep),
    ] {
        // In the middle of the upper right quarter of the sphere.
        let (x, y) = (42, 22);
        let at = |x: u32, y: u32| {
            set.input(value)[sample[(y * size + x) as usize].expect("the pixel is covered")]
        };
        let difference = [0.5 * (at(x + 1, y) - at(x - 1, y)), 0.5 * (at(x, y + 1) - at(x, y - 1))];
        let expected = difference[0].hypot(difference[1]);
        let found = set.input(gradient)[sample[(y * size + x) as usize].unwrap()];
        assert!((found / expected - 1.0).abs() < 0.2, "{value:?}: {found} {expected}");
    }
    let finer = points(BuiltinMesh::Sphere, &scene, size, Sampling::Fixed(16));
    let mean = |set: &SampleSet| {
        let steps = set.input(Input::Light0CosStep);
        steps.iter().sum::<f32>() / steps.len() as f32
    };
    let ratio = mean(&finer) / mean(&set);
    assert!((ratio - 0.25).abs() < 0.06, "samples are a quarter of a pixel apart: {ratio}");
}

#[test]
fn shadows_are_columns_only_where_the_scene_has_them() {
    let mut scene = scene(r#"{"lights": [{"kind": "directional", "direction": [1, -1.2, -1.3]}]}"#);
    scene.shadows = true;
    let set = points(BuiltinMesh::Knob, &scene, 64, Sampling::Adaptive);
    assert!(set.lighting().unwrap().has_shadows);
    let visibility = set.input(Input::Light0Visibility);
    let dark = visibility.iter().filter(|visibility| **visibility < 0.5).count();
    assert!(dark > 20 && dark < set.len() / 2, "{dark} of {}", set.len());
    let cosines = set.input(Input::Light0Cos);
    let turned = visibility.iter().zip(cosines).filter(|(_, cosine)| **cosine <= 0.0);
    assert!(turned.clone().count() > 20);
    assert!(turned.into_iter().all(|(visibility, _)| *visibility > 0.99), "no ray is needed");
}

#[test]
fn parts_of_pictures_have_the_bits_of_the_whole() {
    let (scene, mesh) = (scene(TWO_LIGHTS), Mesh::builtin(BuiltinMesh::Knob));
    let assets = LightAssets::default();
    for sampling in [Sampling::Adaptive, Sampling::Fixed(4)] {
        let raster = |area| Raster { size_px: 40.into(), sampling, area };
        let whole = SampleSet::render_points(&mesh, &scene, &assets, raster(PixelArea::whole(40)));
        let area = PixelArea { x: 11, y: 7, width: 13, height: 20 };
        let part = SampleSet::render_points(&mesh, &scene, &assets, raster(area));
        let (of_whole, of_part) = (whole.image().unwrap(), part.image().unwrap());
        for span in of_part.spans() {
            let (x, y) = (area.x + span.pixel % area.width, area.y + span.pixel / area.width);
            let same = of_whole.spans().find(|other| other.pixel == y * 40 + x).unwrap();
            assert_eq!(same.end - same.start, span.end - span.start);
            for input in [Input::NormalDotEye, Input::Light1Mirror, Input::Light0CosStep] {
                let values = |set: &SampleSet, start: u32, end: u32| {
                    set.input(input)[start as usize..end as usize].to_vec()
                };
                assert_eq!(
                    values(&part, span.start, span.end),
                    values(&whole, same.start, same.end)
                );
            }
        }
    }
}

#[test]
fn lights_of_every_kind_are_columns() {
    let kinds = [
        r#""point""#,
        r#""spot""#,
        r#""sphere""#,
        r#""disk""#,
        r#""rectangle""#,
        r#""ambient""#,
        r#""environment", "image": "overcast""#,
    ];
    for kind in kinds {
        let json = format!(r#"{{"lights": [{{"kind": {kind}}}]}}"#);
        let Ok(mut scene) = serde_json::from_str::<Scene>(&json) else {
            panic!("{kind} is a light");
        };
        for shadows in [false, true] {
            scene.shadows = shadows;
            let set = points(BuiltinMesh::Sphere, &scene, 16, Sampling::Adaptive);
            for quantity in LightInput::ALL {
                let column = set.input(Input::of_light(0, quantity));
                let low = if matches!(quantity, LightInput::Cos | LightInput::Mirror) {
                    -1.0
                } else {
                    0.0
                };
                assert!(
                    column.iter().all(|value| (low..=1.0).contains(value)),
                    "{kind} {quantity:?}"
                );
            }
            assert!(set.input(Input::Light0Level).iter().any(|level| *level > 0.1), "{kind}");
        }
    }
}

#[test]
fn copy_with_columns_differs_in_them_alone() {
    let set = points(BuiltinMesh::Knob, &scene(TWO_LIGHTS), 24, Sampling::Adaptive);
    let values: Vec<f32> = (0..set.len()).map(|index| index as f32 / 64.0).collect();
    let depths = set.input(Input::Depth).to_vec();
    let copy = set.with_columns([(Input::Depth, values.clone())]);
    assert_eq!(copy.input(Input::Depth), values);
    assert_eq!(copy.input_range(Input::Depth), (0.0, (set.len() - 1) as f32 / 64.0));
    assert_eq!(set.input(Input::Depth), depths);
    assert_ne!(copy.id(), set.id());
    assert_eq!((copy.len(), copy.image()), (set.len(), set.image()));
    assert_eq!((copy.lighting(), copy.counts()), (set.lighting(), set.counts()));
    for input in Input::ALL.into_iter().filter(|input| *input != Input::Depth) {
        assert_eq!(copy.input(input), set.input(input), "{input:?}");
    }
}
