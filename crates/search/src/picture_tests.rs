//! Tests that materials are found from pictures of them.

use brood_brdf::{Model, ModelKind};
use brood_eval::{Level, LinearPicture, RadianceImage, decode_srgb, encode_srgb, shade_brdf};
use brood_light::LightAssets;
use brood_mesh::{BuiltinMesh, Mesh};
use brood_program::Program;
use brood_scene::{ClipFrom, PictureSize, PixelArea, Raster, Refine, SampleSet, Sampling, Scene};
use brood_target::{ImageView, MeasuredTarget, Samples, Strategy, View, metric};

use crate::analytic::{Form, Recovery};
use crate::{Options, Search};

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
fn model_is_recovered_from_a_picture() {
    let model = Model::new(ModelKind::CookTorrance).with("diffuse", &[0.2, 0.1, 0.05]).unwrap();
    let model = model.with("roughness", &[0.35]).unwrap();
    let (mesh, assets) = (Mesh::builtin(BuiltinMesh::Sphere), LightAssets::default());
    for light in [r#"{"kind": "point", "position": [3, 3, 3]}"#, r#"{"kind": "directional"}"#] {
        let scene = scene(&format!(r#"{{"lights": [{light}], "light_deg": 20}}"#));
        let picture = LinearPicture::from(&rendered(&model, &mesh, &scene, Sampling::Adaptive));
        let (view, samples) = ImageView::new(&view(&mesh, &scene, &assets, &picture)).unwrap();
        let recovery = Recovery::new(&samples, Form::of(&model), 1e-7);
        let found = recovery.run(3, 0).model;
        let error = view.compare(&rendered(&found, &mesh, &scene, Sampling::Adaptive));
        assert!(error.rmse < 1e-3, "{} {error:?}", Level::best().name());
    }
}

#[test]
fn model_is_recovered_from_wide_and_tall_pictures() {
    let model = Model::new(ModelKind::CookTorrance).with("diffuse", &[0.2, 0.1, 0.05]).unwrap();
    let model = model.with("roughness", &[0.35]).unwrap();
    let (mesh, assets) = (Mesh::builtin(BuiltinMesh::Sphere), LightAssets::default());
    let scene = scene(r#"{"lights": [{"kind": "directional"}], "light_deg": 20}"#);
    for (width, height) in [(80, 40), (40, 64)] {
        let size_px = PictureSize { width, height };
        let rendered =
            |model: &Model| rendered_in(size_px, model, &mesh, &scene, Sampling::Adaptive);
        let picture = LinearPicture::from(&rendered(&model));
        let (view, samples) = ImageView::new(&view(&mesh, &scene, &assets, &picture)).unwrap();
        let found = Recovery::new(&samples, Form::of(&model), 1e-7).run(3, 0).model;
        let error = view.compare(&rendered(&found));
        assert!(error.rmse < 1e-3, "{size_px} {} {error:?}", Level::best().name());
    }
}

#[test]
fn lambertian_is_found_from_a_picture_of_unknown_brightness() {
    let (mesh, assets) = (Mesh::builtin(BuiltinMesh::Knob), LightAssets::default());
    let scene = scene(r#"{"shadows": true}"#);
    let model = Model::new(ModelKind::Lambert);
    let mut picture = LinearPicture::from(&rendered(&model, &mesh, &scene, Sampling::Adaptive));
    picture.pixels.iter_mut().for_each(|pixel| *pixel = pixel.map(|value| value * 0.25));
    let unknown = View { is_gain_unknown: true, ..view(&mesh, &scene, &assets, &picture) };
    let (_, samples) = ImageView::new(&unknown).unwrap();
    let target = MeasuredTarget::of_pixels(&samples).unwrap();
    let options =
        Options { strategy: Strategy::Analytic, seed: 1, is_mirrored: true, ..Options::default() };
    let mut search = Search::with_kinds(&target.fitted, &options, vec![ModelKind::Lambert]);
    assert!(search.step().held < 1e-4);
}

#[test]
fn clipped_highlight_bounds_the_fit_from_below() {
    let diffuse = [0.2, 0.1, 0.05];
    let model = Model::new(ModelKind::CookTorrance).with("diffuse", &diffuse).unwrap();
    let model = model.with("roughness", &[0.3]).unwrap().with("f0", &[0.3; 3]).unwrap();
    let matt = Model::new(ModelKind::Lambert).with("albedo", &diffuse).unwrap();
    let (mesh, assets) = (Mesh::builtin(BuiltinMesh::Sphere), LightAssets::default());
    let lit_by = |irradiance: f32| {
        scene(&format!(
            r#"{{"lights": [{{"kind": "directional", "irradiance_w_m2": {irradiance}}}], "light_deg": 20}}"#
        ))
    };
    let brightest =
        |picture: &LinearPicture| picture.pixels.iter().map(|pixel| pixel[0]).fold(0.0, f32::max);
    let once = LinearPicture::from(&rendered(&model, &mesh, &lit_by(1.0), Sampling::Adaptive));
    // Everything above a third of the brightest is clipped, and the mask excludes the slope of the
    // highlight: a diffuse body is left, and only the clipped pixels indicate a highlight.
    let limit = 1.0;
    let scene = lit_by(3.0 * limit / brightest(&once));
    let image = rendered(&model, &mesh, &scene, Sampling::Adaptive);
    let body = LinearPicture::from(&rendered(&matt, &mesh, &scene, Sampling::Adaptive));
    let mut picture = LinearPicture::from(&image);
    let mut mask = body.clone();
    for (at, pixel) in picture.pixels.iter_mut().enumerate() {
        picture.clipped[at] = pixel[0] > limit;
        let is_matt = pixel[0] < 0.2 * limit + body.pixels[at][0];
        mask.pixels[at] = [f32::from(u8::from(is_matt || picture.clipped[at])); 3];
        *pixel = if picture.clipped[at] { [limit; 3] } else { body.pixels[at] };
    }
    let given = View { mask: Some(&mask), ..view(&mesh, &scene, &assets, &picture) };
    let (view, samples) = ImageView::new(&given).unwrap();
    let centres = samples.at_centres();
    assert!(centres.lower_bounds().len() > 10, "{}", centres.lower_bounds().len());
    assert!(view.counts().clipped as usize >= centres.lower_bounds().len());
    let unbounded = Samples::new(centres.pairs().to_vec(), centres.values().to_vec());
    for (strategy, generations) in
        [(Strategy::Lobes, 3), (Strategy::Analytic, 3), (Strategy::Gp, 40)]
    {
        // Least ratio of the found f to the lower bounds of the clipped pixels.
        let reached = |samples_to_fit: &Samples| {
            let options = Options { strategy, seed: 2, is_mirrored: true, ..Options::default() };
            let mut search = Search::new(samples_to_fit, &options);
            (0..generations).for_each(|_| {
                search.step();
            });
            let outcome = search.finish().unwrap();
            let program = Program::lower(&outcome.front[outcome.best].genome);
            let pairs: Vec<_> = centres.lower_bounds().iter().map(|bound| bound.pair).collect();
            let found = Samples::of_program(&program, pairs).unwrap();
            let below = centres.lower_bounds().iter().zip(found.values());
            below.map(|(bound, f)| f[0] / bound.f[0]).fold(f64::INFINITY, f64::min)
        };
        let (with, without) = (reached(&samples), reached(&unbounded));
        println!("{strategy}: {with:.3} of what was clipped, {without:.3} without its bounds");
        assert!(with > 0.6 && with > 1.5 * without, "{strategy}: {with} {without}");
    }
}

/// Picture in codes of 8 bits whose brightest channel is `brightest` times the largest code, with
/// normal noise of `deviation` codes after clipping.
fn photograph(image: &RadianceImage, exposure: f64, deviation: f64) -> LinearPicture {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut unit = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut normal = || {
        let radius = (-2.0 * libm::log(1.0 - unit())).sqrt();
        radius * libm::cos(std::f64::consts::TAU * unit())
    };
    let mut picture = LinearPicture { is_linear: false, ..LinearPicture::from(image) };
    for (pixel, clipped) in picture.pixels.iter_mut().zip(&mut picture.clipped) {
        let codes = pixel.map(|value| {
            let code = f64::from(encode_srgb((f64::from(value) * exposure) as f32));
            (code + deviation * normal()).round().clamp(0.0, 255.0)
        });
        *clipped = codes.contains(&255.0);
        *pixel = codes.map(|code| decode_srgb(code / 255.0) as f32);
    }
    picture
}

#[test]
fn conductor_is_recovered_from_a_clipped_picture_with_noise() {
    let model = Model::new(ModelKind::Conductor).with("eta", &[0.143, 0.375, 1.442]).unwrap();
    let model = model.with("k", &[3.983, 2.386, 1.603]).unwrap();
    let model = model.with("roughness", &[0.2]).unwrap();
    let (mesh, assets) = (Mesh::builtin(BuiltinMesh::Sphere), LightAssets::default());
    let lit_from = |position: &str| {
        scene(&format!(
            r#"{{"film": {{"exposure": 0}}, "lights": [{{"kind": "point", "position": {position}}}]}}"#
        ))
    };
    let (plain, other) = (lit_from("[2, 2, 3]"), lit_from("[-3, 1, 1]"));
    let image = rendered(&model, &mesh, &plain, Sampling::Fixed(1));
    let brightest =
        image.premultiplied().iter().flatten().fold(0f32, |most, value| most.max(*value));
    // The highlight is 4 times brighter than the largest code.
    let exposure = 4.0 / f64::from(brightest);
    let scene = Scene {
        film: serde_json::from_str(&format!(r#"{{"exposure": {}}}"#, libm::log2(exposure)))
            .unwrap(),
        ..plain
    };
    let raster = Raster {
        size_px: SIDE_PX.into(),
        sampling: Sampling::Fixed(1),
        area: PixelArea::whole(SIDE_PX),
    };
    let set = SampleSet::render_with_assets(&mesh, &other, &assets, raster);
    let unseen = Samples::of(&*model.brdf(), (0..set.len()).map(|at| set.pair(at).0).collect());
    let error = |deviation: f64, clip_from: ClipFrom| {
        let picture = photograph(&image, exposure, deviation);
        let sampling = Sampling::Fixed(1);
        let given = View { clip_from, sampling, ..view(&mesh, &scene, &assets, &picture) };
        let (view, samples) = ImageView::new(&given).unwrap();
        let target = MeasuredTarget::of_pixels(&samples).unwrap();
        let options = Options {
            strategy: Strategy::Analytic,
            seed: 1,
            is_mirrored: true,
            ..Options::default()
        };
        let kinds = vec![ModelKind::Conductor];
        let mut search = Search::with_kinds(&target.fitted, &options, kinds);
        search.step();
        let outcome = search.finish().unwrap();
        let program = Program::lower(&outcome.front[outcome.best].genome);
        let found = Samples::of_program(&program, unseen.pairs().to_vec()).unwrap();
        let error = metric::e_log(&unseen.weighted(), &found.weighted());
        println!(
            "noise {deviation}, clip_from {clip_from}: E_log {error:.4} under another light, {:?}, {}",
            view.clipped_from(),
            view.counts()
        );
        error
    };
    let clean = error(0.0, ClipFrom::LARGEST);
    let before = error(2.0, ClipFrom::LARGEST);
    let after = error(2.0, ClipFrom::Auto);
    // One light hardly tells eta from k: the rest is the prior's, which does not know gold.
    assert!(clean < 0.006 && after < 0.01 && before > 4.0 * after, "{clean} {before} {after}");
}

/// f cos_i of a model at pairs of all directions.
fn everywhere(model: &Model) -> Vec<[f64; 3]> {
    Samples::of(&*model.brdf(), brood_target::draw_pairs(500, 3)).weighted()
}

#[test]
fn model_is_found_from_a_picture_in_an_environment_or_under_several_lights() {
    let model = Model::new(ModelKind::CookTorrance).with("diffuse", &[0.2, 0.1, 0.05]).unwrap();
    let model = model.with("roughness", &[0.25]).unwrap();
    let (mesh, assets) = (Mesh::builtin(BuiltinMesh::Sphere), LightAssets::default());
    for (lights, sampling, most) in [
        (
            r#"{"kind": "environment", "image": "studio", "samples": 1024}"#,
            Sampling::Adaptive,
            0.01,
        ),
        (
            r#"{"kind": "point", "position": [3, 3, 3]}, {"kind": "point", "position": [-3, 1, 2]}"#,
            Sampling::Fixed(64),
            5e-4,
        ),
    ] {
        let scene = scene(&format!(r#"{{"lights": [{lights}]}}"#));
        let picture = LinearPicture::from(&rendered(&model, &mesh, &scene, sampling));
        let (_, samples) = ImageView::new(&view(&mesh, &scene, &assets, &picture)).unwrap();
        assert!(samples.means().samples() > 100, "{lights}");
        let target = MeasuredTarget::of_pixels(&samples).unwrap();
        let options = Options {
            strategy: Strategy::Analytic,
            seed: 1,
            is_mirrored: true,
            ..Options::default()
        };
        let kinds = vec![ModelKind::Lambert, ModelKind::CookTorrance, ModelKind::Ward];
        let mut search = Search::with_kinds(&target.fitted, &options, kinds);
        search.step();
        let front = search.finish().unwrap().front;
        let found = crate::Found::of(&front[0], &target).unwrap();
        let program = Program::lower(&front[0].genome);
        let pairs = brood_target::draw_pairs(500, 3);
        let f = Samples::of_program(&program, pairs).unwrap().weighted();
        let error = metric::e_log(&everywhere(&model), &f);
        assert!(error < most && found.e_log < most, "{lights}: {error}, {}", found.e_log);
    }
}
