//! Means of f cos_i over the pairs of directions that a pixel shows: under several lights, lights
//! with an area or environments, and in highlights, which differ within a pixel.
//!
//! Owns the shares of directions in each mean. Independent of scenes and pixels.

use std::ops::Range;

use brood_brdf::DirectionPair;
use brood_scene::LightTerms;

/// Means of f cos_i over pairs of directions, each with its measured value. Means share pairs of
/// directions, so a material is evaluated at few pairs for many means.
#[derive(Debug, Clone, Default)]
pub struct LightMeans {
    pairs: Vec<DirectionPair>,
    /// Index of a pair and its share for red, green and blue: the mean is the sum of share times f.
    terms: Vec<(u32, [f32; 3])>,
    /// End of the terms of each mean.
    ends: Vec<usize>,
    values: Vec<MeanValue>,
    is_isotropic: bool,
}

/// Measured value of a mean.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeanValue {
    /// Mean of f cos_i, weighted by the irradiance without cosine; of red, green and blue.
    pub mean: [f64; 3],
    /// True for channels whose mean is known; it is a lower bound for the others.
    pub is_known: [bool; 3],
    /// Pair at the centre of the pixel, and what f would be if it was the same within the pixel;
    /// `None` if several directions of light reach the centre.
    pub centre: Option<(DirectionPair, [f64; 3])>,
}

/// Radiance of a pixel from which a mean is made.
#[derive(Debug, Clone, Copy)]
pub struct PixelRadiance {
    /// Radiance of red, green and blue.
    pub radiance: [f64; 3],
    /// As [`MeanValue::is_known`].
    pub is_known: [bool; 3],
    /// As [`MeanValue::centre`].
    pub centre: Option<(DirectionPair, [f64; 3])>,
}

impl MeanValue {
    /// True if all channels are known.
    #[must_use]
    pub fn is_sample(&self) -> bool {
        self.is_known == [true; 3]
    }
}

impl LightMeans {
    /// Makes the means of pixels from their radiance, one for each pixel of `light`, with channels
    /// that are not known but bounded from below. Pixels without light in one of the channels are
    /// left out; also returns the indices of the others.
    ///
    /// # Panics
    /// If there is another number of radiances than of pixels.
    #[must_use]
    pub fn of_pixels(light: &LightTerms, shown: &[PixelRadiance]) -> (Self, Vec<usize>) {
        assert_eq!(light.pixels.len(), shown.len(), "one radiance for each pixel");
        let (pairs, is_isotropic) = (light.pairs.clone(), light.is_isotropic);
        let mut own = Self { pairs, is_isotropic, ..Self::default() };
        let mut lit = Vec::new();
        for (index, (pixel, shown)) in light.pixels.iter().zip(shown).enumerate() {
            let PixelRadiance { radiance, is_known, centre } = *shown;
            let is_lit = |channel: usize| {
                pixel.normal[channel] > 0.0
                    && pixel.terms.iter().any(|(_, irradiance)| irradiance[channel] > 0.0)
            };
            if !(0..3).all(is_lit) {
                continue;
            }
            let share = |irradiance: [f32; 3]| {
                #[expect(clippy::cast_possible_truncation, reason = "shares are stored as f32")]
                [0, 1, 2].map(|c| (f64::from(irradiance[c]) / pixel.normal[c]) as f32)
            };
            own.terms.extend(pixel.terms.iter().map(|(at, e)| (*at, share(*e))));
            own.ends.push(own.terms.len());
            let mean = [0, 1, 2].map(|c| radiance[c].max(0.0) / pixel.normal[c]);
            own.values.push(MeanValue { mean, is_known, centre });
            lit.push(index);
        }
        (own, lit)
    }

    /// Number of means, lower bounds included.
    #[must_use]
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// True if there are no means.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// Pairs of directions at which a material is evaluated.
    #[must_use]
    pub fn pairs(&self) -> &[DirectionPair] {
        &self.pairs
    }

    /// Measured values.
    #[must_use]
    pub fn values(&self) -> &[MeanValue] {
        &self.values
    }

    /// Terms of a mean: indices of pairs, and shares of f at them for red, green and blue.
    ///
    /// # Panics
    /// If there is no such mean.
    #[must_use]
    pub fn terms(&self, index: usize) -> &[(u32, [f32; 3])] {
        &self.terms[self.range(index)]
    }

    fn range(&self, index: usize) -> Range<usize> {
        let start = if index == 0 { 0 } else { self.ends[index - 1] };
        start..self.ends[index]
    }

    /// Returns the means of a material from its f at the pairs.
    ///
    /// # Panics
    /// If there are not as many values as pairs.
    #[must_use]
    pub fn of(&self, f: &[[f64; 3]]) -> Vec<[f64; 3]> {
        assert_eq!(f.len(), self.pairs.len(), "one value for each pair");
        let mean = |index: usize| {
            let mut sum = [0.0; 3];
            for (at, share) in self.terms(index) {
                let f = f[*at as usize];
                sum = [0, 1, 2].map(|c| sum[c] + f64::from(share[c]) * f[c].max(0.0));
            }
            sum
        };
        (0..self.len()).map(mean).collect()
    }

    /// Returns some of the means, in this order, with the pairs that they refer to.
    ///
    /// # Panics
    /// If there is no mean of an index.
    #[must_use]
    pub fn select(&self, indices: impl IntoIterator<Item = usize>) -> Self {
        let mut own = Self { is_isotropic: self.is_isotropic, ..Self::default() };
        let mut known: Vec<Option<u32>> = vec![None; self.pairs.len()];
        for index in indices {
            for (at, share) in self.terms(index) {
                let pairs = &mut own.pairs;
                let place = known[*at as usize].get_or_insert_with(|| {
                    pairs.push(self.pairs[*at as usize]);
                    u32::try_from(pairs.len() - 1).expect("there are fewer than 2^32 pairs")
                });
                own.terms.push((*place, *share));
            }
            own.ends.push(own.terms.len());
            own.values.push(self.values[index]);
        }
        own
    }

    /// Returns about `count` of the means, evenly picked.
    #[must_use]
    pub fn thinned(&self, count: usize) -> Self {
        let count = count.min(self.len());
        self.select((0..count).map(|k| k * self.len() / count))
    }

    /// Appends the means of another picture.
    pub fn append(&mut self, other: &Self) {
        let first = u32::try_from(self.pairs.len()).expect("there are fewer than 2^32 pairs");
        let start = self.terms.len();
        self.pairs.extend_from_slice(&other.pairs);
        self.terms.extend(other.terms.iter().map(|(at, share)| (first + at, *share)));
        self.ends.extend(other.ends.iter().map(|end| start + end));
        self.values.extend_from_slice(&other.values);
        self.is_isotropic |= other.is_isotropic;
    }

    /// True if the means hold for isotropic materials alone.
    #[must_use]
    pub fn is_isotropic(&self) -> bool {
        self.is_isotropic
    }

    /// Approximate memory use in bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(self.pairs.as_slice())
            + size_of_val(self.terms.as_slice())
            + size_of_val(self.ends.as_slice())
            + size_of_val(self.values.as_slice())
    }

    /// Number of means of which all channels are known.
    #[must_use]
    pub fn samples(&self) -> usize {
        self.values.iter().filter(|value| value.is_sample()).count()
    }
}

#[cfg(test)]
mod tests {
    use brood_scene::PixelTerms;

    use super::*;
    use crate::draw_pairs;

    fn light() -> LightTerms {
        let terms = |of: &[(u32, f32)]| of.iter().map(|(at, e)| (*at, [*e; 3])).collect();
        let pixel = |of: &[(u32, f32)]| PixelTerms { terms: terms(of), normal: [4.0; 3] };
        let pixels = vec![pixel(&[(0, 1.0), (2, 2.0)]), pixel(&[]), pixel(&[(1, 2.0), (2, 1.0)])];
        LightTerms { pairs: draw_pairs(3, 1), pixels, is_isotropic: false }
    }

    fn shown(radiance: f64) -> PixelRadiance {
        PixelRadiance { radiance: [radiance; 3], is_known: [true; 3], centre: None }
    }

    #[test]
    fn means_are_sums_of_shares() {
        let radiance =
            [shown(6.0), shown(1.0), PixelRadiance { is_known: [false; 3], ..shown(8.0) }];
        let (means, lit) = LightMeans::of_pixels(&light(), &radiance);
        assert_eq!((means.len(), means.samples(), lit), (2, 1, vec![0, 2]));
        assert_eq!(means.values()[0].mean, [1.5; 3]);
        let found = means.of(&[[4.0; 3], [8.0; 3], [2.0; 3]]);
        assert_eq!(found, [[2.0; 3], [4.5; 3]]);
        // Negative f counts as 0.
        assert_eq!(means.of(&[[-4.0; 3], [8.0; 3], [2.0; 3]])[0], [1.0; 3]);
    }

    #[test]
    fn selected_and_appended_means_keep_their_values() {
        let radiance = [shown(6.0); 3];
        let (means, _) = LightMeans::of_pixels(&light(), &radiance);
        let second = means.select([1]);
        assert_eq!(second.pairs().len(), 2);
        let mut both = second.clone();
        both.append(&means);
        let f = |pairs: &[DirectionPair]| -> Vec<[f64; 3]> {
            pairs.iter().map(|pair| [pair.cos_i(), pair.cos_o(), 1.0]).collect()
        };
        let all = means.of(&f(means.pairs()));
        assert_eq!(second.of(&f(second.pairs())), [all[1]]);
        assert_eq!(both.of(&f(both.pairs())), [all[1], all[0], all[1]]);
        assert_eq!(means.thinned(1).of(&f(means.thinned(1).pairs())), [all[0]]);
    }
}
