//! Tests that the spread of materials is where samples leave them open, and that the advised
//! picture shows it.

use std::sync::Arc;

use brood_brdf::{Model, ModelKind};
use brood_eval::{encode_exr, shade_brdf};
use brood_light::LightAssets;
use brood_mesh::{BuiltinMesh, Mesh};
use brood_scene::{ClipFrom, PictureSize, PixelArea, Raster, Refine, SampleSet, Sampling, Scene};
use brood_target::{KnownView, MeasuredTarget, Pictures, Samples, Strategy, ViewSetup, draw_pairs};

use crate::analytic::default_kinds;
use crate::{Options, Search, Spread, SpreadMap};

const SIZE_PX: PictureSize = PictureSize { width: 64, height: 64 };

fn plastic() -> Model {
    let model = Model::new(ModelKind::CookTorrance).with("diffuse", &[0.2, 0.1, 0.05]).unwrap();
    model.with("roughness", &[0.3]).unwrap()
}

fn scene(position: [f64; 3]) -> Scene {
    let json = format!(
        r#"{{"camera": {{"eye": [0, 0, 5], "fov_y_deg": 28}},
            "lights": [{{"kind": "point", "position": {position:?}}}]}}"#
    );
    serde_json::from_str(&json).unwrap()
}

/// A picture of the plastic ball.
fn photographed(scene: &Scene) -> (KnownView, Samples) {
    let mesh = Arc::new(Mesh::builtin(BuiltinMesh::Sphere));
    let raster =
        Raster { size_px: SIZE_PX, sampling: Sampling::Adaptive, area: PixelArea::whole(SIZE_PX) };
    let set = SampleSet::render_with_assets(&*mesh, scene, &LightAssets::default(), raster);
    let picture = encode_exr(&shade_brdf(&set, &*plastic().brdf())).unwrap();
    let setting = ViewSetup {
        scene: scene.clone(),
        mesh,
        assets: LightAssets::default(),
        sampling: Sampling::Adaptive,
        is_gain_unknown: false,
        clip_from: ClipFrom::Off,
        crop: None,
        is_held_out: false,
        refine: Refine::default(),
    };
    KnownView::read(setting, &picture, None).unwrap()
}

/// Spread after pictures under these lights.
fn searched(positions: &[[f64; 3]]) -> (Spread, KnownView, MeasuredTarget) {
    let views = positions.iter().map(|position| Ok(photographed(&scene(*position))));
    let (pictures, target) = Pictures::gather(views).unwrap();
    let options =
        Options { strategy: Strategy::Analytic, seed: 1, is_mirrored: true, ..Options::default() };
    // As with real materials, no model is exact.
    let others = |kind: &ModelKind| *kind != ModelKind::CookTorrance;
    let kinds = default_kinds().into_iter().filter(others).collect();
    let mut search = Search::with_kinds(&target.fitted, &options, kinds);
    search.step();
    let view = pictures.views.into_iter().next().unwrap();
    (Spread::of(&search).unwrap(), view, target)
}

#[test]
fn spread_is_large_where_no_sample_is_and_falls_with_the_advised_picture() {
    let (spread, view, target) = searched(&[[0.5, 0.5, 5.0]]);
    let map = spread.map(&target.fitted).unwrap();
    assert!((map.seen.iter().sum::<f64>() - 1.0).abs() < 1e-9);
    // One lamp beside the eye shows small theta_d alone.
    assert!(map.seen[10 * SpreadMap::CELLS..].iter().all(|share| *share == 0.0));
    let of = |is_seen: bool| {
        let cells = map.seen.iter().zip(&map.deviation);
        let of: Vec<f64> = cells
            .filter(|(seen, deviation)| (**seen > 0.002) == is_seen && **deviation > 0.0)
            .map(|(_, deviation)| *deviation)
            .collect();
        of.iter().sum::<f64>() / of.len() as f64
    };
    assert!(of(true) < 0.7 * of(false), "{} {}", of(true), of(false));
    let all = spread.next_pictures(&view).unwrap();
    let best = &all[0];
    assert!(all.len() > 40 && all.windows(2).all(|two| two[0].e_log[1] <= two[1].e_log[1]));
    assert!(best.e_log[1] < 0.8 * best.e_log[0], "{:?}", best.e_log);
    // A lamp far from the eye tells more, but not one behind the ball.
    let [right, up] = best.light_deg.unwrap();
    let cosine = right.to_radians().cos() * up.to_radians().cos();
    assert!((-0.95..0.8).contains(&cosine), "{right} {up}");
    let (after, ..) = searched(&[[0.5, 0.5, 5.0], position(&best.scene)]);
    let spreads = [spread.e_log().unwrap(), after.e_log().unwrap()];
    assert!(spreads[1] < 0.8 * spreads[0], "{spreads:?}");
}

fn position(scene: &Scene) -> [f64; 3] {
    match &scene.lights[0] {
        brood_light::Light::Point(own) => own.position.unwrap(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn spread_is_deterministic_and_of_models_alone() {
    let samples = Samples::of(&*plastic().brdf(), draw_pairs(300, 1));
    let search = |strategy| {
        let options = Options { strategy, seed: 1, is_mirrored: true, ..Options::default() };
        let mut search =
            Search::with_kinds(&samples, &options, vec![ModelKind::Lambert, ModelKind::Ward]);
        search.step();
        search
    };
    let one = search(Strategy::Analytic);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(one.posterior(8), pool.install(|| search(Strategy::Analytic).posterior(8)));
    assert_eq!(one.posterior(8).unwrap().genomes.len(), 8);
    let options =
        Options { strategy: Strategy::Gp, seed: 1, is_mirrored: true, ..Options::default() };
    assert!(Spread::of(&Search::new(&samples, &options)).is_none());
}

#[test]
fn range_is_between_the_quantiles_of_each_value() {
    let rows: Vec<Vec<f32>> = (0u8..41).map(|k| vec![f32::from(k), -f32::from(k)]).collect();
    assert_eq!(Spread::range(&rows), [vec![2.0, -38.0], vec![38.0, -2.0]]);
}

#[test]
fn only_environments_that_turn_are_turned_for_a_next_picture() {
    let (_, view, _) = searched(&[[0.5, 0.5, 5.0]]);
    let counts = [("true", 0), ("false", 11)].map(|(fixed, wanted)| {
        let light = format!(r#"[{{"kind": "environment", "image": "studio", "fixed": {fixed}}}]"#);
        let lights = serde_json::from_str(&light).unwrap();
        let scene = Scene { lights, ..view.setting.scene.clone() };
        let setting = ViewSetup { scene, ..view.setting.clone() };
        (super::next::scenes(&setting).len(), wanted)
    });
    assert!(counts.iter().all(|(found, wanted)| found == wanted), "{counts:?}");
}
