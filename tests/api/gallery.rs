//! The gallery in docs is up to date, names every model and kind of light, and stays small.

use std::path::{Path, PathBuf};

use brood_tests::brood;
use tempfile::TempDir;

/// Largest total size of the pictures.
const BYTES: u64 = 600_000;
/// Largest difference of a pixel: encoded values may lie on the edge between two bytes.
const CODES: u8 = 1;

fn docs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs")
}

/// Returns the pictures that a page shows.
fn shown(page: &str) -> Vec<&str> {
    page.split("](")
        .skip(1)
        .filter_map(|rest| rest.split(')').next())
        .filter(|it| it.ends_with(".png"))
        .collect()
}

#[test]
fn gallery_equals_the_output_of_the_command() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().to_string_lossy().into_owned();
    brood(["model", "gallery", "-o", &out]).success();
    let page = std::fs::read_to_string(docs().join("gallery.md")).unwrap();
    let again = "run `brood model gallery -o docs` and commit the result";
    let made = std::fs::read_to_string(folder.path().join("gallery.md")).unwrap();
    assert!(page == made, "docs/gallery.md is out of date: {again}");
    let mut bytes = 0;
    for name in shown(&page) {
        let (kept, made) = (docs().join(name), folder.path().join(name));
        bytes += std::fs::metadata(&kept).map(|file| file.len()).unwrap_or_default();
        let pixels = |path: &Path| image::open(path).map(|it| it.to_rgba8().into_raw());
        let kept = pixels(&kept).unwrap_or_else(|error| panic!("{name}: {error}; {again}"));
        let made = pixels(&made).unwrap();
        let off = |(a, b): (&u8, &u8)| a.abs_diff(*b) > CODES;
        let same = kept.len() == made.len() && !kept.iter().zip(&made).any(off);
        assert!(same, "{name} looks different: {again}");
    }
    assert!(bytes < BYTES, "the pictures take {bytes} bytes");
}

#[test]
fn gallery_names_every_model_and_every_kind_of_light() {
    let page = std::fs::read_to_string(docs().join("gallery.md")).unwrap();
    let listed: serde_json::Value =
        serde_json::from_str(&brood(["model", "list", "--json"]).success().stdout).unwrap();
    for list in ["models", "substances"] {
        for entry in listed[list].as_array().unwrap() {
            let name = entry["name"].as_str().unwrap();
            assert!(page.contains(&format!("| **{name}**: ")), "{name} is not in docs/gallery.md");
            assert!(shown(&page).contains(&&*format!("pictures/gallery/{name}.png")), "{name}");
        }
    }
    let lights = std::fs::read_to_string(docs().join("maths/lights.md")).unwrap();
    let (_, kinds) = lights.split_once("## Kinds").unwrap();
    let (_, kinds) = kinds.split_once("|---|---|\n").unwrap();
    let (kinds, _) = kinds.split_once("\n\n").unwrap();
    let rows = kinds.lines().filter(|row| row.starts_with("| `"));
    let kinds: Vec<&str> = rows
        .flat_map(|row| row.split('|').nth(1).unwrap_or("").split('`').skip(1).step_by(2))
        .collect();
    assert!(kinds.len() >= 9, "{kinds:?}");
    for kind in kinds {
        assert!(
            page.contains(&format!("| **light-{kind}**: ")),
            "{kind} is not in docs/gallery.md"
        );
    }
}
