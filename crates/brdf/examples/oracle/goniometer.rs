//! Rows of Cornell's files as directions and colours, against the output of another program with
//! seven digits.

use std::fs::read;
use std::path::Path;

use brood_brdf::{Brdf, MeasuredSamples, Scattered};

use crate::{Failure, files, pairs};

/// Bounds of direction components, and of colours relative to the largest channel of the row.
const DIRECTION: f64 = 2e-6;
const COLOR: f64 = 2e-6;
/// Smallest divisor of relative colour errors.
const FLOOR: f64 = 1e-6;

/// Compares all materials. Returns true if the rows agree and the interpolation passes through
/// them.
pub fn check(data: &Path) -> Result<bool, Failure> {
    let folder = data.join("cornell");
    let mut good = true;
    for (name, path) in files(&folder, ".brdf")? {
        let samples = MeasuredSamples::from_goniometer(&read(&path)?)?;
        let scattered = Scattered::new(&samples);
        let wanted = pairs(&folder.join(format!("{name}_rgb.csv")))?;
        let (mut direction, mut color, mut through) = (0.0_f64, 0.0_f64, 0.0_f64);
        for ((pair, rgb), (other, wanted)) in samples.rows().iter().zip(&wanted) {
            let off = (pair.wi() - other.wi()).abs().max((pair.wo() - other.wo()).abs());
            direction = direction.max(off.max_element());
            let largest = rgb.abs().max_element().max(FLOOR);
            color =
                color.max((*rgb - glam::DVec3::from_array(*wanted)).abs().max_element() / largest);
            let off = (scattered.f(pair) - rgb.max(glam::DVec3::ZERO)).abs().max_element();
            through = through.max(off / largest);
        }
        println!(
            "goniometer {name}: {} rows, directions within {direction:.1e}, colours within {color:.1e}, interpolated {through:.1e}",
            samples.rows().len()
        );
        let same = samples.rows().len() == wanted.len() && samples.skipped() == 0;
        good &= same && direction <= DIRECTION && color <= COLOR && through <= COLOR;
    }
    Ok(good)
}
