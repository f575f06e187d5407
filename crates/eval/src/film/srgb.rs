//! sRGB transfer curve to 8 bits by a table of thresholds: exact rounding without a power function
//! at run time.

use std::sync::LazyLock;

/// Table entries per octave: enough that no entry contains two thresholds (the octave below 1 has
/// 67 of them).
const PER_OCTAVE: u32 = 256;
/// Octaves below 1 that the table covers; it begins below the first threshold, 1.5e-4.
const OCTAVES: u32 = 13;
/// Least value of the table.
const TABLE_START: f32 = 1.0 / (1u32 << OCTAVES) as f32;
/// Number of bits of an f32 below those that select the entry.
const MANTISSA_SHIFT: u32 = 23 - PER_OCTAVE.trailing_zeros();

/// Mask of the bits that place a value within its entry.
const LOW_MASK: u32 = (1 << MANTISSA_SHIFT) - 1;
/// Number of entries. Those beyond the octaves only make every index of 12 bits valid.
const ENTRIES: usize = 4096;
/// Position of the code within an entry, above the addend.
const CODE_SHIFT: u32 = 16;

/// The transfer curve as a table. The upper bits of a value select the entry.
pub(super) struct Curve {
    /// For each entry the code at its start, shifted by `CODE_SHIFT`, plus an addend that makes the
    /// low bits of a value carry into the code from the threshold of the entry on: no comparison,
    /// and one load.
    steps: Box<[u32; ENTRIES]>,
}

static CURVE: LazyLock<Curve> = LazyLock::new(Curve::new);

impl Curve {
    fn new() -> Self {
        let thresholds = thresholds();
        let mut steps = Box::new([255 << CODE_SHIFT; ENTRIES]);
        for (step, entry) in steps.iter_mut().zip(0..PER_OCTAVE * OCTAVES) {
            let start = entry_start(entry);
            let code = slow(&thresholds, start);
            *step = u32::from(code) << CODE_SHIFT;
            let next = thresholds[usize::from(code) + 1];
            if next < entry_start(entry + 1) {
                *step += (1 << CODE_SHIFT) - (next.to_bits() & LOW_MASK);
            }
        }
        Self { steps }
    }
}

/// Returns the thresholds: `[k]` is the least linear value that encodes to k; the last is infinite.
fn thresholds() -> [f32; 257] {
    let mut thresholds = [f32::INFINITY; 257];
    for code in 0..=255u8 {
        let encoded = (f64::from(code) - 0.5) / 255.0;
        thresholds[usize::from(code)] = at_least(decode_srgb(encoded.max(0.0)));
    }
    thresholds[0] = f32::NEG_INFINITY;
    thresholds
}

/// Decodes an sRGB value to linear light.
///
/// # Source
/// IEC 61966-2-1, the piecewise electro-optical transfer function.
#[must_use]
pub fn decode_srgb(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) }
}

/// Returns the least f32 that is not below the value.
#[expect(
    clippy::cast_possible_truncation,
    reason = "corrected to the next f32 where it rounded down"
)]
fn at_least(value: f64) -> f32 {
    let rounded = value as f32;
    if f64::from(rounded) < value { rounded.next_up() } else { rounded }
}

/// Returns the least value of an entry.
fn entry_start(entry: u32) -> f32 {
    f32::from_bits(((TABLE_START.to_bits() >> MANTISSA_SHIFT) + entry) << MANTISSA_SHIFT)
}

/// Returns the code of a value by binary search.
fn slow(thresholds: &[f32; 257], value: f32) -> u8 {
    let code = thresholds[..256].partition_point(|threshold| *threshold <= value) - 1;
    u8::try_from(code).expect("256 thresholds")
}

/// Returns the curve, for encoding many values.
pub(super) fn curve() -> &'static Curve {
    &CURVE
}

impl Curve {
    /// As [`encode_srgb`].
    #[inline(always)]
    pub(super) fn encode(&self, value: f32) -> u8 {
        let bits = place(value);
        ((self.step(bits) + (bits & LOW_MASK)) >> CODE_SHIFT) as u8
    }

    /// Encodes many values. Everything but the table look-up is vectorised.
    #[inline(always)]
    pub(super) fn encode_each<const N: usize>(&self, values: &[f32; N]) -> [u32; N] {
        let (mut bits, mut codes) = ([0; N], [0; N]);
        for (bits, value) in bits.iter_mut().zip(values) {
            *bits = place(*value);
        }
        for (code, bits) in codes.iter_mut().zip(&bits) {
            *code = self.step(*bits);
        }
        for (code, bits) in codes.iter_mut().zip(&bits) {
            *code = (*code + (bits & LOW_MASK)) >> CODE_SHIFT;
        }
        codes
    }

    /// Returns the entry of a value by its position in the table.
    #[inline(always)]
    fn step(&self, bits: u32) -> u32 {
        // The mask changes nothing; it shows the compiler that the index is valid.
        self.steps[(bits >> MANTISSA_SHIFT) as usize & (ENTRIES - 1)]
    }
}

/// Returns the position of a value in the table, in steps of f32.
#[inline(always)]
fn place(value: f32) -> u32 {
    // The table begins below the first threshold: values below it, negative values and NaN get code
    // 0.
    let value = if value > TABLE_START { value } else { TABLE_START };
    let value = if value < 1.0 { value } else { 1.0 };
    value.to_bits() - TABLE_START.to_bits()
}

/// Returns the 8-bit sRGB code of a linear value: the curve, times 255, rounded half up.
///
/// # Domain
/// Any number: below 0 and NaN give 0, above 1 gives 255.
///
/// # Error
/// None: the code is the one whose interval contains the value
/// (`every_threshold_is_met_from_both_sides`).
#[must_use]
pub fn encode_srgb(value: f32) -> u8 {
    CURVE.encode(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_table_entry_contains_two_thresholds() {
        let thresholds = thresholds();
        assert!(thresholds[1] > TABLE_START);
        for entry in 0..PER_OCTAVE * OCTAVES {
            let [start, next] = [entry, entry + 1].map(entry_start);
            let inside = thresholds.iter().filter(|t| **t > start && **t <= next).count();
            assert!(inside <= 1, "{start}");
        }
    }

    #[test]
    fn every_threshold_is_met_from_both_sides() {
        let thresholds = thresholds();
        for code in 1..=255u8 {
            let threshold = thresholds[usize::from(code)];
            assert_eq!(encode_srgb(threshold), code);
            assert_eq!(encode_srgb(threshold.next_down()), code - 1);
        }
    }

    #[test]
    fn code_equals_that_of_a_search_for_every_linear_value() {
        let thresholds = thresholds();
        // Every 61st number of the range of the table and beyond: each entry is tested in many
        // places.
        let ends = [TABLE_START * 0.5, 1.5].map(f32::to_bits);
        for bits in (ends[0]..ends[1]).step_by(61) {
            let value = f32::from_bits(bits);
            assert_eq!(encode_srgb(value), slow(&thresholds, value), "{value}");
        }
    }

    #[test]
    fn code_is_the_rounded_transfer_function() {
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
