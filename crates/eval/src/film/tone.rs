//! Tone curves: from exposed radiance to display values, channel by channel, before the transfer
//! curve.
//!
//! Each curve is a type, so that loops over pixels are compiled per curve and do not branch per
//! pixel. All arithmetic is f32 in a fixed order, so every way to develop a picture gives the same
//! bits.

use brood_scene::Tone;

/// A tone curve.
pub(super) trait Curve: Copy {
    /// Returns the display value of an exposed value.
    fn apply(self, exposed: f32) -> f32;
}

/// A computation generic over the tone curve, which is only known at run time.
pub(super) trait WithCurve {
    /// Result of the computation.
    type Output;

    /// Runs the computation with a curve.
    fn with<T: Curve>(self, tone: T) -> Self::Output;
}

/// Runs a computation with the curve of that name.
#[inline(always)]
pub(super) fn with_curve<W: WithCurve>(tone: Tone, work: W) -> W::Output {
    match tone {
        Tone::None => work.with(Plain),
        Tone::Reinhard => work.with(Reinhard),
        Tone::Filmic => work.with(Filmic),
    }
}

/// Applies a curve to one value.
pub(super) fn apply(tone: Tone, exposed: f32) -> f32 {
    match tone {
        Tone::None => Plain.apply(exposed),
        Tone::Reinhard => Reinhard.apply(exposed),
        Tone::Filmic => Filmic.apply(exposed),
    }
}

/// The identity; the transfer curve clips values above 1.
#[derive(Clone, Copy)]
pub(super) struct Plain;

/// x / (1 + x), which stays below 1.
///
/// # Source
/// Reinhard, Stark, Shirley and Ferwerda 2002, *Photographic Tone Reproduction for Digital Images*,
/// equation 3, applied per channel.
#[derive(Clone, Copy)]
pub(super) struct Reinhard;

/// A rational fit of the ACES reference transforms: dark values a little darker, highlights rolled
/// off; reaches 1 at 7.2.
///
/// # Source
/// Narkowicz 2015, *ACES Filmic Tone Mapping Curve*.
#[derive(Clone, Copy)]
pub(super) struct Filmic;

impl Curve for Plain {
    #[inline(always)]
    fn apply(self, exposed: f32) -> f32 {
        exposed
    }
}

impl Curve for Reinhard {
    #[inline(always)]
    fn apply(self, exposed: f32) -> f32 {
        let x = clamped(exposed);
        x / (1.0 + x)
    }
}

impl Curve for Filmic {
    #[inline(always)]
    fn apply(self, exposed: f32) -> f32 {
        let x = clamped(exposed);
        (x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14)
    }
}

/// Clamps to 0 and 1e9; NaN becomes 0. The square of 1e9 is finite, and every curve maps it to
/// white.
#[inline(always)]
fn clamped(exposed: f32) -> f32 {
    let x = if exposed > 0.0 { exposed } else { 0.0 };
    if x < 1e9 { x } else { 1e9 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::encode_srgb;

    #[test]
    fn curves_have_the_values_of_their_sources() {
        let cases = [
            (Tone::None, 0.7, 0.7),
            (Tone::Reinhard, 1.0, 0.5),
            (Tone::Reinhard, 3.0, 0.75),
            (Tone::Filmic, 0.0, 0.0),
            (Tone::Filmic, 0.18, 0.266_9),
            (Tone::Filmic, 1.0, 0.803_8),
        ];
        for (tone, exposed, expected) in cases {
            let found = apply(tone, exposed);
            assert!((found - expected).abs() < 1e-4, "{tone:?} {exposed}: {found}");
        }
    }

    #[test]
    fn curves_rise_and_clip_values_out_of_range_to_black_or_white() {
        for tone in [Tone::None, Tone::Reinhard, Tone::Filmic] {
            let codes: Vec<u8> =
                (-200..200).map(|k| encode_srgb(apply(tone, (k as f32 * 0.1).exp2()))).collect();
            assert!(codes.is_sorted(), "{tone:?}");
            assert!((codes[0], codes[399]) == (0, 255), "{tone:?}");
            let ends = [f32::NAN, f32::NEG_INFINITY, -2.0, f32::INFINITY, f32::MAX];
            let ends = ends.map(|x| encode_srgb(apply(tone, x)));
            assert_eq!(ends, [0, 0, 0, 255, 255], "{tone:?}");
        }
    }
}
