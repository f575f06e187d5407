//! Exposures of HDR-FLIP: their range follows from the reference and the tone curve.

/// Coefficients of Narkowicz's fit of the ACES curve, with 0.6 for the exposure it contains:
/// (a x^2 + b x) / (c x^2 + d x + e).
const ACES: [f64; 5] = [0.6 * 0.6 * 2.51, 0.6 * 0.03, 0.6 * 0.6 * 2.43, 0.6 * 0.59, 0.14];
/// Tone-mapped value that the largest and the median luminance get, at the first and the last
/// exposure.
const SHOWN: f64 = 0.85;

/// Exposures over which HDR-FLIP takes its maximum, from the brightest pixel of the reference down
/// to its median.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exposures {
    /// First exposure in EV; shows the largest luminance.
    pub start_ev: f64,
    /// Last exposure in EV; shows the median luminance.
    pub stop_ev: f64,
    /// Number of exposures, in equal steps of at most 1 EV or a little more.
    pub count: u32,
    /// True if most pixels are black; the median is then that of the others.
    pub mostly_black: bool,
}

impl Exposures {
    /// Returns the exposures for a reference in linear RGB from 0 up, `None` if it is black.
    ///
    /// # Source
    /// Andersson et al. 2021, section 3. The paper's last exposure is infinite if the median is 0,
    /// as in a picture of an object on black, so black pixels then do not count. flip-evaluator 1.7
    /// shows the luminance 1.2e-7 instead, whatever the unit of the picture.
    pub fn of(reference: &[[f64; 3]]) -> Option<Self> {
        let luminance = |rgb: &[f64; 3]| 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
        let mut luminances: Vec<f64> = reference.iter().map(luminance).collect();
        luminances.sort_unstable_by(f64::total_cmp);
        let largest = *luminances.last()?;
        let black = luminances.partition_point(|luminance| *luminance <= 0.0);
        let middle = luminances.len() / 2;
        let mostly_black = middle < black;
        let middle = if mostly_black { black + (luminances.len() - black) / 2 } else { middle };
        let median = *luminances.get(middle)?;
        let shown = Self::shown();
        let [start_ev, stop_ev] = [largest, median].map(|luminance| libm::log2(shown / luminance));
        let count = (stop_ev - start_ev).ceil().max(2.0) as u32;
        Some(Self { start_ev, stop_ev, count, mostly_black })
    }

    /// Value that the tone curve maps to [`SHOWN`].
    fn shown() -> f64 {
        let [a, b, c, d, e] = ACES;
        let (square, linear, constant) = (a - SHOWN * c, b - SHOWN * d, -SHOWN * e);
        let half = -0.5 * linear / square;
        half + (half * half - constant / square).sqrt()
    }

    /// Exposures in EV, in rising order.
    pub(super) fn evs(&self) -> impl Iterator<Item = f64> {
        let Self { start_ev, stop_ev, count, .. } = *self;
        let step = (stop_ev - start_ev) / f64::from(count - 1);
        (0..count).map(move |index| start_ev + f64::from(index) * step)
    }

    /// Returns pixels in 0..1 at an exposure.
    pub(super) fn tone_mapped(&self, pixels: &[[f64; 3]], ev: f64) -> Vec<[f64; 3]> {
        let gain = libm::exp2(ev);
        pixels.iter().map(|rgb| rgb.map(|value| tone_map(value * gain).clamp(0.0, 1.0))).collect()
    }
}

fn tone_map(x: f64) -> f64 {
    let [a, b, c, d, e] = ACES;
    (a * x * x + b * x) / (c * x * x + d * x + e)
}
