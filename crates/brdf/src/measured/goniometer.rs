//! Reader of Cornell's `.brdf` goniometer files: text with wavelengths, then angles and a spectrum
//! for each pair of directions.

use std::f64::consts::PI;
use std::str::SplitAsciiWhitespace;

use glam::DVec3;

use super::sample::{MeasuredSamples, SampleError};
use super::spectrum;
use crate::DirectionPair;

/// Largest number of wavelengths; more than any instrument has in visible light.
const MAX_WAVELENGTHS: usize = 1024;
const ANGLES: usize = 4;
/// Number of lines searched for the signs of Disney's `.brdf` format, which has the same ending.
const HEAD_LINES: usize = 200;

/// Error of [`MeasuredSamples::from_goniometer`]. Rows count from 1 after the wavelengths.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum GoniometerError {
    /// The file is a shader of Disney's BRDF Explorer, not measurements.
    #[error(
        "this .brdf file is a formula in GLSL for Disney's BRDF Explorer; only goniometer measurements are read, as text"
    )]
    Formula,
    /// The file does not begin with a valid number of wavelengths.
    #[error("the file must begin with its number of wavelengths, from 1 to {MAX_WAVELENGTHS}")]
    Count,
    /// A wavelength is missing, not a number, or not above the one before.
    #[error("wavelength {0} is not a number of nanometres above the one before")]
    Wavelength(usize),
    /// A field of a row is not a finite number.
    #[error("row {0}: number {1} of {2} is not a finite number")]
    Number(usize, usize, usize),
    /// The file ends within a row.
    #[error("row {0} has {1} of its {2} numbers")]
    Ends(usize, usize, usize),
    /// A polar angle is too large for radians.
    #[error("row {0}: an angle from the normal is beyond pi; angles are in radians")]
    Angle(usize),
    /// The rows are no valid samples.
    #[error(transparent)]
    Samples(#[from] SampleError),
}

impl MeasuredSamples {
    /// Reads a file; `#` begins a comment. Rows are theta_i, phi_i, theta_o, phi_o in radians
    /// and f at each wavelength. Spectra become linear sRGB in which equal energy is white.
    ///
    /// # Errors
    /// Returns [`GoniometerError`] with the row or wavelength that is wrong.
    pub fn from_goniometer(bytes: &[u8]) -> Result<Self, GoniometerError> {
        let text = String::from_utf8_lossy(bytes);
        if is_formula(&text) {
            return Err(GoniometerError::Formula);
        }
        let mut words = text.lines().flat_map(words);
        let count = words.next().and_then(|word| word.parse().ok());
        let count: usize = count
            .filter(|count| (1..=MAX_WAVELENGTHS).contains(count))
            .ok_or(GoniometerError::Count)?;
        let mut wavelengths = Vec::with_capacity(count);
        for number in 1..=count {
            let least = wavelengths.last().copied().unwrap_or(0.0);
            let nm = words.next().and_then(number_of).filter(|nm| *nm > least);
            wavelengths.push(nm.ok_or(GoniometerError::Wavelength(number))?);
        }
        let weights = spectrum::weights(&wavelengths);
        let mut samples = Vec::new();
        let mut row = Vec::with_capacity(ANGLES + count);
        for word in words {
            let (number, of) = (samples.len() + 1, ANGLES + count);
            let bad = GoniometerError::Number(number, row.len() + 1, of);
            row.push(number_of(word).ok_or(bad)?);
            if row.len() == of {
                samples.push(sample(&row, &weights).ok_or(GoniometerError::Angle(number))?);
                row.clear();
            }
        }
        if !row.is_empty() {
            return Err(GoniometerError::Ends(samples.len() + 1, row.len(), ANGLES + count));
        }
        Ok(Self::new(samples)?)
    }
}

fn is_formula(text: &str) -> bool {
    let mut lines = text.lines().take(HEAD_LINES).map(str::trim_start);
    lines.any(|line| line.starts_with("analytic") || line.starts_with("::begin"))
}

/// Words of a line before its comment.
fn words(line: &str) -> SplitAsciiWhitespace<'_> {
    line.split('#').next().unwrap_or_default().split_ascii_whitespace()
}

fn number_of(word: &str) -> Option<f64> {
    word.parse().ok().filter(|number: &f64| number.is_finite())
}

/// Returns `None` if an angle is too large for radians.
fn sample(row: &[f64], weights: &[DVec3]) -> Option<(DirectionPair, DVec3)> {
    let &[theta_i, phi_i, theta_o, phi_o] = row.first_chunk()?;
    if theta_i.abs().max(theta_o.abs()) > PI + 1e-3 {
        return None;
    }
    let pair = DirectionPair::new(direction(theta_i, phi_i), direction(theta_o, phi_o)).ok()?;
    let rgb = row[ANGLES..].iter().zip(weights).map(|(value, weight)| *value * *weight).sum();
    Some((pair, rgb))
}

fn direction(theta: f64, phi: f64) -> DVec3 {
    let ((sin, cos), (sin_phi, cos_phi)) = (libm::sincos(theta), libm::sincos(phi));
    DVec3::new(sin * cos_phi, sin * sin_phi, cos)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const TEXT: &str = "# A paint\n2 # wls\n500 600.5\n\n0.1 0 0.5 -1 0.25 0.5\n0.2 0 1.5 3 1 1 0.2 0\n1.6 0 9 9\n";

    #[test]
    fn rows_may_span_lines() {
        let samples = MeasuredSamples::from_goniometer(TEXT.as_bytes()).unwrap();
        assert_eq!((samples.rows().len(), samples.skipped()), (2, 1));
        let (pair, rgb) = samples.rows()[0];
        let off = pair.wo() - direction(0.5, -1.0);
        assert!(off.length() < 1e-15 && (pair.cos_i() - 0.1_f64.cos()).abs() < 1e-15);
        // More light at the longer wavelength is redder than a flat spectrum.
        assert!(rgb.x > rgb.z && rgb.min_element() > 0.1, "{rgb}");
        let (_, white) = samples.rows()[1];
        assert!((white - DVec3::ONE).length() < 1e-12);
    }

    #[test]
    fn other_files_are_rejected_with_a_reason() {
        let refused =
            |text: &str| MeasuredSamples::from_goniometer(text.as_bytes()).unwrap_err().to_string();
        let formula =
            "analytic\n\n# a comment\n::begin parameters\ncolor c 1 1 1\n::end parameters\n";
        assert!(refused(formula).contains("a formula in GLSL"));
        assert!(refused("# copyright\n\n  ::begin shader\n").contains("a formula in GLSL"));
        assert!(refused("# nothing").contains("number of wavelengths"));
        assert!(refused("2000").contains("number of wavelengths"));
        assert_eq!(
            refused("2 500"),
            "wavelength 2 is not a number of nanometres above the one before"
        );
        assert_eq!(
            refused("2 500 400"),
            "wavelength 2 is not a number of nanometres above the one before"
        );
        assert_eq!(refused("1 500 0 0 0 0 1 0 0"), "row 2 has 2 of its 5 numbers");
        assert_eq!(refused("1 500 0 0 0 0 1 0 0 x"), "row 2: number 3 of 5 is not a finite number");
        assert_eq!(refused("1 500 0 0 0 0 nan"), "row 1: number 5 of 5 is not a finite number");
        assert!(refused("1 500 0 0 45 0 1").starts_with("row 1: an angle"));
        assert!(refused("1 500").starts_with("no sample has"));
        assert_eq!(
            refused("2 500 600 0 0 0 0 -1e308 1.7e308"),
            "the value of sample 1 is not a finite number"
        );
    }

    #[test]
    fn truncated_files_are_read_or_rejected() {
        for length in 0..TEXT.len() {
            let _ = MeasuredSamples::from_goniometer(&TEXT.as_bytes()[..length]);
        }
    }

    proptest! {
        #[test]
                fn any_bytes_are_read_or_rejected(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            let _ = MeasuredSamples::from_goniometer(&bytes);
            let _ = MeasuredSamples::from_goniometer(&[TEXT.as_bytes(), &bytes].concat());
        }
    }
}
