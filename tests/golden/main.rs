//! Golden images: `brood render` of committed genomes against committed pictures.
//!
//! A case is a folder with `genome.brood`, `scene.json` and `expected.png`; other PNG files are
//! images that genome and scene name. There is no tolerance: evaluation is bit-exact on every
//! machine and geometry is f64 without platform functions, so any difference is a change of
//! meaning. `cargo xtask golden --update` rewrites the pictures; every run writes a report to
//! target/golden/.

#![expect(
    clippy::unwrap_used,
    reason = "this is a test; clippy only knows those with an attribute"
)]

mod report;

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use brood_tests::{brood, target_directory};
use image::RgbaImage;
use report::Case;

/// Largest committed picture in bytes.
const MAX_BYTES: u64 = 16 * 1024;
/// Side of the pictures in pixels.
const SIZE_PX: &str = "64";

#[test]
fn rendered_pictures_equal_the_committed_ones() {
    let update = std::env::var_os("BROOD_GOLDEN_UPDATE").is_some();
    let report = target_directory().join("golden");
    std::fs::create_dir_all(&report).unwrap();
    let mut cases = Vec::new();
    for folder in folders() {
        cases.push(run(&folder, &report, update));
    }
    assert!(cases.len() >= 6, "there must be at least 6 cases, found {}", cases.len());
    report::write(&report, &cases);
    let failures: Vec<String> = cases
        .iter()
        .filter_map(|case| Some(format!("{}: {}", case.name, case.failure.as_ref()?)))
        .collect();
    let page = report.join("index.html");
    assert!(failures.is_empty(), "{}\nsee {}", failures.join("\n"), page.display());
}

/// Returns the folders of all cases, by name.
fn folders() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("golden");
    let entries = std::fs::read_dir(root).unwrap();
    let mut folders: Vec<PathBuf> =
        entries.map(|entry| entry.unwrap().path()).filter(|path| path.is_dir()).collect();
    folders.sort();
    folders
}

/// Returns the control images of a case: its PNG files but for the expected picture.
fn images(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut images: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    images
        .retain(|path| path.extension() == Some("png".as_ref()) && !path.ends_with("expected.png"));
    images.sort();
    images
}

/// Renders one case, compares or rewrites it, and writes its pictures for the report.
fn run(folder: &Path, report: &Path, update: bool) -> Case {
    let name = folder.file_name().unwrap().to_string_lossy().into_owned();
    let actual_file = report.join(format!("{name}-actual.png"));
    let (genome, scene) = (folder.join("genome.brood"), folder.join("scene.json"));
    let arguments: [&OsStr; 10] = [
        "render".as_ref(),
        genome.as_ref(),
        "--scene".as_ref(),
        scene.as_ref(),
        "--size".as_ref(),
        SIZE_PX.as_ref(),
        "--backend".as_ref(),
        "cpu".as_ref(),
        "-o".as_ref(),
        actual_file.as_ref(),
    ];
    // Removed, so that a picture of an earlier run cannot pass for one of this run.
    if actual_file.exists() {
        std::fs::remove_file(&actual_file).unwrap();
    }
    let images = images(folder);
    let images = images.iter().flat_map(|image| ["--image".as_ref(), image.as_os_str()]);
    brood(arguments.into_iter().chain(images)).success();
    assert!(actual_file.is_file(), "{name}: brood render ended well and wrote nothing");
    let expected_file = folder.join("expected.png");
    if update {
        std::fs::copy(&actual_file, &expected_file).unwrap();
    }
    let failure = compare(&actual_file, &expected_file, report, &name).err();
    Case { name, failure }
}

/// Compares two pictures; writes the difference if there is one.
fn compare(actual: &Path, expected: &Path, report: &Path, name: &str) -> Result<(), String> {
    if !expected.is_file() {
        return Err(
            "there is no expected.png: review the picture, then run cargo xtask golden --update"
                .to_owned(),
        );
    }
    std::fs::copy(expected, report.join(format!("{name}-expected.png"))).unwrap();
    let bytes = std::fs::metadata(expected).unwrap().len();
    if bytes > MAX_BYTES {
        return Err(format!("expected.png must have at most {MAX_BYTES} bytes, got {bytes}"));
    }
    let (actual, expected) = (open(actual), open(expected));
    if actual.dimensions() != expected.dimensions() {
        return Err(format!("{:?} instead of {:?}", actual.dimensions(), expected.dimensions()));
    }
    let (difference, count, worst) = difference(&actual, &expected);
    difference.save(report.join(format!("{name}-difference.png"))).unwrap();
    if count > 0 {
        return Err(format!("{count} pixels differ, by up to {worst} of 255"));
    }
    Ok(())
}

fn open(path: &Path) -> RgbaImage {
    image::open(path).unwrap().to_rgba8()
}

/// Returns the amplified difference, the number of different pixels, and the largest difference of
/// a channel.
fn difference(actual: &RgbaImage, expected: &RgbaImage) -> (RgbaImage, usize, u8) {
    let (mut count, mut worst) = (0, 0);
    let mut drawn = RgbaImage::new(actual.width(), actual.height());
    for ((to, a), b) in drawn.pixels_mut().zip(actual.pixels()).zip(expected.pixels()) {
        let by: [u8; 4] = std::array::from_fn(|channel| a.0[channel].abs_diff(b.0[channel]));
        let most = by.into_iter().max().unwrap_or(0);
        count += usize::from(most > 0);
        worst = worst.max(most);
        let visible = |v: u8| v.saturating_mul(8);
        let alpha = visible(by[3]) / 2;
        to.0 =
            [visible(by[0]).max(alpha), visible(by[1]).max(alpha), visible(by[2]).max(alpha), 255];
    }
    (drawn, count, worst)
}
