//! Samples of a material: pairs of directions with the measured f.

use glam::DVec3;

use crate::DirectionPair;

/// Largest number of samples; bounds the memory of everything derived from them.
const MAX_SAMPLES: usize = 1 << 18;

/// Measured values of f at pairs of directions above the surface.
#[derive(Debug, Clone)]
pub struct MeasuredSamples {
    rows: Vec<(DirectionPair, DVec3)>,
    skipped: usize,
}

/// Error of [`MeasuredSamples::new`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum SampleError {
    /// No sample is above the surface.
    #[error("no sample has both directions above the surface ({0} skipped)")]
    None(usize),
    /// Too many samples.
    #[error("at most {MAX_SAMPLES} samples are allowed, got {0}")]
    Many(usize),
    /// A value is not finite; samples count from 1.
    #[error("the value of sample {0} is not a finite number")]
    Value(usize),
}

impl MeasuredSamples {
    /// Takes pairs with values of f in linear red, green and blue, which may be below 0. Skips
    /// and counts pairs with a direction below the surface.
    ///
    /// # Errors
    /// Returns [`SampleError`] if there are too many samples, a value is not finite, or no
    /// sample is above the surface.
    pub fn new(mut rows: Vec<(DirectionPair, DVec3)>) -> Result<Self, SampleError> {
        let all = rows.len();
        if all > MAX_SAMPLES {
            return Err(SampleError::Many(all));
        }
        if let Some(at) = rows.iter().position(|(_, rgb)| !rgb.is_finite()) {
            return Err(SampleError::Value(at + 1));
        }
        rows.retain(|(pair, _)| pair.cos_i() > 0.0 && pair.cos_o() > 0.0);
        let skipped = all - rows.len();
        if rows.is_empty() {
            return Err(SampleError::None(skipped));
        }
        Ok(Self { rows, skipped })
    }

    /// Samples above the surface, in the given order.
    #[must_use]
    pub fn rows(&self) -> &[(DirectionPair, DVec3)] {
        &self.rows
    }

    /// Number of samples that were skipped.
    #[must_use]
    pub fn skipped(&self) -> usize {
        self.skipped
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_below_the_surface_are_counted_and_no_samples_are_an_error() {
        let pair = |z: f64| DirectionPair::new(DVec3::Z, DVec3::Z * z).unwrap();
        let (above, below) = ((pair(1.0), DVec3::ONE), (pair(-1.0), DVec3::ONE));
        let samples = MeasuredSamples::new(vec![above, below, below]).unwrap();
        assert_eq!((samples.rows().len(), samples.skipped()), (1, 2));
        assert_eq!(MeasuredSamples::new(vec![below]).unwrap_err(), SampleError::None(1));
        let bad = (pair(1.0), DVec3::new(0.0, f64::NAN, 0.0));
        assert_eq!(MeasuredSamples::new(vec![above, bad]).unwrap_err(), SampleError::Value(2));
        let many = vec![above; MAX_SAMPLES + 1];
        assert_eq!(MeasuredSamples::new(many).unwrap_err(), SampleError::Many(MAX_SAMPLES + 1));
    }
}
