//! Compares models and readers of measurements with values of other implementations: `cargo run
//! --release -p brood-brdf --example oracle -- DATA`.
//!
//! DATA holds published fits (`tables/`), measured materials (`rgl/`, `cornell/`) and, for some of
//! them, pairs of directions with f computed by another implementation (`oracle/*.csv`,
//! `cornell/*.csv`). Each comparison prints its errors. The exit code is 1 if one exceeds its
//! bounds.

mod fit;
mod goniometer;
mod held_out;
mod rgl;

use std::fs::{read_dir, read_to_string};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use brood_brdf::DirectionPair;
use glam::DVec3;

type Failure = Box<dyn std::error::Error>;
type Row = (DirectionPair, [f64; 3]);

fn main() -> ExitCode {
    let Some(data) = std::env::args().nth(1) else {
        eprintln!("oracle: expected the folder of the data as argument");
        return ExitCode::from(2);
    };
    match run(Path::new(&data)) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("oracle: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(data: &Path) -> Result<bool, Failure> {
    let fits = fit::check(data)?;
    let rgl = rgl::check(data)?;
    let goniometer = goniometer::check(data)?;
    let held_out = held_out::check(data)?;
    Ok(fits && rgl && goniometer && held_out)
}

/// Reads pairs of directions with f.
fn pairs(path: &Path) -> Result<Vec<Row>, Failure> {
    let text = read_to_string(path)?;
    let row = |line: &str| {
        let cells: Result<Vec<f64>, _> = line.split(',').map(str::parse).collect();
        let [a, b, c, d, e, f, red, green, blue] =
            cells?.try_into().map_err(|_| "no nine cells")?;
        let pair = DirectionPair::new(DVec3::new(a, b, c), DVec3::new(d, e, f))?;
        Ok((pair, [red, green, blue]))
    };
    text.lines().skip(1).filter(|line| !line.is_empty()).map(row).collect()
}

/// Lists the files of a folder with an ending, as (name without the ending, path), sorted.
fn files(folder: &Path, ending: &str) -> Result<Vec<(String, PathBuf)>, Failure> {
    let mut found = Vec::new();
    for entry in read_dir(folder)? {
        let path = entry?.path();
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        if let Some(stem) = name.strip_suffix(ending) {
            found.push((stem.to_owned(), path.clone()));
        }
    }
    found.sort();
    Ok(found)
}

/// Distribution of relative errors.
struct Spread {
    median: f64,
    most: f64,
    worst: f64,
}

impl Spread {
    /// Requires at least one error; `most` is the 99th percentile.
    fn of(mut errors: Vec<f64>) -> Result<Self, Failure> {
        errors.sort_by(f64::total_cmp);
        let worst = *errors.last().ok_or("nothing was compared")?;
        let median = errors[errors.len() / 2];
        Ok(Self { median, most: errors[errors.len() * 99 / 100], worst })
    }
}

impl std::fmt::Display for Spread {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { median, most, worst } = self;
        write!(f, "median {median:.1e}, 99 % {most:.1e}, worst {worst:.1e}")
    }
}
