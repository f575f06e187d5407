//! Rounding of f64 results.

/// Returns the nearest f32; infinite if the value is beyond f32.
#[inline(always)]
#[expect(clippy::cast_possible_truncation, reason = "rounded to the nearest f32")]
pub(crate) fn round_to_f32(value: f64) -> f32 {
    value as f32
}
