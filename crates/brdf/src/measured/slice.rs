//! Image slice of a material: reflectance over half angle and difference angle at phi_d = 90
//! degrees.

use std::f64::consts::FRAC_PI_2;

use glam::DVec3;

use super::angle::Angles;
use crate::{Brdf, Claims, DirectionPair};

/// Number of columns and of rows.
const SIDE: usize = 90;

/// A material given by its image slice alone; independent of the difference azimuth.
///
/// # Source
/// Burley 2012, section 4.2, "image slices".
pub struct ImageSlice {
    /// Row by row; columns are half angles, rows are difference angles, at the centres of whole
    /// degrees.
    values: Vec<[f32; 3]>,
}

/// Error of [`ImageSlice::new`].
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ImageSliceError {
    /// Wrong size.
    #[error("a slice must be 90 x 90 values, got {0} x {1}")]
    Size(usize, usize),
    /// A value is not finite.
    #[error("the slice's value in column {column}, row {row} is not a finite number")]
    Value {
        /// Degrees of the half angle.
        column: usize,
        /// Degrees of the difference angle.
        row: usize,
    },
}

impl ImageSlice {
    /// Takes the values row by row; the first row is at a difference angle of half a degree.
    /// Values below 0, which occur for colours outside the display gamut, become 0.
    ///
    /// # Errors
    /// Returns [`ImageSliceError`] if the size is wrong or a value is not finite.
    pub fn new(
        width: usize,
        height: usize,
        mut values: Vec<[f32; 3]>,
    ) -> Result<Self, ImageSliceError> {
        if (width, height) != (SIDE, SIDE) || values.len() != SIDE * SIDE {
            return Err(ImageSliceError::Size(width, height));
        }
        let bad = |rgb: &[f32; 3]| rgb.iter().any(|value| !value.is_finite());
        if let Some(at) = values.iter().position(bad) {
            return Err(ImageSliceError::Value { column: at % SIDE, row: at / SIDE });
        }
        for value in values.as_flattened_mut() {
            *value = value.max(0.0);
        }
        Ok(Self { values })
    }

    /// Bilinear interpolation, clamped at the borders.
    fn at(&self, angles: &Angles) -> DVec3 {
        let degrees = |angle: f64| angle / FRAC_PI_2 * SIDE as f64 - 0.5;
        let (left, across) = split(degrees(angles.theta_h));
        let (top, down) = split(degrees(angles.theta_d));
        let value = |column: usize, row: usize| {
            DVec3::from_array(self.values[row * SIDE + column].map(f64::from))
        };
        let row = |row: usize| value(left, row) * (1.0 - across) + value(left + 1, row) * across;
        row(top) * (1.0 - down) + row(top + 1) * down
    }
}

/// Index of the entry before a position, and the fraction of the way to the next entry.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to 88")]
fn split(at: f64) -> (usize, f64) {
    let at = at.clamp(0.0, (SIDE - 1) as f64);
    let low = (at as usize).min(SIDE - 2);
    (low, at - low as f64)
}

impl Brdf for ImageSlice {
    fn f(&self, pair: &DirectionPair) -> DVec3 {
        Angles::of(pair).map_or(DVec3::ZERO, |angles| self.at(&angles))
    }

    fn claims(&self) -> Claims {
        Claims { reciprocal: true, conserving: false }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_at_the_centres_of_degrees_and_linear_between_them() {
        let values = (0..8100).map(|k| [(k % 90) as f32, (k / 90) as f32, 1.0]).collect();
        let slice = ImageSlice::new(90, 90, values).unwrap();
        let at = |h: f64, d: f64| {
            let angles = Angles { theta_h: h.to_radians(), theta_d: d.to_radians(), phi_d: 1.0 };
            slice.at(&angles)
        };
        for (h, d) in [(0.5, 0.5), (10.0, 20.25), (89.5, 45.0), (33.3, 89.5)] {
            let off = at(h, d) - DVec3::new(h - 0.5, d - 0.5, 1.0);
            assert!(off.length() < 1e-9, "{h} {d} {off}");
        }
        assert_eq!(at(0.0, 90.0), DVec3::new(0.0, 89.0, 1.0));
    }

    #[test]
    fn other_values_are_rejected_with_a_reason() {
        let refused =
            |values: Vec<[f32; 3]>, width| ImageSlice::new(width, 90, values).err().unwrap();
        assert_eq!(refused(vec![[0.0; 3]; 8100], 91), ImageSliceError::Size(91, 90));
        let mut values = vec![[0.0; 3]; 8100];
        values[7] = [0.0, -1.0, 0.0];
        values[183] = [0.0, f32::NAN, 0.0];
        assert_eq!(refused(values, 90), ImageSliceError::Value { column: 3, row: 2 });
    }
}
