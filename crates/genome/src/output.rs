//! The output stage: maps the results of a program, plus the layers, to reflectance.

use crate::{Arithmetic, RANGE};

/// Output stage: maps the squares of the result registers, plus the layers, to reflectance by f =
/// scale (matrix g^2) + offset.
///
/// All values are finite and in [0, 65504], so f is non-negative and finite for any program.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Output {
    matrix: [[f32; 3]; 3],
    scale: [f32; 3],
    offset: [f32; 3],
}

/// Error of [`Output::new`] and [`Output::saturation`].
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum OutputError {
    /// A value is negative, not finite or too large.
    #[error("values of the output stage must be between 0 and 65504, got {0}")]
    OutOfRange(f32),
    /// The saturation is outside [0, 1].
    #[error("saturation must be between 0 and 1, got {0}")]
    Saturation(f32),
}

impl Default for Output {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl Output {
    /// f = g^2.
    pub const IDENTITY: Self = Self {
        matrix: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        scale: [1.0; 3],
        offset: [0.0; 3],
    };

    /// Creates an output stage. Rows of the matrix make red, green and blue.
    ///
    /// # Errors
    /// Returns [`OutputError::OutOfRange`] unless all values are finite and in [0, 65504].
    pub fn new(
        matrix: [[f32; 3]; 3],
        scale: [f32; 3],
        offset: [f32; 3],
    ) -> Result<Self, OutputError> {
        let values = matrix.iter().flatten().chain(&scale).chain(&offset);
        match values.copied().find(|value| !(0.0..=RANGE).contains(value)) {
            Some(value) => Err(OutputError::OutOfRange(value)),
            // Adding +0 turns -0 into 0, so that equal stages have equal bits.
            None => Ok(Self {
                matrix: matrix.map(|row| row.map(|value| value + 0.0)),
                scale: scale.map(|value| value + 0.0),
                offset: offset.map(|value| value + 0.0),
            }),
        }
    }

    /// Creates an output stage that mixes colours with their luminance (Rec. 709 weights): 1 keeps
    /// colours, 0 gives grey.
    ///
    /// # Errors
    /// Returns [`OutputError::Saturation`] if `saturation` is outside [0, 1].
    pub fn saturation(saturation: f32) -> Result<Self, OutputError> {
        const LUMINANCE: [f32; 3] = [0.2126, 0.7152, 0.0722];
        if !(0.0..=1.0).contains(&saturation) {
            return Err(OutputError::Saturation(saturation));
        }
        let mut matrix = [LUMINANCE.map(|weight| (1.0 - saturation) * weight); 3];
        for (channel, row) in matrix.iter_mut().enumerate() {
            row[channel] += saturation;
        }
        Self::new(matrix, [1.0; 3], [0.0; 3])
    }

    /// Returns the output stage with f divided by `divisor`.
    ///
    /// # Domain
    /// `divisor` finite and at least 1.
    ///
    /// # Error
    /// Each value is rounded to the nearest f32.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, reason = "rounded to the nearest f32")]
    pub fn divided(&self, divisor: f64) -> Self {
        let divide = |value: f32| (f64::from(value) / divisor) as f32;
        Self { scale: self.scale.map(divide), offset: self.offset.map(divide), ..*self }
    }

    /// Rows that make red, green and blue.
    #[must_use]
    #[inline]
    pub fn matrix(&self) -> &[[f32; 3]; 3] {
        &self.matrix
    }

    /// Factor of each channel after the matrix.
    #[must_use]
    #[inline]
    pub fn scale(&self) -> &[f32; 3] {
        &self.scale
    }

    /// Offset of each channel, added last.
    #[must_use]
    #[inline]
    pub fn offset(&self) -> &[f32; 3] {
        &self.offset
    }

    /// Maps the squares of the results to reflectance: f = scale (matrix g^2) + offset, with rows
    /// summed from left to right.
    #[inline(always)]
    pub fn apply<T: Arithmetic>(&self, squares: [T; 3]) -> [T; 3] {
        std::array::from_fn(|channel| self.channel(channel, squares))
    }

    /// [`Output::apply`] for channel 0, 1 or 2.
    #[inline(always)]
    pub fn channel<T: Arithmetic>(&self, channel: usize, [red, green, blue]: [T; 3]) -> T {
        let row = self.matrix()[channel].map(T::from_f32);
        let zero = T::from_f32(0.0);
        let mixed = red.output_mul_add(row[0], zero);
        let mixed = green.output_mul_add(row[1], mixed);
        let mixed = blue.output_mul_add(row[2], mixed);
        let scale = T::from_f32(self.scale()[channel]);
        mixed.output_mul_add(scale, T::from_f32(self.offset()[channel]))
    }
}
