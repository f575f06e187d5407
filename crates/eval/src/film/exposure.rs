//! Exposure: the factor of radiance, given or measured, and the tone curve after it.

use brood_program::Program;
use brood_scene::{Exposure, Film, SampleSet, Tone};

use super::srgb::curve;
use super::tone;
use crate::radiance::{RadianceImage, ReflectedLight};
use crate::rounding::round_to_f32;
use crate::{CanonicalEvaluator, Evaluator};

/// Linear value that automatic exposure maps its percentile to.
const AUTO_TARGET: f32 = 0.9;
/// Percentiles below this are black pictures, which get no exposure.
const AUTO_FLOOR: f32 = 1e-8;

/// Factor of radiance and the tone curve after it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gain {
    /// Factor, 2^`ev`.
    pub(crate) factor: f32,
    /// Exposure in stops.
    pub ev: f64,
    /// Tone curve from exposed radiance to display values.
    pub tone: Tone,
}

impl Gain {
    /// Returns the gain of a film for a picture. An exposure is a film without a tone curve.
    ///
    /// # Shapes
    /// As [`crate::shade`].
    #[must_use]
    pub fn new(film: impl Into<Film>, set: &SampleSet, f: &[f32]) -> Self {
        Self::of(film.into(), || ReflectedLight::new(set, f).centres())
    }

    /// Returns the gain of a film for a picture of known radiance.
    #[must_use]
    pub fn of_image(film: impl Into<Film>, image: &RadianceImage) -> Self {
        Self::of(film.into(), || image.centres().to_vec())
    }

    /// Returns the automatic gain of a program for several pictures, such as those of a moving
    /// light: the percentile is taken over the values of all of them.
    #[must_use]
    pub fn common(program: &Program, sets: &[SampleSet]) -> Self {
        let mut values = Vec::new();
        let mut f = Vec::new();
        for set in sets {
            CanonicalEvaluator::default()
                .eval(&[program], set, &mut f)
                .expect("the CPU runs every program");
            values.extend(ReflectedLight::new(set, &f).centres());
        }
        Self::automatic(values)
    }

    /// Returns the gain of a given exposure.
    #[must_use]
    pub fn fixed(ev: f64) -> Self {
        Self { factor: round_to_f32(libm::exp2(ev)), ev, tone: Tone::None }
    }

    /// Returns the same gain with a tone curve.
    #[must_use]
    pub fn with_tone(self, tone: Tone) -> Self {
        Self { tone, ..self }
    }

    /// Returns the codes (sRGB) of a radiance.
    #[must_use]
    pub fn codes(self, radiance: [f32; 3]) -> [u8; 3] {
        radiance.map(|channel| curve().encode(tone::apply(self.tone, channel * self.factor)))
    }

    /// Returns the gain of a film; `centres` is called only for automatic exposure.
    pub(crate) fn of(film: Film, centres: impl FnOnce() -> Vec<f32>) -> Self {
        let gain = match film.exposure {
            Exposure::Auto => Self::automatic(centres()),
            Exposure::Ev(ev) => Self::fixed(ev),
        };
        gain.with_tone(film.tone)
    }

    /// Returns the automatic gain of a picture; `values` are the largest channels of its covered
    /// pixels.
    #[must_use]
    pub fn automatic(values: Vec<f32>) -> Self {
        Self::measured(values).unwrap_or(Self { factor: 1.0, ev: 0.0, tone: Tone::None })
    }

    /// Returns the automatic gain of a picture of known radiance; `None` if it is black.
    #[must_use]
    pub fn of_lit(image: &RadianceImage) -> Option<Self> {
        Self::measured(image.centres().to_vec())
    }

    fn measured(values: Vec<f32>) -> Option<Self> {
        let count = values.len();
        if count == 0 {
            return None;
        }
        let value = ranked(values, (97 * count).div_ceil(100) - 1);
        if value < AUTO_FLOOR {
            return None;
        }
        let factor = AUTO_TARGET / value;
        Some(Self { factor, ev: libm::log2(f64::from(factor)), tone: Tone::None })
    }
}

/// Stride of the values that the guess of the percentile is taken from.
const STRIDE: usize = 32;

/// Returns the value that sorting would put at `rank`.
///
/// The rank is near the end, so only the few values above a guess need to be partitioned.
fn ranked(mut values: Vec<f32>, rank: usize) -> f32 {
    let above = values.len() - rank;
    let mut few: Vec<f32> = values.iter().copied().step_by(STRIDE).collect();
    // Twice as far from the end as the rank: nearly always below the value; the distance does not
    // matter.
    let guess = few.len().saturating_sub(1 + 2 * above / STRIDE);
    let (_, guess, _) = few.select_nth_unstable_by(guess, f32::total_cmp);
    let guess = *guess;
    let largest: Vec<f32> = values.iter().copied().filter(|value| *value >= guess).collect();
    let (values, rank) = if largest.len() >= above {
        let rank = largest.len() - above;
        (largest, rank)
    } else {
        (std::mem::take(&mut values), rank)
    };
    let mut values = values;
    *values.select_nth_unstable_by(rank, f32::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn automatic_exposure_takes_the_97th_percentile_by_its_definition() {
        let values: Vec<f32> = (1..=200u8).map(f32::from).collect();
        // ceil(0.97 * 200) - 1 = 193, the value 194.
        assert_eq!(Gain::automatic(values).factor, 0.9 / 194.0);
        assert_eq!(Gain::automatic(vec![2.0]).factor, 0.45);
        assert_eq!(Gain::automatic(vec![2.0]).ev, libm::log2(f64::from(0.45f32)));
        let none = Gain { factor: 1.0, ev: 0.0, tone: Tone::None };
        assert_eq!(Gain::automatic(Vec::new()), none);
        assert_eq!(Gain::automatic(vec![1e-9; 50]), none);
    }

    #[test]
    fn ranked_value_equals_that_of_sorting_in_every_order() {
        let mut state = 1u32;
        let mut next = move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32
        };
        for count in [1, 2, 31, 32, 33, 100, 3000, 40_000] {
            let random: Vec<f32> = (0..count).map(|_| next()).collect();
            let mut sorted = random.clone();
            sorted.sort_by(f32::total_cmp);
            let mut turned = sorted.clone();
            turned.reverse();
            // The values that the guess is taken from are all larger than the others.
            let unlucky =
                (0..count).map(|k| if k % STRIDE == 0 { 1e9 } else { k as f32 }).collect();
            for values in [random, sorted, turned, vec![3.0; count], unlucky] {
                let mut expected = values.clone();
                expected.sort_by(f32::total_cmp);
                for rank in [0, count / 2, (97 * count).div_ceil(100) - 1, count - 1] {
                    assert_eq!(ranked(values.clone(), rank), expected[rank], "{count} {rank}");
                }
            }
        }
    }
}
