//! Tests that scenes of pictures are corrected.

use std::sync::Arc;

use brood_brdf::{Model, ModelKind};
use brood_eval::{encode_exr, shade_brdf};
use brood_light::{LightAssets, LightMove};
use brood_mesh::{BuiltinMesh, Mesh};
use brood_scene::{
    CameraMove, ClipFrom, Correction, PixelArea, Raster, Refine, SampleSet, Sampling, Scene,
};
use brood_target::ViewSetup;

use super::*;

const SIDE_PX: u32 = 96;
const STILL: LightMove = LightMove { turn_deg: [0.0; 2], distance: 1.0 };

/// Scene with a light of this intensity in red, green and blue.
fn scene(intensity: [f64; 3]) -> Scene {
    let json = serde_json::json!({
        "mesh": "cube", "rotation_deg": [20, 35, 10], "shadows": true,
        "camera": {"orbit_deg": [25, 30], "fov_y_deg": 28},
        "lights": [{"kind": "point", "position": [3, 3.5, 2.5], "intensity": intensity}],
    });
    serde_json::from_value(json).unwrap()
}

/// Picture of a matt cube in a scene that differs from the stated one by a correction.
fn picture(
    (stated, taken): (&Scene, &Scene),
    by: &Correction,
    (refine, is_held_out): (Refine, bool),
) -> (KnownView, Samples) {
    let model = Model::new(ModelKind::Lambert).with("albedo", &[0.5, 0.3, 0.1]).unwrap();
    let mesh = Mesh::builtin(BuiltinMesh::Cube);
    let (size_px, sampling) = (SIDE_PX.into(), Sampling::Adaptive);
    let raster = Raster { size_px, sampling, area: PixelArea::whole(size_px) };
    let taken = taken.corrected(&mesh, SIDE_PX, by);
    let set = SampleSet::render_with_assets(&mesh, &taken, &LightAssets::default(), raster);
    let setting = ViewSetup {
        scene: stated.clone(),
        mesh: Arc::new(mesh),
        assets: LightAssets::default(),
        sampling,
        is_gain_unknown: false,
        clip_from: ClipFrom::Auto,
        crop: None,
        is_held_out,
        refine,
    };
    let bytes = encode_exr(&shade_brdf(&set, &*model.brdf())).unwrap();
    KnownView::read(setting, &bytes, None).unwrap()
}

fn calibrated(views: Vec<(KnownView, Samples)>) -> Calibrated {
    let (pictures, target) = Pictures::gather(views.into_iter().map(Ok)).unwrap();
    calibrate(pictures, target).unwrap()
}

fn value(found: &Calibrated, name: &str) -> f64 {
    found.corrections.iter().find(|one| one.name == name).unwrap().value
}

#[test]
fn light_and_camera_of_a_picture_are_found() {
    let by = Correction {
        lights: vec![LightMove { turn_deg: [1.5, -1.0], distance: 1.0 }],
        camera: CameraMove {
            turn_deg: [-0.6, 0.4],
            aim_deg: [0.2, -0.1, 0.3],
            distance: 1.0,
            fov: 1.01,
        },
    };
    let (stated, taken) = (scene([60.0; 3]), scene([60.0, 66.0, 57.0]));
    let (light_deg, camera_deg, fov, white_balance) = (2.0, 1.0, 0.01, 0.1);
    let refine = Refine { light_deg, camera_deg, fov, white_balance, ..Refine::default() };
    let found = calibrated(vec![
        picture((&stated, &taken), &by, (refine, false)),
        picture((&stated, &taken), &by, (refine, true)),
    ]);
    for (name, wanted, off) in [
        ("lights/0/right_deg", 1.5, 0.1),
        ("lights/0/up_deg", -1.0, 0.1),
        ("camera/right_deg", -0.6, 0.1),
        ("camera/up_deg", 0.4, 0.1),
        ("camera/aim_right_deg", 0.2, 0.02),
        ("camera/aim_up_deg", -0.1, 0.02),
        ("camera/roll_deg", 0.3, 0.1),
        ("camera/fov", 1.01, 0.001),
    ] {
        let value = value(&found, name);
        assert!((value - wanted).abs() < off, "{name}: {value} instead of {wanted}");
    }
    // The picture cannot tell the colour of the light from that of the material.
    let green = found.corrections.iter().find(|one| one.name == "gain/green").unwrap();
    assert!(green.deviation > 0.5 * green.stated_deviation, "{green:?}");
    for one in &found.corrections {
        assert!(one.deviation > 0.0 && one.deviation <= one.stated_deviation, "{one:?}");
        assert!(one.moved() < 1.5, "{one:?}");
        // The held-out picture has the same light and camera.
        assert_eq!(one.pictures, [0, 1], "{one:?}");
    }
    let [fitted, held] = &found.pictures.views[..] else { panic!() };
    assert_eq!(fitted.setting.scene, held.setting.scene);
    assert_ne!(fitted.setting.scene, stated);
}

#[test]
fn calibration_depends_on_the_pictures_alone() {
    let by = Correction {
        lights: vec![LightMove { turn_deg: [1.0, 0.0], ..STILL }],
        camera: CameraMove::default(),
    };
    let stated = scene([60.0; 3]);
    let refine = Refine { light_deg: 2.0, ..Refine::default() };
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| calibrated(vec![picture((&stated, &stated), &by, (refine, false))]))
    };
    let (one, three) = (run(1), run(3));
    assert_eq!(one.corrections, three.corrections);
    assert_eq!(one.target.fitted.values(), three.target.fitted.values());
}

#[test]
fn exact_scenes_stay_as_stated() {
    let stated = scene([60.0; 3]);
    let none = Correction { lights: vec![STILL], camera: CameraMove::default() };
    let found = calibrated(vec![picture((&stated, &stated), &none, (Refine::default(), false))]);
    assert!(found.corrections.is_empty());
    assert_eq!(found.pictures.views[0].setting.scene, stated);
}
