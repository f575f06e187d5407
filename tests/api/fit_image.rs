//! `brood fit` on pictures of known scenes: results, pixel counts, and refused input.

use std::path::Path;

use brood_tests::brood;
use serde_json::Value;
use tempfile::TempDir;

/// Renders a model; returns the scene and the picture.
fn rendered(folder: &Path, model: &str, picture: &str) -> (String, String) {
    rendered_in(folder, model, picture, "48")
}

/// Renders a model in a size; returns the scene and the picture.
fn rendered_in(folder: &Path, model: &str, picture: &str, size: &str) -> (String, String) {
    let scene = folder.join("scene.json");
    let text = r#"{"camera": {"orthographic": 1.05}, "lights": [{"kind": "directional", "direction": [-1, -1, -1.5]}], "film": {"exposure": -1}}"#;
    std::fs::write(&scene, text).unwrap();
    let material = folder.join("material.brood");
    std::fs::write(&material, model).unwrap();
    let picture = folder.join(picture);
    let words = [&scene, &material, &picture].map(|path| path.to_str().unwrap().to_owned());
    let [scene, material, picture] = words;
    let how = ["--scene", scene.as_str(), "--size", size, "-o", picture.as_str()];
    brood([&["render", material.as_str()][..], &how[..]].concat()).success();
    (scene, picture)
}

const PAINT: &str = "brood 1\n.model cook-torrance\ndiffuse 0.3 0.1 0.05\nroughness 0.4\n";

#[test]
fn material_is_recovered_from_a_picture_of_a_known_scene() {
    let folder = TempDir::new().unwrap();
    let (scene, picture) = rendered(folder.path(), PAINT, "picture.exr");
    let fit = |picture: &str, more: &[&str]| -> Value {
        let out = folder.path().join("out");
        let how = ["fit", picture, "--scene", scene.as_str(), "--json"];
        let arguments = [&how[..], &["-o", out.to_str().unwrap()], more].concat();
        serde_json::from_str(&brood(arguments).success().stdout).unwrap()
    };
    let analytic =
        ["--strategy", "analytic", "--models", "cook-torrance,lambert", "--generations", "1"];
    let report = fit(&picture, &analytic);
    assert_eq!(report["target"]["kind"], "picture");
    assert!(report["image_rmse"].as_f64().unwrap() < 1e-3, "{report}");
    assert_eq!(report["views"][0]["gain"], 1.0);
    let pixels = &report["target"]["pixels"];
    let of = |what: &str| pixels[what].as_u64().unwrap();
    let left_out = ["masked", "background", "edge", "clipped", "unlit", "half_lit"].map(of);
    let others = of("several_lights") + of("grazing") + of("used");
    assert_eq!(left_out.iter().sum::<u64>() + others, 48 * 48, "{pixels}");
    assert!(of("used") > 700 && of("edge") > 50 && of("background") > 100, "{pixels}");
    let best = std::fs::read_to_string(folder.path().join("out/best.brood")).unwrap();
    assert!(best.contains(".model cook-torrance"), "{best}");
    for name in ["target", "best", "difference", "pixels"] {
        let bytes = std::fs::read(folder.path().join(format!("out/{name}.png"))).unwrap();
        assert_eq!(image::load_from_memory(&bytes).unwrap().width(), 48, "{name}");
    }
    // Spread of the materials that match the picture.
    let spread = &report["spread"];
    assert_eq!(spread["seen"].as_array().unwrap().len(), 900);
    let seen: f64 = spread["seen"].as_array().unwrap().iter().filter_map(Value::as_f64).sum();
    assert!((seen - 1.0).abs() < 1e-6 && spread["e_log"].as_f64().unwrap() > 0.0, "{spread}");
    let next = &spread["next"];
    assert!(next["e_log_after"].as_f64() < next["e_log_before"].as_f64(), "{next}");
    for (name, width) in [("known", 240), ("darkest", 144), ("brightest", 144)] {
        let bytes = std::fs::read(folder.path().join(format!("out/{name}.png"))).unwrap();
        assert_eq!(image::load_from_memory(&bytes).unwrap().width(), width, "{name}");
    }
    let scene_of_next = std::fs::read(folder.path().join("out/next.json")).unwrap();
    let scene_of_next: Value = serde_json::from_slice(&scene_of_next).unwrap();
    assert_eq!(scene_of_next, next["scene"]);
    // Pictures are fitted by models if no strategy is chosen.
    let report = fit(&picture, &["--models", "lambert", "--generations", "1"]);
    assert_eq!(report["search"]["strategy"], "analytic");
    // The lobe strategy does not use the model, and still comes close.
    let report = fit(&picture, &["--strategy", "lobes", "--generations", "2"]);
    assert_eq!(report["spread"], Value::Null);
    assert!(report["image_rmse"].as_f64().unwrap() < 0.02, "{report}");
    // Eight bits, with known and with unknown exposure.
    let (_, picture) = rendered(folder.path(), PAINT, "picture.png");
    let report = fit(&picture, &analytic);
    assert!(report["image_rmse"].as_f64().unwrap() < 0.01, "{report}");
    let report = fit(&picture, &[&analytic[..], &["--exposure", "auto"]].concat());
    assert_eq!(report["views"][0]["gain_solved"], true);
    assert!(report["image_rmse"].as_f64().unwrap() < 0.01, "{report}");
}

#[test]
fn material_is_recovered_from_wide_and_tall_pictures() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("out");
    for (size, width, height) in [("72x48", 72, 48), ("40x60", 40, 60)] {
        let (scene, picture) = rendered_in(folder.path(), PAINT, "picture.exr", size);
        let how = ["fit", picture.as_str(), "--scene", scene.as_str(), "--json"];
        let search = ["--strategy", "analytic", "--models", "cook-torrance,lambert"];
        let end = ["--generations", "1", "-o", out.to_str().unwrap()];
        let finished = brood([&how[..], &search, &end].concat()).success();
        let report: Value = serde_json::from_str(&finished.stdout).unwrap();
        assert!(report["image_rmse"].as_f64().unwrap() < 1e-3, "{report}");
        assert_eq!(report["target"]["pixels"]["pixels"], width * height);
        let best = std::fs::read_to_string(out.join("best.brood")).unwrap();
        assert!(best.contains(".model cook-torrance"), "{best}");
        for name in ["target", "best", "difference", "pixels"] {
            let picture = image::open(out.join(format!("{name}.png"))).unwrap();
            assert_eq!((picture.width(), picture.height()), (width, height), "{size} {name}");
        }
    }
}

#[test]
fn several_pictures_are_fitted_together_and_one_is_held_out() {
    let folder = TempDir::new().unwrap();
    rendered(folder.path(), PAINT, "a.exr");
    let material = folder.path().join("material.brood");
    let other = r#"{"camera": {"orthographic": 1.05}, "lights": [{"kind": "point", "position": [-3, 1, 3]}]}"#;
    let views = |held_out: bool| {
        format!(
            r#"{{"views": [{{"picture": "a.exr", "scene": "scene.json"}}, {{"picture": "b.exr", "scene": {other}, "held_out": {held_out}}}]}}"#
        )
    };
    let scene = folder.path().join("other.json");
    std::fs::write(&scene, other).unwrap();
    let b = folder.path().join("b.exr");
    let how = ["--scene", scene.to_str().unwrap(), "--size", "40", "-o", b.to_str().unwrap()];
    brood([&["render", material.to_str().unwrap()][..], &how[..]].concat()).success();
    let spec = folder.path().join("target.json");
    let out = folder.path().join("out");
    for held_out in [false, true] {
        std::fs::write(&spec, views(held_out)).unwrap();
        let how = ["--strategy", "analytic", "--generations", "1", "--json", "-o"];
        let arguments = [&["fit", spec.to_str().unwrap()][..], &how, &[out.to_str().unwrap()]];
        let report: Value =
            serde_json::from_str(&brood(arguments.concat()).success().stdout).unwrap();
        let [first, second] = report["views"].as_array().unwrap().as_slice() else { panic!() };
        assert_eq!(second["held_out"], held_out);
        for view in [first, second] {
            assert!(view["rmse"].as_f64().unwrap() < 2e-3, "{report}");
        }
        assert!(out.join("best-2.png").exists());
    }
}

#[test]
fn picture_that_does_not_fit_the_scene_is_refused_with_a_reason() {
    let folder = TempDir::new().unwrap();
    let (scene, good) = rendered(folder.path(), PAINT, "picture.exr");
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let exr = |name: &str, side: u32, value: f32| {
        let pixels = vec![value; (3 * side * side) as usize];
        let path = folder.path().join(name);
        image::Rgb32FImage::from_raw(side, side, pixels).unwrap().save(&path).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let refused = |words: &[&str], reason: &str| {
        let out = folder.path().join("out");
        let finished = brood([&["fit"], words, &["-o", out.to_str().unwrap()]].concat());
        assert_eq!(finished.code, 1, "{}", finished.stdout);
        assert!(!out.exists(), "no output folder is created");
        assert_eq!(finished.stderr.trim_end().lines().count(), 1, "{}", finished.stderr);
        assert!(finished.stderr.contains(reason), "{}", finished.stderr);
    };
    let here = ["--scene", scene.as_str()];
    let with = |picture: &str, reason: &str| refused(&[&[picture], &here[..]].concat(), reason);
    with(&exr("dot.exr", 1, 0.5), "1 x 1 pixels is too small");
    with(&exr("nan.exr", 48, f32::NAN), "the pixel 0, 0 is not a finite number");
    with(&exr("inf.exr", 48, f32::INFINITY), "the pixel 0, 0 is not a finite number");
    with(&exr("black.exr", 48, 0.0), "it reflects nothing");
    with(&write("broken.png", "no picture"), "the picture must be an EXR");
    with(&exr("tiny.exr", 8, 0.5), "pixels can be used and 100 are needed");
    let masked = |mask: &str, reason: &str| {
        refused(&[&[good.as_str(), "--mask", mask], &here[..]].concat(), reason);
    };
    masked(&exr("none.exr", 48, 0.0), "the mask leaves no pixel");
    masked(&exr("small.exr", 32, 1.0), "the mask has 32 x 32 pixels");
    let scene_of = |name: &str, text: &str, reason: &str| {
        refused(&[good.as_str(), "--scene", &write(name, text)], reason);
    };
    let past = r#"{"camera": {"eye": [0, 0, 5], "target": [0, 0, 9]}}"#;
    scene_of("past.json", past, "sees nothing of the mesh");
    let behind = r#"{"camera": {"orthographic": 1.05}, "lights": [{"kind": "directional", "direction": [0, 0, 1]}]}"#;
    scene_of("behind.json", behind, "no light of the scene reaches");
    refused(&[&write("none.json", r#"{"views": []}"#)], "nothing is left to fit");
    refused(&[&write("other.json", "{}")], "must have \"views\"");
    let csv = write("a.csv", "wix,wiy,wiz,wox,woy,woz,r,g,b\n");
    refused(&[&csv, "--mask", good.as_str()], "--mask needs a picture as target");
    refused(&[&csv, "--models", "lambert"], "--models needs --strategy analytic");
}
