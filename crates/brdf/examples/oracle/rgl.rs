//! RGL's materials against values of another renderer, which computes in f32.

use std::fs::read;
use std::path::Path;

use brood_brdf::{Brdf, Rgl};

use crate::{Failure, Spread, files, pairs};

/// Smallest divisor of relative errors.
const FLOOR: f64 = 1e-4;
/// Bounds of the median, of the 99th percentile and of the largest relative error.
const MEDIAN: f64 = 2e-6;
const MOST: f64 = 3e-4;
const WORST: f64 = 1e-2;

/// Compares all materials. Returns true if they agree. Values below 0 are 0 on both sides.
pub fn check(data: &Path) -> Result<bool, Failure> {
    let mut good = true;
    for (name, path) in files(&data.join("rgl"), ".bsdf")? {
        let rgl = Rgl::read(&read(&path)?)?;
        let mut errors = Vec::new();
        for (pair, wanted) in pairs(&data.join(format!("oracle/rgl_mitsuba_{name}.csv")))? {
            for (found, wanted) in rgl.f(&pair).to_array().into_iter().zip(wanted) {
                let wanted = wanted.max(0.0);
                errors.push((found - wanted).abs() / wanted.max(FLOOR));
            }
        }
        let count = errors.len();
        let spread = Spread::of(errors)?;
        println!("rgl {name}: {count} values, {spread}");
        good &= spread.median <= MEDIAN && spread.most <= MOST && spread.worst <= WORST;
    }
    Ok(good)
}
