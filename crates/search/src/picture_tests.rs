//! Tests that materials are found from pictures of them.

use brood_brdf::{Model, ModelKind};
use brood_eval::{Level, LinearPicture, RadianceImage, shade_brdf};
use brood_light::LightAssets;
use brood_mesh::{BuiltinMesh, Mesh};
use brood_program::Program;
use brood_scene::{PixelArea, Raster, SampleSet, Sampling, Scene};
use brood_target::{ImageView, MeasuredTarget, Samples, Strategy, View};

use crate::analytic::{Form, Recovery};
use crate::{Options, Search};

const SIDE_PX: u32 = 48;

fn scene(json: &str) -> Scene {
    serde_json::from_str(json).unwrap()
}

fn rendered(model: &Model, mesh: &Mesh, scene: &Scene, sampling: Sampling) -> RadianceImage {
    let raster = Raster { size_px: SIDE_PX, sampling, area: PixelArea::whole(SIDE_PX) };
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
    View { mesh, scene, assets, sampling, picture, mask: None, is_gain_unknown: false }
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
        Options { strategy: Strategy::Analytic, seed: 1, is_mirrored: true, start: Vec::new() };
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
    let scene = scene(r#"{"lights": [{"kind": "directional"}], "light_deg": 20}"#);
    let image = rendered(&model, &mesh, &scene, Sampling::Adaptive);
    let body = LinearPicture::from(&rendered(&matt, &mesh, &scene, Sampling::Adaptive));
    let mut picture = LinearPicture::from(&image);
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
            let program = Program::lower(&outcome.front[outcome.best].genome);
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
