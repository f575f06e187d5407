//! Samples of a material: pairs of directions and what was measured there.

use glam::DVec3;

use crate::DirectionPair;

/// More than this are refused, so that what is made of them fits into memory.
const MOST: usize = 1 << 18;

/// Pairs of directions above the surface, and f of each.
#[derive(Debug, Clone)]
pub struct Samples {
    rows: Vec<(DirectionPair, DVec3)>,
    skipped: usize,
}

/// Why there are no samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum SampleError {
    /// None is left.
    #[error("there is no sample with both directions above the surface ({0} are not)")]
    None(usize),
    /// More than can be held.
    #[error("there are {0} samples; at most {MOST} are read")]
    Many(usize),
    /// A value that is not finite; samples count from 1.
    #[error("the value of sample {0} is not a finite number")]
    Value(usize),
}

impl Samples {
    /// Takes pairs and values in linear red, green and blue, which may be below 0. Pairs with a direction that is not above the surface
    /// are left out and counted.
    pub fn new(mut rows: Vec<(DirectionPair, DVec3)>) -> Result<Self, SampleError> {
        let all = rows.len();
        if all > MOST {
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

    /// Those that are above the surface, in their order.
    #[must_use]
    pub fn rows(&self) -> &[(DirectionPair, DVec3)] {
        &self.rows
    }

    /// How many were left out.
    #[must_use]
    pub fn skipped(&self) -> usize {
        self.skipped
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_lies_below_is_counted_and_nothing_is_no_material() {
        let pair = |z: f64| DirectionPair::new(DVec3::Z, DVec3::Z * z).unwrap();
        let (above, below) = ((pair(1.0), DVec3::ONE), (pair(-1.0), DVec3::ONE));
        let samples = Samples::new(vec![above, below, below]).unwrap();
        assert_eq!((samples.rows().len(), samples.skipped()), (1, 2));
        assert_eq!(Samples::new(vec![below]).unwrap_err(), SampleError::None(1));
        let bad = (pair(1.0), DVec3::new(0.0, f64::NAN, 0.0));
        assert_eq!(Samples::new(vec![above, bad]).unwrap_err(), SampleError::Value(2));
        let many = vec![above; MOST + 1];
        assert_eq!(Samples::new(many).unwrap_err(), SampleError::Many(MOST + 1));
    }
}
