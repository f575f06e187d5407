//! Compares the flux of real photometric files with reference values: `ies_lumens FOLDER`.
//!
//! FOLDER has IES files and `reference_lumens.md`, a table with file names in the first column and
//! a column "Photometric Toolbox lumen"; the tolerance is 0.2 %. Files outside the table with
//! `[_ABSOLUTELUMENS]` in the header are compared with that, tolerance 1 %. The exit status is 1 if
//! a file exceeds its tolerance or there are no files.

use std::error::Error;
use std::fs;
use std::path::Path;
use std::process::ExitCode;

use brood_light::IesProfile;

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let folder = std::env::args().nth(1).ok_or("usage: ies_lumens FOLDER")?;
    let folder = Path::new(&folder);
    let references = references(&fs::read_to_string(folder.join("reference_lumens.md"))?);
    let mut files: Vec<_> = fs::read_dir(folder)?
        .filter_map(|entry| entry.ok().map(|entry| entry.path()))
        .filter(|path| path.extension().is_some_and(|extension| extension == "ies"))
        .collect();
    files.sort();
    let mut failed = files.is_empty();
    for path in files {
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned());
        let name = name.unwrap_or_default();
        let bytes = fs::read(&path)?;
        let profile = IesProfile::parse(&bytes)?;
        let reference = references.iter().find(|row| row.0 == name).map(|row| (row.1, 2e-3));
        let reference = reference.or_else(|| header_lumens(&bytes).map(|lumens| (lumens, 1e-2)));
        let lumens = profile.lumens();
        let kind = profile.photometry();
        let Some((expected, tolerance)) = reference else {
            println!("{name}: type {kind:?}, {lumens:.2} lm, no reference");
            continue;
        };
        let error = lumens / expected - 1.0;
        println!(
            "{name}: type {kind:?}, {lumens:.2} lm, stated {expected} lm, error {:+.5} %",
            100.0 * error
        );
        failed |= error.abs() > tolerance;
    }
    Ok(if failed { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

/// Returns names and lumens of the table.
fn references(text: &str) -> Vec<(String, f64)> {
    let cells = |line: &str| -> Vec<String> {
        line.split('|').map(|cell| cell.trim().to_owned()).collect()
    };
    let mut lines = text.lines().filter(|line| line.starts_with('|'));
    let head = lines.next().map(cells).unwrap_or_default();
    let column = head.iter().position(|cell| cell == "Photometric Toolbox lumen");
    let row = |line: &str| {
        let cells = cells(line);
        let lumens = cells.get(column?)?.parse().ok()?;
        Some((cells.get(1)?.clone(), lumens))
    };
    lines.filter_map(row).collect()
}

/// Returns the lumens stated in the header.
fn header_lumens(bytes: &[u8]) -> Option<f64> {
    let text = String::from_utf8_lossy(bytes);
    let line = text.lines().find_map(|line| line.strip_prefix("[_ABSOLUTELUMENS]"))?;
    line.trim().parse().ok()
}
