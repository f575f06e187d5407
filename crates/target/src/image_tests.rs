//! Tests that rendered pictures are read back, and that unusable pictures are rejected.

use brood_brdf::{DirectionPair, Model, ModelKind};
use brood_eval::{LinearPicture, shade_brdf};
use brood_mesh::BuiltinMesh;
use brood_scene::{ClipFrom, PictureSize, Refine};

use super::*;

const SIDE_PX: u32 = 48;

fn scene(json: &str) -> Scene {
    serde_json::from_str(json).unwrap()
}

fn rendered(model: &Model, mesh: &Mesh, scene: &Scene, sampling: Sampling) -> RadianceImage {
    rendered_in(SIDE_PX.into(), model, mesh, scene, sampling)
}

fn rendered_in(
    size_px: PictureSize,
    model: &Model,
    mesh: &Mesh,
    scene: &Scene,
    sampling: Sampling,
) -> RadianceImage {
    let raster = Raster { size_px, sampling, area: PixelArea::whole(size_px) };
    let set = SampleSet::render_with_assets(mesh, scene, &LightAssets::default(), raster);
    shade_brdf(&set, &*model.brdf())
}

fn view<'a>(
    mesh: &'a Mesh,
    scene: &'a Scene,
    assets: &'a LightAssets,
    picture: &'a LinearPicture,
) -> View<'a> {
    let sampling = Sampling::Adaptive;
    let (mask, is_gain_unknown, clip_from) = (None, false, ClipFrom::Auto);
    let refine = Refine::default();
    View { mesh, scene, assets, sampling, picture, mask, is_gain_unknown, clip_from, refine }
}

#[test]
fn pixels_give_the_reflectance_of_the_rendered_model() {
    let model = Model::new(ModelKind::CookTorrance).with("diffuse", &[0.2, 0.1, 0.05]).unwrap();
    let model = model.with("roughness", &[0.35]).unwrap();
    let (mesh, assets) = (Mesh::builtin(BuiltinMesh::Sphere), LightAssets::default());
    for light in [r#"{"kind": "point", "position": [3, 3, 3]}"#, r#"{"kind": "directional"}"#] {
        let scene = scene(&format!(r#"{{"lights": [{light}], "light_deg": 20}}"#));
        let image = rendered(&model, &mesh, &scene, Sampling::Adaptive);
        let picture = LinearPicture::from(&image);
        let (view, samples) = ImageView::new(&view(&mesh, &scene, &assets, &picture)).unwrap();
        let counts = view.counts();
        let means = samples.means().samples();
        assert!(counts.used as usize == samples.len() + means && counts.used > 300, "{counts}");
        assert!(means > 50, "{means} pixels are in the highlight");
        let PixelCounts { masked, background, edge, clipped, unlit, .. } = counts;
        let PixelCounts { half_lit, several_lights, grazing, outlier, used, .. } = counts;
        let all = masked + background + edge + clipped + unlit + half_lit + several_lights;
        assert_eq!(outlier, 0, "{counts}");
        assert_eq!(all + grazing + used, u64::from(SIDE_PX * SIDE_PX), "{counts}");
        let brdf = model.brdf();
        for (pair, value) in samples.pairs().iter().zip(samples.values()) {
            let f = brdf.f(pair).to_array();
            assert!((0..3).all(|k| (value[k] - f[k]).abs() < 0.02 * f[k]), "{value:?} {f:?}");
        }
        assert_eq!(view.compare(&image), ImageError { rmse: 0.0, rmse_used: 0.0, gain: 1.0 });
    }
}

#[test]
fn pixels_of_wide_and_tall_pictures_are_those_of_the_square_one() {
    let model = Model::new(ModelKind::Lambert);
    let (mesh, assets) = (Mesh::builtin(BuiltinMesh::Knob), LightAssets::default());
    // From this distance the object lies within the middle of every size.
    let scene = scene(r#"{"camera": {"distance": 8, "fov_y_deg": 30}}"#);
    let counts = |width, height| {
        let size_px = PictureSize { width, height };
        let image = rendered_in(size_px, &model, &mesh, &scene, Sampling::Adaptive);
        let picture = LinearPicture::from(&image);
        let (view, samples) = ImageView::new(&view(&mesh, &scene, &assets, &picture)).unwrap();
        let lambert = 0.5 / std::f64::consts::PI;
        assert!(samples.values().iter().all(|f| (f[0] - lambert).abs() < 0.02 * lambert));
        assert_eq!(view.statuses().len() as u64, size_px.pixels());
        assert_eq!(view.compare(&image).rmse, 0.0);
        (view.counts().used, view.counts().edge)
    };
    let square = counts(64, 64);
    assert!(square.0 > 200, "{square:?}");
    assert_eq!(counts(96, 64), square);
    assert_eq!(counts(48, 64), square);
}

#[test]
fn unknown_brightness_is_compensated_by_a_gain() {
    let model = Model::new(ModelKind::Lambert);
    let (mesh, assets) = (Mesh::builtin(BuiltinMesh::Knob), LightAssets::default());
    let scene = scene(r#"{"shadows": true}"#);
    let image = rendered(&model, &mesh, &scene, Sampling::Adaptive);
    let mut picture = LinearPicture::from(&image);
    picture.pixels.iter_mut().for_each(|pixel| *pixel = pixel.map(|value| value * 0.25));
    let unknown = View { is_gain_unknown: true, ..view(&mesh, &scene, &assets, &picture) };
    let (view, _) = ImageView::new(&unknown).unwrap();
    assert!(view.counts().unlit > 0);
    let error = view.compare(&image);
    assert!((error.gain - 0.25).abs() < 1e-6 && error.rmse < 1e-6, "{error:?}");
}

#[test]
fn pixels_lit_by_several_lights_are_means() {
    let (mesh, assets) = (Mesh::builtin(BuiltinMesh::Sphere), LightAssets::default());
    let scene = scene(
        r#"{"lights": [{"kind": "directional", "direction": [1, 0, -0.2]}, {"kind": "directional", "direction": [-1, 0, -0.2]}]}"#,
    );
    let image = rendered(&Model::new(ModelKind::Lambert), &mesh, &scene, Sampling::Adaptive);
    let picture = LinearPicture::from(&image);
    let (view, samples) = ImageView::new(&view(&mesh, &scene, &assets, &picture)).unwrap();
    assert!(view.counts().several_lights > 50 && samples.len() > 200, "{}", view.counts());
    let lambert = 0.5 / std::f64::consts::PI;
    assert!(samples.values().iter().all(|f| (f[0] - lambert).abs() < 0.02 * lambert));
    let values = samples.means().values();
    let several = values.iter().filter(|value| value.centre.is_none()).count();
    assert_eq!(view.counts().several_lights, several as u64);
    let centres = samples.at_centres();
    assert_eq!(view.counts().used as usize, centres.len());
    matches_lambert(&samples, 0.02);
}

/// Asserts that the measured means are those of a Lambertian of albedo 0.5: the root mean square
/// of the relative difference.
fn matches_lambert(samples: &Samples, most: f64) {
    let f = vec![[0.5 / std::f64::consts::PI; 3]; samples.means().pairs().len()];
    let means = samples.means().of(&f);
    let both = means.iter().zip(samples.means().values());
    let squares = both.map(|(found, wanted)| (found[1] / wanted.mean[1] - 1.0).powi(2));
    let off = (squares.sum::<f64>() / means.len() as f64).sqrt();
    assert!(off < most, "{off}");
}

#[test]
fn pixels_under_lights_with_an_area_are_means() {
    let (mesh, assets) = (Mesh::builtin(BuiltinMesh::Sphere), LightAssets::default());
    for (light, most) in [
        // The picture has noise.
        (r#"{"kind": "environment", "image": "studio", "samples": 1024}"#, 0.08),
        (r#"{"kind": "ambient", "samples": 256}"#, 1e-5),
        (r#"{"kind": "sphere", "position": [3, 3, 3], "radius": 1, "samples": 256}"#, 2e-3),
    ] {
        let scene = scene(&format!(r#"{{"lights": [{light}]}}"#));
        let image = rendered(&Model::new(ModelKind::Lambert), &mesh, &scene, Sampling::Adaptive);
        let picture = LinearPicture::from(&image);
        let (own, samples) = ImageView::new(&view(&mesh, &scene, &assets, &picture)).unwrap();
        assert!(own.is_soft() && own.counts().used == 0, "{}", own.counts());
        assert!(own.counts().several_lights > 200 && samples.means().len() > 200);
        matches_lambert(&samples, most);
        let target = crate::MeasuredTarget::of_pixels(&samples).unwrap();
        let (fitted, held) = (target.fitted.observations(), target.held.observations());
        assert!(held > 40 && fitted > 3 * held, "{fitted} {held}");
        let refine = Refine { light_deg: 2.0, ..Refine::default() };
        let refined = View { refine, ..view(&mesh, &scene, &assets, &picture) };
        let error = ImageView::new(&refined).unwrap_err().to_string();
        assert!(error.contains("cannot be corrected yet"), "{error}");
    }
}

#[test]
fn highlights_narrower_than_a_pixel_are_means_over_it() {
    let model = Model::new(ModelKind::Conductor).with("roughness", &[0.02]).unwrap();
    let (mesh, assets) = (Mesh::builtin(BuiltinMesh::Sphere), LightAssets::default());
    let scene = scene(r#"{"lights": [{"kind": "point", "position": [3, 3, 3]}]}"#);
    // Largest difference, as a share of the largest value.
    let off = |values: &[[f64; 3]], of: &dyn Fn(usize) -> [f64; 3]| {
        let most = values.as_flattened().iter().fold(0.0f64, |most, f| most.max(*f));
        let error = |at: usize| (0..3).map(move |c| (of(at)[c] - values[at][c]).abs());
        (0..values.len()).flat_map(error).fold(0.0, f64::max) / most
    };
    let brdf = model.brdf();
    let f = |pair: &DirectionPair| brdf.f(pair).to_array();
    let image = rendered(&model, &mesh, &scene, Sampling::Fixed(4096));
    let picture = LinearPicture::from(&image);
    let given = View { sampling: Sampling::Fixed(64), ..view(&mesh, &scene, &assets, &picture) };
    let (_, samples) = ImageView::new(&given).unwrap();
    let means = samples.means();
    let of_pairs: Vec<[f64; 3]> = means.pairs().iter().map(f).collect();
    let (found, wanted) = (means.of(&of_pairs), means.values().iter().map(|value| value.mean));
    let wanted: Vec<[f64; 3]> = wanted.collect();
    let within = off(&wanted, &|at| found[at]);
    let centres = samples.at_centres();
    assert!(centres.means().is_empty() && centres.observations() == samples.observations());
    let centre = off(centres.values(), &|at| f(&centres.pairs()[at]));
    assert!(within < 0.01 && centre > 0.2, "{within} {centre}");
    // A picture of one ray per pixel shows the centres.
    let image = rendered(&model, &mesh, &scene, Sampling::Fixed(1));
    let picture = LinearPicture::from(&image);
    let given = View { sampling: Sampling::Fixed(1), ..view(&mesh, &scene, &assets, &picture) };
    assert!(ImageView::new(&given).unwrap().1.means().is_empty());
}

#[test]
fn dust_is_left_out_and_noise_and_small_highlights_are_not() {
    const SIDE_PX: u32 = 128;
    let assets = LightAssets::default();
    let scene = scene(r#"{"lights": [{"kind": "point", "position": [3, 3, 3]}]}"#);
    for (mesh, kind, roughness, sampling, least) in [
        (BuiltinMesh::Sphere, ModelKind::CookTorrance, 0.3, Sampling::Adaptive, 0.85),
        (BuiltinMesh::Knob, ModelKind::CookTorrance, 0.05, Sampling::Fixed(1), 0.55),
        (BuiltinMesh::Sphere, ModelKind::Conductor, 0.05, Sampling::Fixed(1), 0.85),
    ] {
        let mesh = Mesh::builtin(mesh);
        let model = Model::new(kind).with("roughness", &[roughness]).unwrap();
        let image = rendered_in(SIDE_PX.into(), &model, &mesh, &scene, sampling);
        let mut picture = LinearPicture::from(&image);
        let read = |picture: &LinearPicture| {
            let given = View { sampling, ..view(&mesh, &scene, &assets, picture) };
            ImageView::new(&given).unwrap().0
        };
        assert_eq!(read(&picture).counts().outlier, 0, "{kind} {roughness}");
        // Noise of 3 %, uniform.
        let mut state = 1u32;
        for value in picture.pixels.as_flattened_mut() {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            *value *= 1.0 + 0.03 * (2.0 * (state >> 8) as f32 / 16_777_216.0 - 1.0);
        }
        let clean = read(&picture);
        assert!(clean.counts().outlier <= 2, "{kind} {roughness}: {}", clean.counts());
        let is_used = |pixel: &usize| clean.statuses()[*pixel] == PixelStatus::Used;
        let used: Vec<usize> = (0..clean.statuses().len()).filter(is_used).collect();
        // Bright specks of a pixel and dark ones of 2 x 2.
        let mut dust = Vec::new();
        for (index, pixel) in used.iter().step_by(97).enumerate() {
            let below = pixel + SIDE_PX as usize;
            let (all, factor) = match index % 2 {
                0 => (vec![*pixel], 4.0),
                _ => (vec![*pixel, pixel + 1, below, below + 1], 0.2),
            };
            for pixel in all.into_iter().filter(is_used) {
                picture.pixels[pixel] = picture.pixels[pixel].map(|value| value * factor);
                dust.push(pixel);
            }
        }
        let found = read(&picture);
        let is_found = |pixel: &&usize| found.statuses()[**pixel] == PixelStatus::Outlier;
        let (count, left_out) = (dust.iter().filter(is_found).count(), found.counts().outlier);
        println!("{kind} {roughness}: {count} of {} found, {left_out} left out", dust.len());
        assert!(count as f64 > least * dust.len() as f64 && left_out as usize <= count + 4);
    }
}

#[test]
fn unusable_pictures_are_rejected() {
    let (mesh, assets) = (Mesh::builtin(BuiltinMesh::Sphere), LightAssets::default());
    let plain = Scene::default();
    let model = Model::new(ModelKind::Lambert);
    let good = LinearPicture::from(&rendered(&model, &mesh, &plain, Sampling::Adaptive));
    let refused = |scene: &Scene, picture: &LinearPicture, mask: Option<LinearPicture>| {
        let view = View { mask: mask.as_ref(), ..view(&mesh, scene, &assets, picture) };
        match ImageView::new(&view) {
            Ok((view, samples)) => pooled([(&view, &samples)]).err().map(|error| error.to_string()),
            Err(error) => Some(error.to_string()),
        }
    };
    assert_eq!(refused(&plain, &good, None), None);
    let flat = |width: u32, height: u32, value: f32| {
        let count = (width * height) as usize;
        let (pixels, clipped) = (vec![[value; 3]; count], vec![false; count]);
        LinearPicture { width, height, pixels, clipped, is_linear: true }
    };
    let said =
        |scene: &Scene, picture: &LinearPicture, mask| refused(scene, picture, mask).unwrap();
    assert!(said(&plain, &flat(1, 1, 0.5), None).contains("1 x 1 pixels is too small"));
    assert!(said(&plain, &flat(48, 7, 0.5), None).contains("48 x 7 pixels is too small"));
    assert_eq!(
        said(&plain, &flat(48, 32, 0.5), Some(flat(32, 48, 1.0))),
        "the mask has 32 x 48 pixels and the picture 48 x 32; both must be equal"
    );
    let mut broken = good.clone();
    broken.pixels[50][1] = f32::NAN;
    assert_eq!(said(&plain, &broken, None), "the pixel 2, 1 is not a finite number");
    assert!(said(&plain, &good, Some(flat(48, 48, 0.0))).contains("the mask leaves no pixel"));
    assert!(said(&plain, &good, Some(flat(32, 32, 1.0))).contains("the mask has 32 x 32 pixels"));
    let mut corner = flat(48, 48, 0.0);
    corner.pixels[24 * 48 + 24] = [1.0; 3];
    assert!(said(&plain, &good, Some(corner)).contains("pixels can be used and 100 are needed"));
    let past = scene(r#"{"camera": {"eye": [0, 0, 5], "target": [0, 0, 9]}}"#);
    assert!(said(&past, &good, None).contains("sees nothing of the mesh"));
    let behind = scene(
        r#"{"camera": {"orthographic": 1.2}, "lights": [{"kind": "directional", "direction": [0, 0, 1]}]}"#,
    );
    assert!(said(&behind, &good, None).contains("no light of the scene reaches"));
    let filmic = scene(r#"{"film": {"tone": "filmic"}}"#);
    assert_eq!(refused(&filmic, &good, None), None);
    let shown = LinearPicture { is_linear: false, ..good };
    assert!(said(&filmic, &shown, None).contains("tone curve is filmic"));
}
