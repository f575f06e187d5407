//! Models of reflectance on the command line: listed, printed, evaluated, rendered, refused.

use brood_tests::brood;
use tempfile::TempDir;

/// A file of that text, and its name.
fn file(folder: &TempDir, name: &str, text: &str) -> String {
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    path.to_string_lossy().into_owned()
}

/// What a command says that fails.
fn refused(arguments: &[&str]) -> String {
    let finished = brood(arguments);
    assert_eq!(finished.code, 1, "{}", finished.stdout);
    finished.stderr
}

#[test]
fn every_model_that_is_listed_is_printed_and_its_text_is_rendered() {
    let folder = TempDir::new().unwrap();
    let listed: serde_json::Value =
        serde_json::from_str(&brood(["model", "list", "--json"]).success().stdout).unwrap();
    let names = |list: &str| -> Vec<String> {
        let all = listed[list].as_array().unwrap().iter();
        all.map(|entry| entry["name"].as_str().unwrap().to_owned()).collect()
    };
    assert!(names("models").len() >= 15 && names("substances").contains(&"gold".to_owned()));
    for name in names("models").iter().chain(&names("substances")) {
        let text = brood(["model", "show", name]).success().stdout;
        let model = file(&folder, "model.brood", &text);
        let out = folder.path().join(format!("{name}.png")).to_string_lossy().into_owned();
        brood(["render", &model, "--size", "24", "-o", &out]).success();
        let picture = image::open(&out).unwrap().to_rgba8();
        assert!(picture.pixels().any(|pixel| pixel.0[0] > 40), "{name} is black");
        let albedo = brood(["model", "albedo", &model, "--order", "8"]).success().stdout;
        assert_eq!(albedo.lines().count(), 12, "{albedo}");
    }
}

#[test]
fn a_lambert_model_and_a_genome_of_the_same_colour_make_the_same_picture() {
    let folder = TempDir::new().unwrap();
    let model = file(&folder, "model.brood", "brood 1\n.model lambert\nalbedo 0.25 0.25 0.25\n");
    // f = 0.25 / pi
    let genome = "brood 1\n.dialect paper smooth registers 7\n.scale 0.07957747 0.07957747 0.07957747\n\
                  .const C0 1 1 1 0\nMOV R0, C0\n";
    let genome = file(&folder, "genome.brood", genome);
    let picture = |material: &str| {
        let out = folder.path().join("out.png").to_string_lossy().into_owned();
        let how = ["--size", "64", "--exposure", "0", "--mesh", "knob", "--backend", "cpu"];
        brood([&["render", material, "-o", &out][..], &how[..]].concat()).success();
        image::open(&out).unwrap().to_rgba8()
    };
    let (one, other) = (picture(&model), picture(&genome));
    let off = |(a, b): (&u8, &u8)| a.abs_diff(*b) > 1;
    assert!(!one.as_raw().iter().zip(other.as_raw()).any(off), "the pictures differ");
}

#[test]
fn values_are_those_of_the_model_and_bad_files_are_told_by_their_line() {
    let folder = TempDir::new().unwrap();
    let model = file(&folder, "model.brood", "brood 1\n.model lambert\nalbedo 0.5 0.25 1\n");
    let pairs =
        file(&folder, "pairs.csv", "wix,wiy,wiz,wox,woy,woz\n0,0,1,0.6,0,0.8\n0,0,1,0,0,-1\n");
    let found = brood(["eval", &model, &pairs]).success().stdout;
    let rows: Vec<&str> = found.lines().collect();
    assert_eq!(rows[0], "r,g,b");
    let values: Vec<f64> = rows[1].split(',').map(|cell| cell.parse().unwrap()).collect();
    for (value, albedo) in values.iter().zip([0.5, 0.25, 1.0]) {
        assert!((value * std::f64::consts::PI - albedo).abs() < 1e-15, "{found}");
    }
    assert_eq!(rows[2], "0,0,0");
    let bad = file(&folder, "bad.brood", "brood 1\n.model ward\n\nalpha_x 3\n");
    let error = refused(&["render", &bad, "-o", "x.png"]);
    assert!(error.contains("line 4: alpha_x is from 0.001 to 1, not 3"), "{error}");
    let error = refused(&["export", &model]);
    assert!(error.contains("holds a model"), "{error}");
}
