//! Holds the flux of real photometric files against what others make of them: `ies_lumens FOLDER`.
//!
//! The folder has IES files and `reference_lumens.md`, a table whose first column is a file's name and which has a column
//! "Photometric Toolbox lumen"; those must be met within 0.2 %. A file that says `[_ABSOLUTELUMENS]` in its head and is not
//! in the table must meet that within 1 %. Exit status 1 where one does not.

use std::error::Error;
use std::fs;
use std::path::Path;
use std::process::ExitCode;

use brood_scene::IesProfile;

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
        let stated = references.iter().find(|row| row.0 == name).map(|row| (row.1, 2e-3));
        let stated = stated.or_else(|| header_lumens(&bytes).map(|lumens| (lumens, 1e-2)));
        let lumens = profile.lumens();
        let kind = profile.photometry();
        let Some((expected, bound)) = stated else {
            println!("{name}: type {kind:?}, {lumens:.2} lm, nothing to compare with");
            continue;
        };
        let off = lumens / expected - 1.0;
        println!(
            "{name}: type {kind:?}, {lumens:.2} lm, stated {expected} lm, off by {:+.5} %",
            100.0 * off
        );
        failed |= off.abs() > bound;
    }
    Ok(if failed { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

/// Names and lumens of the table.
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

fn header_lumens(bytes: &[u8]) -> Option<f64> {
    let text = String::from_utf8_lossy(bytes);
    let line = text.lines().find_map(|line| line.strip_prefix("[_ABSOLUTELUMENS]"))?;
    line.trim().parse().ok()
}
