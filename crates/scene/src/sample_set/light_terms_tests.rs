//! Tests of light as sums over shared pairs of directions.

use brood_brdf::{Brdf, Model, ModelKind};
use brood_light::LightAssets;
use brood_mesh::{BuiltinMesh, Mesh};
use glam::DVec3;

use super::{LightTerms, PictureSize, Sampling};
use crate::{SampleSet, Scene};

const SIZE_PX: PictureSize = PictureSize { width: 40, height: 40 };

fn scene(lights: &str) -> Scene {
    serde_json::from_str(&format!(r#"{{"lights": [{lights}]}}"#)).unwrap()
}

fn ggx(roughness: f64) -> Box<dyn Brdf> {
    let model = Model::new(ModelKind::Conductor).with("roughness", &[roughness]);
    model.expect("a conductor has a roughness").brdf()
}

fn lambert() -> Box<dyn Brdf> {
    Model::new(ModelKind::Lambert).brdf()
}

/// Pixels of the middle of the picture.
fn pixels() -> Vec<(u32, u32)> {
    let side = (6..34).step_by(3);
    side.clone().flat_map(|y| side.clone().map(move |x| (x, y))).collect()
}

/// Radiance of each pixel by its terms; `None` of pixels without light.
fn by_terms(mesh: &Mesh, scene: &Scene, brdf: &dyn Brdf, parts: u32) -> Vec<Option<DVec3>> {
    let assets = LightAssets::default();
    let found = LightTerms::render(mesh, scene, &assets, SIZE_PX, &pixels(), parts);
    let f: Vec<DVec3> = found.pairs.iter().map(|pair| brdf.f(pair)).collect();
    let radiance = |terms: &Vec<(u32, [f32; 3])>| {
        let each = terms.iter().map(|(at, e)| f[*at as usize] * DVec3::from(e.map(f64::from)));
        (!terms.is_empty()).then(|| each.sum())
    };
    found.pixels.iter().map(|pixel| radiance(&pixel.terms)).collect()
}

/// Radiance of each pixel by many samples of the lights.
fn by_samples(mesh: &Mesh, scene: &Scene, brdf: &dyn Brdf) -> Vec<DVec3> {
    let Sampling::Fixed(rays) = Sampling::from(32) else { unreachable!() };
    let picture = (SIZE_PX, rays);
    let assets = LightAssets::default();
    let set = SampleSet::render_pixels(mesh, scene, &assets, picture, &pixels(), None);
    let layout = set.image().unwrap();
    let mut radiance = vec![DVec3::ZERO; pixels().len()];
    for span in layout.spans() {
        for at in span.start as usize..span.end as usize {
            let e = DVec3::from(set.irradiance().map(|channel| f64::from(channel[at])));
            radiance[span.pixel as usize] += f64::from(layout.scale) * e * brdf.f(&set.pair(at).0);
        }
    }
    // Pixels at the outline are left out.
    for (radiance, coverage) in radiance.iter_mut().zip(layout.coverage.iter()) {
        if *coverage < 1.0 {
            *radiance = DVec3::ZERO;
        }
    }
    radiance
}

/// Difference of the light at the centres of pixels.
fn difference(mesh: BuiltinMesh, scene: &Scene, brdf: &dyn Brdf) -> f64 {
    difference_within(mesh, scene, brdf, 1)
}

/// Root mean square difference over the pixels that both show, as a share of the brightest.
fn difference_within(mesh: BuiltinMesh, scene: &Scene, brdf: &dyn Brdf, parts: u32) -> f64 {
    let mesh = Mesh::builtin(mesh);
    let (found, wanted) = (by_terms(&mesh, scene, brdf, parts), by_samples(&mesh, scene, brdf));
    let both = found.iter().zip(&wanted).filter_map(|(found, wanted)| Some(((*found)?, *wanted)));
    let both: Vec<(DVec3, DVec3)> = both.filter(|(_, wanted)| *wanted != DVec3::ZERO).collect();
    assert!(both.len() > 40, "{}", both.len());
    let most = both.iter().fold(0.0f64, |most, (_, wanted)| most.max(wanted.max_element()));
    let squares = both.iter().map(|(found, wanted)| (*found - *wanted).length_squared() / 3.0);
    (squares.sum::<f64>() / both.len() as f64).sqrt() / most
}

#[test]
fn terms_of_environments_match_many_samples() {
    for image in ["studio", "low-sun"] {
        let scene =
            scene(&format!(r#"{{"kind": "environment", "image": "{image}", "samples": 1024}}"#));
        for (name, brdf, most) in
            [("lambert", lambert(), 0.004), ("ggx .4", ggx(0.4), 0.012), ("ggx .1", ggx(0.1), 0.01)]
        {
            let off = difference(BuiltinMesh::Sphere, &scene, &*brdf);
            assert!(off < most, "{image} {name} {off}");
        }
    }
}

#[test]
fn terms_have_the_shadows_of_environments() {
    let light = |shadows: bool| {
        let environment = format!(
            r#"{{"kind": "environment", "image": "studio", "samples": 512, "shadows": {shadows}}}"#
        );
        Scene { shadows: true, ..scene(&environment) }
    };
    for brdf in [lambert(), ggx(0.3)] {
        let off = difference(BuiltinMesh::Torus, &light(true), &*brdf);
        let open = difference(BuiltinMesh::Torus, &light(false), &*brdf);
        assert!(off < 0.025 && open < 0.02, "{off} {open}");
    }
}

#[test]
fn terms_of_lamps_are_their_samples() {
    let lights = r#"{"kind": "point", "position": [2, 3, 4]},
        {"kind": "sphere", "position": [-3, 2, 3], "radius": 0.5, "samples": 4}"#;
    let off = difference(BuiltinMesh::Sphere, &scene(lights), &*ggx(0.3));
    assert!(off < 0.02, "{off}");
    let found = LightTerms::render(
        &Mesh::builtin(BuiltinMesh::Sphere),
        &scene(lights),
        &LightAssets::default(),
        SIZE_PX,
        &[(20, 20), (0, 0)],
        1,
    );
    assert_eq!(found.pixels[0].terms.len(), 1 + 64);
    assert!(found.pixels[1].terms.is_empty(), "the corner misses the sphere");
    let sum: f64 = found.pixels[0].terms.iter().map(|(_, e)| f64::from(e[0])).sum();
    assert!(sum < found.pixels[0].normal[0], "cosines are below 1");
}

#[test]
fn terms_within_pixels_have_highlights_narrower_than_a_pixel() {
    let lamp = scene(r#"{"kind": "point", "position": [2, 3, 4]}"#);
    let narrow = ggx(0.02);
    let within = |parts| difference_within(BuiltinMesh::Sphere, &lamp, &*narrow, parts);
    let (centre, spread) = (within(1), within(8));
    assert!(spread < 0.01 && centre > 10.0 * spread, "{centre} {spread}");
}
