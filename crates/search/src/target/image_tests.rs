//! Tests that rendered pictures are read back, and that unusable pictures are rejected.

use brood_brdf::{Model, ModelKind};
use brood_eval::{Level, model_reflectance, shade};
use brood_scene::BuiltinMesh;

use super::*;
use crate::analytic::{Form, Recovery};
use crate::{Options, Search, Strategy};

const SIDE_PX: u32 = 48;

fn scene(json: &str) -> Scene {
    serde_json::from_str(json).unwrap()
}

fn rendered(model: &Model, mesh: &Mesh, scene: &Scene, sampling: Sampling) -> RadianceImage {
    let raster = Raster { size_px: SIDE_PX, sampling, area: PixelArea::whole(SIDE_PX) };
    let set = SampleSet::render_with_assets(mesh, scene, &LightAssets::default(), raster);
    let mut f = Vec::new();
    model_reflectance(&*model.brdf(), &set, &mut f);
    shade(&set, &f)
}

fn picture(image: &RadianceImage) -> LinearPicture {
    LinearPicture {
        width: image.width(),
        height: image.height(),
        pixels: image.premultiplied().to_vec(),
        clipped: vec![false; image.premultiplied().len()],
        is_linear: true,
    }
}

fn view<'a>(
    mesh: &'a Mesh,
    scene: &'a Scene,
    assets: &'a LightAssets,
    picture: &'a LinearPicture,
) -> View<'a> {
    let sampling = Sampling::Adaptive;
    View { mesh, scene, assets, sampling, picture, mask: None, is_gain_unknown: false }
}

#[test]
fn pixels_give_the_reflectance_of_the_rendered_model() {
    let model = Model::new(ModelKind::CookTorrance).with("diffuse", &[0.2, 0.1, 0.05]).unwrap();
    let model = model.with("roughness", &[0.35]).unwrap();
    let (mesh, assets) = (Mesh::builtin(BuiltinMesh::Sphere), LightAssets::default());
    for light in [r#"{"kind": "point", "position": [3, 3, 3]}"#, r#"{"kind": "directional"}"#] {
        let scene = scene(&format!(r#"{{"lights": [{light}], "light_deg": 20}}"#));
        let image = rendered(&model, &mesh, &scene, Sampling::Adaptive);
        let picture = picture(&image);
        let (view, samples) = ImageView::new(&view(&mesh, &scene, &assets, &picture)).unwrap();
        let counts = view.counts();
        assert!(counts.used as usize == samples.len() && counts.used > 300, "{counts}");
        let PixelCounts { masked, background, edge, clipped, unlit, .. } = counts;
        let PixelCounts { half_lit, several_lights, grazing, used, .. } = counts;
        let all = masked + background + edge + clipped + unlit + half_lit + several_lights;
        assert_eq!(all + grazing + used, u64::from(SIDE_PX * SIDE_PX), "{counts}");
        let brdf = model.brdf();
        for (pair, value) in samples.pairs().iter().zip(samples.values()) {
            let f = brdf.f(pair).to_array();
            assert!((0..3).all(|k| (value[k] - f[k]).abs() < 0.02 * f[k]), "{value:?} {f:?}");
        }
        assert_eq!(view.compare(&image), ImageError { rmse: 0.0, rmse_used: 0.0, gain: 1.0 });
        let recovery = Recovery::new(&samples, Form::of(&model), 1e-7);
        let found = recovery.run(3, 0).model;
        let error = view.compare(&rendered(&found, &mesh, &scene, Sampling::Adaptive));
        assert!(error.rmse < 1e-3, "{} {error:?}", Level::best().name());
    }
}

#[test]
fn unknown_brightness_is_compensated_by_a_gain() {
    let model = Model::new(ModelKind::Lambert);
    let (mesh, assets) = (Mesh::builtin(BuiltinMesh::Knob), LightAssets::default());
    let scene = scene(r#"{"shadows": true}"#);
    let image = rendered(&model, &mesh, &scene, Sampling::Adaptive);
    let mut picture = picture(&image);
    picture.pixels.iter_mut().for_each(|pixel| *pixel = pixel.map(|value| value * 0.25));
    let unknown = View { is_gain_unknown: true, ..view(&mesh, &scene, &assets, &picture) };
    let (view, samples) = ImageView::new(&unknown).unwrap();
    assert!(view.counts().unlit > 0);
    let error = view.compare(&image);
    assert!((error.gain - 0.25).abs() < 1e-6 && error.rmse < 1e-6, "{error:?}");
    let target = crate::MeasuredTarget::of_pixels(&samples).unwrap();
    let options =
        Options { strategy: Strategy::Analytic, seed: 1, is_mirrored: true, start: Vec::new() };
    let mut search = Search::with_kinds(&target.fitted, &options, vec![ModelKind::Lambert]);
    assert!(search.step().held < 1e-4);
}

#[test]
fn pixels_lit_by_several_lights_are_left_out() {
    let (mesh, assets) = (Mesh::builtin(BuiltinMesh::Sphere), LightAssets::default());
    let scene = scene(
        r#"{"lights": [{"kind": "directional", "direction": [1, 0, -0.2]}, {"kind": "directional", "direction": [-1, 0, -0.2]}]}"#,
    );
    let image = rendered(&Model::new(ModelKind::Lambert), &mesh, &scene, Sampling::Adaptive);
    let picture = picture(&image);
    let (view, samples) = ImageView::new(&view(&mesh, &scene, &assets, &picture)).unwrap();
    assert!(view.counts().several_lights > 50 && samples.len() > 200, "{}", view.counts());
    let lambert = 0.5 / std::f64::consts::PI;
    assert!(samples.values().iter().all(|f| (f[0] - lambert).abs() < 0.02 * lambert));
}

#[test]
fn unusable_pictures_are_rejected() {
    let (mesh, assets) = (Mesh::builtin(BuiltinMesh::Sphere), LightAssets::default());
    let plain = Scene::default();
    let model = Model::new(ModelKind::Lambert);
    let good = picture(&rendered(&model, &mesh, &plain, Sampling::Adaptive));
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
    assert!(said(&plain, &flat(48, 32, 0.5), None).contains("must be square"));
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
    let soft = scene(r#"{"lights": [{"kind": "ambient"}]}"#);
    assert!(said(&soft, &good, None).contains("a light of kind ambient"));
    let filmic = scene(r#"{"film": {"tone": "filmic"}}"#);
    assert_eq!(refused(&filmic, &good, None), None);
    let shown = LinearPicture { is_linear: false, ..good };
    assert!(said(&filmic, &shown, None).contains("tone curve is filmic"));
}

#[test]
fn clipped_highlight_bounds_the_fit_from_below() {
    let diffuse = [0.2, 0.1, 0.05];
    let model = Model::new(ModelKind::CookTorrance).with("diffuse", &diffuse).unwrap();
    let model = model.with("roughness", &[0.3]).unwrap().with("f0", &[0.3; 3]).unwrap();
    let matt = Model::new(ModelKind::Lambert).with("albedo", &diffuse).unwrap();
    let (mesh, assets) = (Mesh::builtin(BuiltinMesh::Sphere), LightAssets::default());
    let scene = scene(r#"{"lights": [{"kind": "directional"}], "light_deg": 20}"#);
    let image = rendered(&model, &mesh, &scene, Sampling::Adaptive);
    let body = picture(&rendered(&matt, &mesh, &scene, Sampling::Adaptive));
    let mut picture = picture(&image);
    let brightest = picture.pixels.iter().map(|pixel| pixel[0]).fold(0.0, f32::max);
    // Everything above a third of the brightest is clipped, and the mask excludes the slope of the
    // highlight: a diffuse body is left, and only the clipped pixels indicate a highlight.
    let limit = brightest / 3.0;
    let mut mask = body.clone();
    for (at, pixel) in picture.pixels.iter_mut().enumerate() {
        picture.clipped[at] = pixel[0] > limit;
        let is_matt = pixel[0] < 0.2 * limit + body.pixels[at][0];
        mask.pixels[at] = [f32::from(u8::from(is_matt || picture.clipped[at])); 3];
        *pixel = if picture.clipped[at] { [limit; 3] } else { body.pixels[at] };
    }
    let given = View { mask: Some(&mask), ..view(&mesh, &scene, &assets, &picture) };
    let (view, samples) = ImageView::new(&given).unwrap();
    assert!(samples.lower_bounds().len() > 10, "{}", samples.lower_bounds().len());
    assert!(view.counts().clipped as usize >= samples.lower_bounds().len());
    let unbounded = Samples::new(samples.pairs().to_vec(), samples.values().to_vec());
    for strategy in [Strategy::Lobes, Strategy::Analytic] {
        // Least ratio of the found f to the lower bounds of the clipped pixels.
        let reached = |samples_to_fit: &Samples| {
            let options = Options { strategy, seed: 2, is_mirrored: true, start: Vec::new() };
            let mut search = Search::new(samples_to_fit, &options);
            (0..3).for_each(|_| {
                search.step();
            });
            let outcome = search.finish().unwrap();
            let program = brood_program::Program::lower(&outcome.front[outcome.best].genome);
            let pairs: Vec<_> = samples.lower_bounds().iter().map(|(pair, _)| *pair).collect();
            let found = Samples::of_program(&program, pairs).unwrap();
            let below = samples.lower_bounds().iter().zip(found.values());
            below.map(|((_, least), f)| f[0] / least[0]).fold(f64::INFINITY, f64::min)
        };
        let (with, without) = (reached(&samples), reached(&unbounded));
        println!("{strategy}: {with:.3} of what was clipped, {without:.3} without its bounds");
        assert!(with > 0.6 && with > 1.5 * without, "{strategy}: {with} {without}");
    }
}
