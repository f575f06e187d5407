//! The sRGB transfer curve to 8 bits, by thresholds: exact rounding without a power function at run time.

use std::sync::LazyLock;

/// Table entries per octave: so many that no entry holds two thresholds (the octave below 1 has 67 of them).
const PER_OCTAVE: u32 = 256;
/// Octaves below 1 that the table covers: it begins below the first threshold, 1.5e-4.
const OCTAVES: u32 = 13;
const TABLE_START: f32 = 1.0 / (1u32 << OCTAVES) as f32;
const MANTISSA_SHIFT: u32 = 23 - PER_OCTAVE.trailing_zeros();

pub(super) struct Curve {
    /// `thresholds[k]` is the least linear value that encodes to k; the last is infinite.
    thresholds: [f32; 257],
    /// The code at the start of each table entry.
    start: Vec<u8>,
}

static CURVE: LazyLock<Curve> = LazyLock::new(Curve::new);

impl Curve {
    fn new() -> Self {
        let mut thresholds = [f32::INFINITY; 257];
        for code in 0..=255u8 {
            let encoded = (f64::from(code) - 0.5) / 255.0;
            thresholds[usize::from(code)] = at_least(linear(encoded.max(0.0)));
        }
        thresholds[0] = f32::NEG_INFINITY;
        let entries = PER_OCTAVE * OCTAVES;
        let start = (0..entries).map(|entry| slow(&thresholds, entry_start(entry))).collect();
        Self { thresholds, start }
    }
}

/// The sRGB electro-optical transfer function (IEC 61966-2-1, piecewise).
fn linear(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) }
}

/// The least f32 that is not below the value.
#[expect(
    clippy::cast_possible_truncation,
    reason = "corrected to the next f32 where it rounded down"
)]
fn at_least(value: f64) -> f32 {
    let rounded = value as f32;
    if f64::from(rounded) < value { rounded.next_up() } else { rounded }
}

fn entry_start(entry: u32) -> f32 {
    f32::from_bits(((TABLE_START.to_bits() >> MANTISSA_SHIFT) + entry) << MANTISSA_SHIFT)
}

fn slow(thresholds: &[f32; 257], value: f32) -> u8 {
    let code = thresholds[..256].partition_point(|threshold| *threshold <= value) - 1;
    u8::try_from(code).expect("256 thresholds")
}

/// The curve, for those who encode many values.
pub(super) fn curve() -> &'static Curve {
    &CURVE
}

impl Curve {
    /// See [`encode_srgb`].
    #[inline]
    pub(super) fn encode(&self, value: f32) -> u8 {
        if value >= 1.0 {
            return 255;
        }
        // The table begins below the first threshold: what is darker, negative or NaN is code 0.
        if value < TABLE_START || value.is_nan() {
            return 0;
        }
        let entry = (value.to_bits() >> MANTISSA_SHIFT) - (TABLE_START.to_bits() >> MANTISSA_SHIFT);
        let code = self.start[entry as usize];
        code + u8::from(self.thresholds[usize::from(code) + 1] <= value)
    }
}

/// The 8-bit sRGB code of a linear value: the curve, times 255, rounded half up.
///
/// # Domain
/// Any number: below 0 and NaN give 0, above 1 gives 255.
///
/// # Error
/// None: the code is the one whose interval holds the value (`every_threshold_is_met_from_both_sides`).
#[must_use]
pub fn encode_srgb(value: f32) -> u8 {
    CURVE.encode(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_table_entry_holds_two_thresholds() {
        assert!(CURVE.thresholds[1] > TABLE_START);
        for pair in CURVE.start.windows(2) {
            assert!(pair[1] - pair[0] <= 1);
        }
    }

    #[test]
    fn every_threshold_is_met_from_both_sides() {
        for code in 1..=255u8 {
            let threshold = CURVE.thresholds[usize::from(code)];
            assert_eq!(encode_srgb(threshold), code);
            assert_eq!(encode_srgb(threshold.next_down()), code - 1);
        }
    }

    #[test]
    fn curve_is_the_rounded_transfer_function() {
        for step in 0..=20_000u16 {
            let value = f32::from(step) / 20_000.0;
            let v = f64::from(value);
            let encoded =
                if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
            let distance = (encoded * 255.0 - f64::from(encode_srgb(value))).abs();
            assert!(distance <= 0.500_1, "{value}: {distance}");
        }
        assert_eq!([f32::NAN, -1.0, 1e9, 0.0].map(encode_srgb), [0, 0, 255, 0]);
    }
}
