//! Offline commands as scripts use them: spawned as processes, checked by files, stdout, stderr and
//! exit code.
#![expect(clippy::unwrap_used, reason = "a test may fail by panicking anywhere")]

use std::path::Path;
use std::process::{Command, Output, Stdio};

use serde_json::json;

fn brood(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_brood"))
        .args(args)
        .stdin(Stdio::null())
        .output()
        .expect("the binary must start")
}

fn succeed(args: &[&str]) -> String {
    let output = brood(args);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{args:?}: {stderr}");
    String::from_utf8(output.stdout).unwrap()
}

/// Returns the single line on stderr of a command that fails with exit code 1.
fn fail(args: &[&str]) -> String {
    let output = brood(args);
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{args:?}: {stderr}");
    let line = stderr.lines().last().unwrap_or_default();
    assert!(line.starts_with("error: ") && stderr.matches("error: ").count() == 1, "{stderr}");
    line.to_owned()
}

fn bred(dir: &Path, options: &[&str]) -> String {
    let mut args = vec!["breed", "--size", "16", "-o", dir.to_str().unwrap()];
    args.extend(options);
    succeed(&args)
}

fn path(dir: &tempfile::TempDir, name: &str) -> String {
    dir.path().join(name).to_str().unwrap().to_owned()
}

#[test]
fn breed_writes_the_same_files_when_the_seed_is_the_same() {
    let (a, b) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let lines = bred(a.path(), &["--seed", "5", "--count", "20"]);
    assert_eq!(lines, bred(b.path(), &["--seed", "5", "--count", "20"]));
    assert_eq!(lines.lines().count(), 20);
    for (slot, line) in lines.lines().enumerate() {
        let words: Vec<&str> = line.split_whitespace().collect();
        assert_eq!(words[0].parse::<usize>().unwrap(), slot);
        assert_eq!(words[1].len(), 64);
        assert!(words[2].parse::<u32>().unwrap() <= 100);
        let file = path(&a, &format!("{slot:02}.brood"));
        if slot % 7 == 0 {
            assert!(succeed(&["inspect", &file]).contains(words[1]), "{file}");
        }
    }
    let sheet = |dir: &tempfile::TempDir| std::fs::read(dir.path().join("sheet.png")).unwrap();
    assert_eq!(sheet(&a), sheet(&b));
    assert!(sheet(&a).starts_with(b"\x89PNG"));
    assert_eq!(std::fs::read_dir(a.path()).unwrap().count(), 21);
}

#[test]
fn breed_reports_a_drawn_seed_that_gives_the_same_children() {
    let (a, b) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let first: serde_json::Value = serde_json::from_str(&bred(a.path(), &["--json"])).unwrap();
    let seed = first["seed"].to_string();
    let again: serde_json::Value =
        serde_json::from_str(&bred(b.path(), &["--json", "--seed", &seed])).unwrap();
    assert_eq!(first, again);
    assert_eq!(first["individuals"].as_array().unwrap().len(), 20);
}

#[test]
fn breed_mutates_and_recombines_parents() {
    let dir = tempfile::tempdir().unwrap();
    bred(dir.path(), &["--seed", "1", "--count", "2"]);
    let (first, second) = (path(&dir, "00.brood"), path(&dir, "01.brood"));
    let children = dir.path().join("children");
    let mutants = bred(&children, &["--seed", "2", "--parent", &first]);
    let crossed = bred(&children, &["--seed", "2", "--parent", &first, "--parent", &second]);
    assert_ne!(mutants, crossed);
    let plain = bred(&children, &["--seed", "2", "--parent", &first, "--isotropic"]);
    assert_ne!(mutants, plain);
    let text = std::fs::read_to_string(children.join("07.brood")).unwrap();
    assert!(text.lines().nth(1).unwrap().ends_with("isotropic"), "{text}");
    fail(&["breed", "--parent", &first, "--mutation", "0", "-o", "unused"]);
    let parents = ["breed", "--parent", &first, "--parent", &second, "--mutation", "0"];
    for (share, done) in [("0", false), ("1", false), ("0.5", true)] {
        let rest = ["--recombination", share, "--size", "16", "-o", &path(&dir, share)];
        let run = brood(&[&parents[..], &rest].concat());
        assert_eq!(run.status.success(), done, "{share}: {run:?}");
    }
    fail(&["breed", "--parent", &first, "--dialect", "paper paper", "-o", "unused"]);
    let small = ["--seed", "2", "--parent", &first, "--mutation", "0.05"];
    let diverse = bred(&children, &[&small[..], &["--curation", "diverse"]].concat());
    assert_ne!(bred(&children, &small), diverse);
}

#[test]
fn breed_follows_a_steer_and_refuses_contradictions() {
    let dir = tempfile::tempdir().unwrap();
    let models = ["--seed", "1", "--count", "2", "--models"];
    bred(dir.path(), &models);
    let parent = path(&dir, "00.brood");
    let children = dir.path().join("children");
    let small = ["--seed", "2", "--count", "4", "--parent", &parent];
    let with = |steer: &str| bred(&children, &[&small[..], &["--steer", steer]].concat());
    let steered = with("keep-colour,rougher");
    assert_eq!(with("keep-colour,rougher"), steered);
    assert_ne!(bred(&children, &small), steered);
    for (steer, words) in [
        ("warmer,cooler", "`cooler` contradicts `warmer`"),
        ("more-pattern", "can vary over the surface"),
    ] {
        let error = fail(&["breed", "--parent", &parent, "--steer", steer, "-o", "unused"]);
        assert!(error.contains(words), "{steer}: {error}");
    }
    let unknown = brood(&["breed", "--parent", &parent, "--steer", "purple", "-o", "unused"]);
    let error = String::from_utf8(unknown.stderr).unwrap();
    assert!(error.contains("must be one of keep-colour, only-gloss"), "{error}");
    let error = fail(&["breed", "--steer", "warmer", "-o", "unused"]);
    assert!(error.contains("needs a parent"), "{error}");
    let off = ["--steer", "warmer", "--curation", "off", "-o", "unused"];
    let error = fail(&[&["breed", "--parent", &parent][..], &off].concat());
    assert!(error.contains("`distinct` or `diverse`"), "{error}");
}

#[test]
fn render_gives_the_same_bytes_twice_and_reads_json_and_text() {
    let dir = tempfile::tempdir().unwrap();
    bred(dir.path(), &["--seed", "3", "--count", "1"]);
    let genome = path(&dir, "00.brood");
    let render = |name: &str, options: &[&str]| {
        let file = path(&dir, name);
        let mut args = vec!["render", &genome, "--size", "32", "-o", &file];
        args.extend(options);
        succeed(&args);
        std::fs::read(&file).unwrap()
    };
    let plain = render("a.png", &[]);
    assert!(plain.starts_with(b"\x89PNG"));
    assert_eq!(plain, render("b.png", &["--backend", "cpu"]));
    assert_ne!(plain, render("c.png", &["--light-deg", "120"]));
    assert_ne!(plain, render("d.png", &["--light", "-3,1,2", "--mesh", "torus"]));
    for (asked, used) in [("20", json!(32)), ("1", json!(1)), ("adaptive", json!("adaptive"))] {
        let picture = path(&dir, "f.png");
        let options = ["--size", "32", "--samples", asked, "--json", "-o", &picture];
        let found = succeed(&[&["render", &genome][..], &options].concat());
        let found: serde_json::Value = serde_json::from_str(&found).unwrap();
        assert_eq!(found["samples_per_pixel"], used, "{asked}");
    }
    assert!(render("e.exr", &[]).starts_with(&[0x76, 0x2f, 0x31, 0x01]));
    let zero = succeed(&["diff", &path(&dir, "a.png"), &path(&dir, "b.png")]);
    assert_eq!(zero, "0\n");
    for metric in ["rmse", "flip", "itp"] {
        let value =
            succeed(&["diff", &path(&dir, "a.png"), &path(&dir, "c.png"), "--metric", metric]);
        let first = value.lines().next().unwrap();
        assert!(first.parse::<f64>().unwrap() > 0.0, "{metric} {value}");
    }
    let reference = render("f.exr", &["--backend", "reference"]);
    assert!(reference.starts_with(&[0x76, 0x2f, 0x31, 0x01]));
    let difference = succeed(&["diff", &path(&dir, "e.exr"), &path(&dir, "f.exr")]);
    assert!(difference.trim().parse::<f64>().unwrap() < 1.0, "{difference}");
}

#[test]
fn flip_is_hdr_flip_of_two_exr_pictures_and_says_so() {
    let dir = tempfile::tempdir().unwrap();
    let picture = |name: &str, value: &dyn Fn(u32, u32) -> f32| {
        let file = path(&dir, name);
        let of = |x: u32, y: u32| image::Rgb([value(x, y), 0.5 * value(x, y), 0.25]);
        let image = image::DynamicImage::ImageRgb32F(image::Rgb32FImage::from_fn(24, 24, of));
        let is_png = name.ends_with(".png");
        if is_png { image::DynamicImage::ImageRgb8(image.to_rgb8()) } else { image }
            .save(&file)
            .unwrap();
        file
    };
    let light = |x: u32, y: u32| (1 + x * y) as f32 / 16.0;
    let reference = picture("reference.exr", &light);
    // Both are white to a display in the changed part.
    let brighter = picture("brighter.exr", &|x, y| light(x, y) * if x > 16 { 1.5 } else { 1.0 });
    let flip = |a: &str, b: &str| succeed(&["diff", a, b, "--metric", "flip"]);
    let text = flip(&reference, &brighter);
    let (value, words) = text.split_once('\n').unwrap();
    assert!(value.parse::<f64>().unwrap() > 0.03, "{text}");
    assert!(words.starts_with("HDR-FLIP, ACES: 3 exposures from -"), "{text}");
    let json = succeed(&["diff", &reference, &brighter, "--metric", "flip", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!((&json["flip"]["range"], &json["flip"]["exposures"]), (&"hdr".into(), &3.into()));
    assert_eq!(json["value"].as_f64().unwrap(), value.parse::<f64>().unwrap());

    let shown = picture("shown.png", &light);
    assert!(flip(&shown, &shown).ends_with("0\nLDR-FLIP of 8-bit sRGB\n"));
    let mixed = flip(&shown, &reference);
    assert!(
        mixed.contains("LDR-FLIP") && mixed.contains("pixels of the EXR are clipped"),
        "{mixed}"
    );

    let negative = picture("negative.exr", &|x, y| if x == 3 { -1.0 } else { light(x, y) });
    assert!(flip(&reference, &negative).contains("negative values of 24 pixels count as 0"));
    let broken = picture("broken.exr", &|x, y| if (x, y) == (2, 5) { f32::NAN } else { 1.0 });
    let line = fail(&["diff", &reference, &broken, "--metric", "flip"]);
    assert!(line.contains("must have finite values, got NaN in red of pixel (2, 5)"), "{line}");
    let black = path(&dir, "black.exr");
    image::DynamicImage::ImageRgb32F(image::Rgb32FImage::new(24, 24)).save(&black).unwrap();
    assert!(fail(&["diff", &black, &reference, "--metric", "flip"]).contains("a pixel above 0"));
}

#[test]
fn render_reads_an_obj_file_and_rejects_a_broken_one() {
    let dir = tempfile::tempdir().unwrap();
    bred(dir.path(), &["--seed", "3", "--count", "1"]);
    let genome = path(&dir, "00.brood");
    let (obj, bad, png) = (path(&dir, "a.obj"), path(&dir, "bad.obj"), path(&dir, "o.png"));
    std::fs::write(&obj, "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    std::fs::write(&bad, "v -1 -1 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    succeed(&["render", &genome, "--size", "24", "--mesh", &obj, "-o", &png]);
    let line = fail(&["render", &genome, "--mesh", &bad, "-o", &path(&dir, "no.png")]);
    assert!(line.contains("line 2"), "{line}");
    assert!(!dir.path().join("no.png").exists());
    fail(&["render", &genome, "-o", &path(&dir, "no.gif")]);
    fail(&["render", &path(&dir, "missing.brood"), "-o", &png]);
}

#[test]
fn eval_prints_shortest_decimals_and_zero_below_the_surface() {
    let dir = tempfile::tempdir().unwrap();
    let (genome, pairs) = (path(&dir, "g.brood"), path(&dir, "p.csv"));
    let text = "brood 1\n.dialect paper smooth registers 7\n.const C0 0.5 0.25 0 0\nMOV R0.xy, C0\nMOV R0.z, R1.z\n";
    std::fs::write(&genome, text).unwrap();
    let rows = "wix,wiy,wiz,wox,woy,woz,u\n0,0,1,0,0,1,0.5\n0,0,1,0,0,-1,0\n0.6,0,0.8,0,1,0,1\n0,0,1,0.6,0,0.8,0.1\n";
    std::fs::write(&pairs, rows).unwrap();
    let expected =
        format!("r,g,b\n0.25,0.0625,0.25\n0,0,0\n0,0,0\n0.25,0.0625,{}\n", 0.1f32 * 0.1f32);
    assert_eq!(succeed(&["eval", &genome, &pairs]), expected);
    let json: serde_json::Value =
        serde_json::from_str(&succeed(&["eval", &genome, &pairs, "--json"])).unwrap();
    assert_eq!(json["f"][0], serde_json::json!([0.25, 0.0625, 0.25]));
    // Blue is u^2, so at u = 1 the albedo is pi.
    let limited: serde_json::Value =
        serde_json::from_str(&succeed(&["eval", &genome, &pairs, "--limit", "--json"])).unwrap();
    let red = limited["f"][0][0].as_f64().unwrap();
    assert!((red - 0.25 / std::f64::consts::PI).abs() < 1e-5, "{limited}");
    std::fs::write(&pairs, "wix,wiy,wiz,wox,woy,woz\n0,0,1,0,0,1\n0,0,1.1,0,0,1\n").unwrap();
    let line = fail(&["eval", &genome, &pairs]);
    assert!(line.contains("row 2"), "{line}");
}

#[test]
fn inspect_shows_counts_and_physics() {
    let dir = tempfile::tempdir().unwrap();
    bred(dir.path(), &["--seed", "9", "--count", "1"]);
    let json = succeed(&["inspect", &path(&dir, "00.brood"), "--json"]);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["physics"]["non_finite"], 0);
    assert_eq!(json["physics"]["not_reciprocal"], 0);
    assert!(json["physics"]["min_f"].as_f64().unwrap() >= 0.0);
    assert_eq!(json["counts"]["instructions"], 100);
    let count = |name: &str| json["counts"][name].as_u64().unwrap();
    assert!(count("inputs_read") > 0 && count("inputs_read") < count("inputs_known"), "{json}");
    assert!((1..=64).contains(&count("registers")), "{json}");
    assert!(count("operations") <= count("live_scalar_operations"), "{json}");
    assert!(count("live_scalar_operations") < count("scalar_operations"), "{json}");
    let line = fail(&["inspect", &path(&dir, "sheet.png")]);
    assert!(line.starts_with("error: "), "{line}");
}

#[test]
fn bad_usage_ends_with_2() {
    for args in [&["breed"][..], &["render", "x"], &["breed", "--count", "257", "-o", "x"], &["x"]]
    {
        assert_eq!(brood(args).status.code(), Some(2), "{args:?}");
    }
    assert!(succeed(&["--version"]).starts_with("brood "));
}

#[test]
fn tokens_are_created_listed_and_revoked() {
    let dir = tempfile::tempdir().unwrap();
    let data = dir.path().to_str().unwrap();
    let token = succeed(&["token", "add", "laptop", "--scope", "breed", "--data", data]);
    assert_eq!(token.trim().len(), 64);
    fail(&["token", "add", "laptop", "--scope", "read", "--data", data]);
    assert_eq!(succeed(&["token", "list", "--data", data]), "breed  laptop\n");
    succeed(&["token", "revoke", "laptop", "--data", data]);
    assert_eq!(succeed(&["token", "list", "--data", data]), "");
    fail(&["token", "revoke", "laptop", "--data", data]);
    let file = path(&dir, "copy.db");
    succeed(&["backup", &file, "--data", data]);
    assert!(std::fs::read(&file).unwrap().starts_with(b"SQLite format 3"));
    fail(&["backup", &file, "--data", data]);
    fail(&["backup", &path(&dir, "x.db"), "--data", &path(&dir, "nothing-here")]);
}

#[test]
fn fit_prints_clipped_codes_of_a_picture_and_refuses_the_setting_without_one() {
    let dir = tempfile::tempdir().unwrap();
    let (metal, scene) = (path(&dir, "metal.brood"), path(&dir, "scene.json"));
    std::fs::write(&metal, succeed(&["model", "show", "conductor"])).unwrap();
    let json = r#"{"mesh": "sphere", "film": {"exposure": 3},
        "lights": [{"kind": "point", "position": [3, 3, 3]}]}"#;
    std::fs::write(&scene, json).unwrap();
    let picture = path(&dir, "picture.png");
    succeed(&["render", &metal, "--scene", &scene, "--size", "48", "-o", &picture]);
    let fit = |clip_from: &str| {
        let out = path(&dir, "fitted");
        let options = ["--scene", &scene, "--strategy", "analytic", "--models", "lambert"];
        let budget = ["--generations", "1", "--clip-from", clip_from, "-o", &out];
        let text = succeed(&[&["fit", &picture][..], &options, &budget].concat());
        let report = std::fs::read(dir.path().join("fitted/report.json")).unwrap();
        (text, serde_json::from_slice::<serde_json::Value>(&report).unwrap())
    };
    let (text, report) = fit("auto");
    assert!(text.contains("pixels clipped, from code red 255"), "{text}");
    assert!(report.to_string().contains(r#""clip_from":"auto""#), "{report}");
    let (text, _) = fit("200");
    assert!(text.contains("from code red 200") && text.contains("(set)"), "{text}");
    assert!(!fit("off").0.contains("pixels clipped"));
    let csv = path(&dir, "samples.csv");
    std::fs::write(&csv, "").unwrap();
    let line = fail(&["fit", &csv, "--clip-from", "250", "-o", &path(&dir, "no")]);
    assert!(line.contains("--clip-from needs a picture as target"), "{line}");
}

#[test]
fn fit_crops_a_picture_and_refuses_a_crop_beyond_it() {
    let dir = tempfile::tempdir().unwrap();
    let (clay, scene) = (path(&dir, "clay.brood"), path(&dir, "scene.json"));
    std::fs::write(&clay, succeed(&["model", "show", "lambert"])).unwrap();
    let json = |half: f64| {
        format!(r#"{{"camera": {{"orthographic": {half}}}, "film": {{"exposure": 0}}}}"#)
    };
    std::fs::write(&scene, json(1.25)).unwrap();
    let (picture, out) = (path(&dir, "picture.exr"), path(&dir, "fitted"));
    succeed(&["render", &clay, "--scene", &scene, "--size", "50x40", "-o", &picture]);
    std::fs::write(&scene, json(0.75)).unwrap();
    let options = ["--scene", &scene, "--strategy", "analytic", "--models", "lambert"];
    let with = |crop: &'static str| {
        let more = ["--generations", "1", "--crop", crop, "-o", &out];
        [&["fit", &picture][..], &options, &more].concat()
    };
    let line = fail(&with("13,8,38,24"));
    assert!(line.contains("the crop 13,8,38,24 must lie within the picture"), "{line}");
    succeed(&with("13,8,24,24"));
    let report = std::fs::read(dir.path().join("fitted/report.json")).unwrap();
    let report: serde_json::Value = serde_json::from_slice(&report).unwrap();
    assert!(report.to_string().contains(r#""crop":[13,8,24,24]"#), "{report}");
    assert!(report["e_log"].as_f64().unwrap() < 1e-3, "{report}");
    let csv = path(&dir, "samples.csv");
    std::fs::write(&csv, "").unwrap();
    let line = fail(&["fit", &csv, "--crop", "0,0,9,9", "-o", &path(&dir, "no")]);
    assert!(line.contains("--crop needs a picture as target"), "{line}");
}
