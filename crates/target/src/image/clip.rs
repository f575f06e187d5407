//! Detection of clipped pixels: those at the largest value that a picture can show, also after
//! noise or lossy compression has spread that value over several codes.

use std::ops::RangeInclusive;

use brood_eval::{LinearPicture, encode_srgb};
use brood_scene::ClipFrom;

use super::pixel::around;
use super::refusal::ImageTargetError;

/// Least code at the top of a plateau. A darker one is a surface of uniform colour.
const LEAST_TOP: u8 = 240;
/// Codes below the top that a plateau may reach down to.
const DEPTH: u8 = 12;
/// Codes below the plateau whose counts say how many pixels a picture without clipping would have.
const BELOW: RangeInclusive<u8> = DEPTH + 1..=DEPTH + 32;
/// Least number of pixels of a plateau.
const FEWEST: f64 = 12.0;
/// Least ratio of the pixels of a plateau to those expected from the codes below.
const HEAP: f64 = 4.0;
/// Share of code 255 in a plateau from which it is clipped at 255: noise before clipping, or a
/// surface that is darker than the clipping level, has less.
const AT_LARGEST: f64 = 0.5;
/// Share of the lit pixels up to which a part of a plateau is given up without further evidence.
const SMALL: f64 = 0.02;
/// Share of the lit pixels above which the evidence for a part must be strong.
const LARGE: f64 = 0.25;
/// Largest slope of ln radiance over ln irradiance within a part, and its largest standard error. A
/// matt surface has 1, a clipped part 0.
const FLAT: (f64, f64) = (0.5, 0.25);
/// The same within a large part: rough surfaces that are lit from the eye have 0.1 and more.
const VERY_FLAT: (f64, f64) = (0.05, 0.02);
/// Least deviation of ln radiance from the line: rounding to codes.
const ROUNDING: f64 = 0.003;
/// Least step of half floats below 1; files of them store 1 exactly or one step less.
const HALF_STEP: f32 = 1.0 / 2048.0;
/// Distance in pixels up to which pixels of a part are connected, so that noise does not split it.
const REACH: usize = 2;

/// Pixel with respect to clipping.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Clip {
    /// Not clipped.
    Free,
    /// Clipped: its value is a lower bound.
    Bound,
    /// Beside a plateau: neither a value nor a bound, because noise, interpolation or compression
    /// mixes it with clipped pixels.
    Beside,
}

/// Marks of a picture's pixels.
pub(super) struct Clipping {
    pub pixels: Vec<Clip>,
    /// Code from which each channel is clipped; `None` if it is not.
    pub from: [Option<u8>; 3],
}

impl Clipping {
    /// Marks the pixels of a picture by a setting. `radiance` is that of the picture, up to a
    /// factor; `irradiance` is known at pixels that show the lit object.
    ///
    /// # Errors
    /// Returns [`ImageTargetError::ClipFrom`] if a code is set for a picture of linear light.
    pub(super) fn of(
        setting: ClipFrom,
        picture: &LinearPicture,
        radiance: &[[f64; 3]],
        irradiance: &[Option<[f32; 3]>],
    ) -> Result<Self, ImageTargetError> {
        let at_largest = picture.clipped.iter();
        let mut pixels: Vec<Clip> =
            at_largest.map(|clipped| if *clipped { Clip::Bound } else { Clip::Free }).collect();
        let largest = |pixels: &[Clip]| {
            // Codes of channels with 255 in a pixel that is clipped.
            [0, 1, 2].map(|channel| {
                let mut all = pixels.iter().zip(&picture.pixels);
                let is_at = |(clip, rgb): (&Clip, &[f32; 3])| {
                    *clip == Clip::Bound && encode_srgb(rgb[channel]) == u8::MAX
                };
                all.any(is_at).then_some(u8::MAX)
            })
        };
        let from = match setting {
            ClipFrom::Off => {
                pixels.fill(Clip::Free);
                [None; 3]
            }
            ClipFrom::LARGEST => largest(&pixels),
            ClipFrom::Code(code) if picture.is_linear => {
                return Err(ImageTargetError::ClipFrom(code));
            }
            ClipFrom::Code(code) => {
                let mut from = [None; 3];
                for (rgb, clip) in picture.pixels.iter().zip(&mut pixels) {
                    for channel in 0..3 {
                        if encode_srgb(rgb[channel]) >= code {
                            (*clip, from[channel]) = (Clip::Bound, Some(code));
                        }
                    }
                }
                from
            }
            ClipFrom::Auto if picture.is_linear => {
                mark_ones(picture, irradiance, &mut pixels);
                largest(&pixels)
            }
            ClipFrom::Auto => {
                let raw = largest(&pixels);
                let codes: Vec<[u8; 3]> =
                    picture.pixels.iter().map(|rgb| rgb.map(encode_srgb)).collect();
                let size = (picture.width as usize, picture.height as usize);
                let coded = Coded { size, codes: &codes, radiance, irradiance };
                let found = coded.mark(&mut pixels);
                [0, 1, 2].map(|channel| found[channel].or(raw[channel]))
            }
        };
        Ok(Self { pixels, from })
    }
}

/// Marks the pixels of a picture of linear light that was clipped at 1: a channel's largest value,
/// in several pixels.
fn mark_ones(picture: &LinearPicture, irradiance: &[Option<[f32; 3]>], marks: &mut [Clip]) {
    for channel in 0..3 {
        let lit = picture.pixels.iter().zip(irradiance).enumerate();
        let lit = lit.filter(|(_, (_, irradiance))| irradiance.is_some());
        let lit: Vec<(usize, f32)> = lit.map(|(at, (rgb, _))| (at, rgb[channel])).collect();
        let is_one = |value: f32| (value - 1.0).abs() <= HALF_STEP;
        let ones: Vec<usize> =
            lit.iter().filter(|(_, value)| is_one(*value)).map(|(at, _)| *at).collect();
        let is_largest = lit.iter().all(|(_, value)| *value <= 1.0 + HALF_STEP);
        if is_largest && ones.len() as f64 >= FEWEST {
            ones.into_iter().for_each(|at| marks[at] = Clip::Bound);
        }
    }
}

/// Picture of 8-bit codes, for detection.
struct Coded<'a> {
    size: (usize, usize),
    /// Codes of red, green and blue.
    codes: &'a [[u8; 3]],
    /// Radiance, up to a factor.
    radiance: &'a [[f64; 3]],
    /// Irradiance of the pixels that show the lit object; `None` for the others.
    irradiance: &'a [Option<[f32; 3]>],
}

impl Coded<'_> {
    /// Marks plateaus at the top of each channel as clipped; returns the code that each one begins
    /// at.
    ///
    /// A channel has a plateau if its largest codes have several times as many pixels as those
    /// below explain. A connected part of it counts as clipped if most of it is at 255, if it is
    /// small, or if its radiance stays the same while its irradiance varies, unlike a matt surface.
    fn mark(&self, marks: &mut [Clip]) -> [Option<u8>; 3] {
        let mut labels = vec![0u32; self.codes.len()];
        [0, 1, 2].map(|channel| {
            let lit = self.irradiance.iter().filter(|irradiance| irradiance.is_some()).count();
            let from = self.plateau(channel)?;
            let parts = self.parts(channel, from, &mut labels);
            let clipped = parts.iter().filter(|part| self.is_clipped(part, channel, lit));
            let clipped: Vec<usize> = clipped.flatten().copied().collect();
            for &pixel in &clipped {
                marks[pixel] = Clip::Bound;
            }
            // Codes that are spread also spoil the pixels beside them. Beside a plateau of code 255
            // alone, only codes that compression may have lowered are suspicious.
            let least = if from < u8::MAX { 0 } else { from - DEPTH };
            self.mark_beside(&clipped, (channel, least), marks);
            (!clipped.is_empty()).then_some(from)
        })
    }

    /// Returns the least code of the heap at the top of the histogram.
    fn plateau(&self, channel: usize) -> Option<u8> {
        let mut histogram = [0.0; 256];
        for (codes, _) in self.lit() {
            histogram[usize::from(codes[channel])] += 1.0;
        }
        // Single bright pixels are no top.
        let lit: f64 = histogram.iter().sum();
        let mut above = 0.0;
        let top = (0..256).rev().find(|code| {
            above += histogram[*code];
            above >= f64::max(4.0, lit / 2000.0)
        })?;
        if top < usize::from(LEAST_TOP) {
            return None;
        }
        // Smoothed, because pictures that were stretched lack every other code.
        let mean = |code: usize| {
            let around = code.saturating_sub(2)..(code + 3).min(256);
            let count = around.len() as f64;
            histogram[around].iter().sum::<f64>() / count
        };
        let mut below: Vec<f64> = BELOW.map(|depth| mean(top - usize::from(depth))).collect();
        below.sort_unstable_by(f64::total_cmp);
        let expected = below[below.len() / 2];
        let most = 2.0 * expected + 3.0 * expected.sqrt() + 1.0;
        let deepest = top - usize::from(DEPTH);
        let mode = (deepest..256).max_by(|a, b| histogram[*a].total_cmp(&histogram[*b]))?;
        let is_heap =
            |code: usize| histogram[code] > most || (code > 0 && histogram[code - 1] > most);
        let from = (deepest..=mode).rev().take_while(|code| is_heap(*code)).last()?;
        let heap: f64 = histogram[from..].iter().sum();
        let is_enough = heap >= FEWEST && heap >= HEAP * expected * (top + 1 - from) as f64;
        is_enough.then(|| u8::try_from(from).expect("a code has 8 bits"))
    }

    fn lit(&self) -> impl Iterator<Item = (&[u8; 3], [f32; 3])> {
        let pixels = self.codes.iter().zip(self.irradiance);
        pixels.filter_map(|(codes, irradiance)| irradiance.map(|irradiance| (codes, irradiance)))
    }

    /// Connected parts of the lit pixels of at least this code.
    fn parts(&self, channel: usize, from: u8, labels: &mut [u32]) -> Vec<Vec<usize>> {
        let is_in =
            |pixel: usize| self.irradiance[pixel].is_some() && self.codes[pixel][channel] >= from;
        labels.fill(0);
        let mut parts: Vec<Vec<usize>> = Vec::new();
        for pixel in (0..labels.len()).filter(|pixel| is_in(*pixel)) {
            if labels[pixel] != 0 {
                continue;
            }
            let label = u32::try_from(parts.len() + 1).expect("pictures have fewer pixels");
            labels[pixel] = label;
            let mut part = vec![pixel];
            let mut next = 0;
            while let Some(&at) = part.get(next) {
                next += 1;
                for other in around(at, self.size, REACH) {
                    if labels[other] == 0 && is_in(other) {
                        labels[other] = label;
                        part.push(other);
                    }
                }
            }
            parts.push(part);
        }
        parts
    }

    fn is_clipped(&self, part: &[usize], channel: usize, lit: usize) -> bool {
        let at_largest = part.iter().filter(|at| self.codes[**at][channel] == u8::MAX).count();
        let share = part.len() as f64 / lit as f64;
        if at_largest as f64 >= AT_LARGEST * part.len() as f64 {
            return true;
        }
        let limits = if share <= LARGE { FLAT } else { VERY_FLAT };
        share <= SMALL || self.is_flat(part, channel, limits)
    }

    /// True if the radiance of a part does not follow its irradiance.
    fn is_flat(&self, part: &[usize], channel: usize, limits: (f64, f64)) -> bool {
        let logarithms = part.iter().filter_map(|at| {
            let irradiance = f64::from(self.irradiance[*at]?[channel]);
            Some((libm::log(irradiance), libm::log(self.radiance[*at][channel])))
        });
        let points: Vec<(f64, f64)> =
            logarithms.filter(|(x, y)| x.is_finite() && y.is_finite()).collect();
        if points.len() < 3 {
            return false;
        }
        let count = points.len() as f64;
        let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / count;
        let (x, y) = (mean(|point| point.0), mean(|point| point.1));
        let sum = |of: &dyn Fn(f64, f64) -> f64| -> f64 {
            points.iter().map(|point| of(point.0 - x, point.1 - y)).sum()
        };
        let (xx, xy) = (sum(&|x, _| x * x), sum(&|x, y| x * y));
        if xx <= 0.0 {
            return false;
        }
        let slope = xy / xx;
        let residual = sum(&|x, y| (y - slope * x) * (y - slope * x));
        let variance = f64::max(residual / (count - 2.0), ROUNDING * ROUNDING);
        slope.abs() < limits.0 && (variance / xx).sqrt() < limits.1
    }

    /// Marks the pixels beside clipped ones that have at least this code.
    fn mark_beside(&self, clipped: &[usize], (channel, least): (usize, u8), marks: &mut [Clip]) {
        for pixel in clipped.iter().flat_map(|pixel| around(*pixel, self.size, 1)) {
            if marks[pixel] == Clip::Free && self.codes[pixel][channel] >= least {
                marks[pixel] = Clip::Beside;
            }
        }
    }
}

#[cfg(test)]
#[path = "clip_tests.rs"]
mod tests;
