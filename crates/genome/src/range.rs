//! Limits of the arithmetic: the range of results and of the arguments of some functions.

/// Largest magnitude of results; all arithmetic is clamped to `[-RANGE, RANGE]`.
pub const RANGE: f32 = 65504.0;

/// Largest magnitude of arguments of sine and cosine.
pub(crate) const ANGLE_RANGE: f32 = 1024.0;
/// Range of arguments of the power of two.
pub(crate) const EX2_RANGE: (f32, f32) = (-24.0, 16.0);
/// 2^-24, added so that logarithm and reciprocals are finite everywhere.
pub(crate) const EPSILON: f32 = 1.0 / 16_777_216.0;
