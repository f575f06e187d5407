//! Tone curves: from exposed radiance to what is shown, channel by channel, before the transfer curve.
//!
//! Each is a type of its own, so that loops over pixels know theirs and no pixel asks which one it is. All arithmetic is in
//! f32 and in one order: every way to develop a picture gives the same bits.

use brood_scene::Tone;

/// A tone curve.
pub(super) trait Curve: Copy {
    /// The value that is shown for an exposed one.
    fn apply(self, exposed: f32) -> f32;
}

/// What uses a tone curve that is only known at run time.
pub(super) trait WithCurve {
    /// What comes of it.
    type Done;

    /// Does it.
    fn with<T: Curve>(self, tone: T) -> Self::Done;
}

/// Does something with the curve of that name.
#[inline(always)]
pub(super) fn with_curve<W: WithCurve>(tone: Tone, work: W) -> W::Done {
    match tone {
        Tone::None => work.with(Plain),
        Tone::Reinhard => work.with(Reinhard),
        Tone::Filmic => work.with(Filmic),
    }
}

/// One value.
pub(super) fn apply(tone: Tone, exposed: f32) -> f32 {
    match tone {
        Tone::None => Plain.apply(exposed),
        Tone::Reinhard => Reinhard.apply(exposed),
        Tone::Filmic => Filmic.apply(exposed),
    }
}

/// Nothing; what is above 1 is clipped by the transfer curve.
#[derive(Clone, Copy)]
pub(super) struct Plain;

/// x / (1 + x): 1 is reached nowhere.
///
/// # Source
/// Reinhard, Stark, Shirley and Ferwerda 2002, *Photographic Tone Reproduction for Digital Images*, equation 3, for each
/// channel.
#[derive(Clone, Copy)]
pub(super) struct Reinhard;

/// A rational fit of the ACES reference transforms: dark values a little darker, highlights rolled off; 1 is reached at 7.2.
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
        let x = held(exposed);
        x / (1.0 + x)
    }
}

impl Curve for Filmic {
    #[inline(always)]
    fn apply(self, exposed: f32) -> f32 {
        let x = held(exposed);
        (x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14)
    }
}

/// From 0, which NaN becomes too, to a number whose square is finite and which every curve shows as white.
#[inline(always)]
fn held(exposed: f32) -> f32 {
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
    fn curves_rise_and_show_what_is_out_of_range_as_black_or_white() {
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
