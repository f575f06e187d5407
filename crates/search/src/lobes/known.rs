//! Estimates of bounds from samples, in regions with few samples: close to the mirror direction and
//! at grazing angles.
//!
//! f falls with the distance from the mirror direction (theta_h). So a point is bounded from below
//! by samples farther from the mirror direction, and from above by samples nearer to it, at about
//! the same theta_d. If no sample is nearer, the upper bound is an extrapolation: by the growth of
//! f towards the mirror direction among samples of about that theta_d, or by the growth at other
//! theta_d. The value of the nearest sample is not used as a target, because f changes too fast
//! there.

use std::ops::RangeInclusive;
use std::sync::OnceLock;

use brood_brdf::{DirectionPair, Input};
use brood_target::Samples;
use glam::DVec2;
use rayon::prelude::*;

/// Upper and lower bound as multiples of the largest sample.
const MARGINS: (f64, f64) = (1.3, 0.7);
/// Samples whose ln tan theta_h is less than a point's by up to this still count for its upper
/// bound.
const NEARER: f64 = 0.5;
/// Width in ln tan theta_h of the two nearest ranges of samples, between whose brightest samples
/// growth towards the mirror direction is measured.
const WINDOW: f64 = 1.0;
/// Bound as a multiple of the extrapolated samples, and growth as a multiple of the measured one.
/// Where the bound by the largest sample holds, none of twenty MERL materials exceeds this bound;
/// one of four RGL materials exceeds it by 9 % at a few points.
const GROWN: f64 = 1.5;
const GROWTH: f64 = 1.5;
/// ln tan 3 degrees: within this distance of the mirror direction every material falls off.
const CLOSE: f64 = -2.949;
/// Largest difference in theta_d, in radians, between a point and the samples of its upper and of
/// its lower bound.
const ALIKE: (f64, f64) = (10.0 / 180.0 * std::f64::consts::PI, 2.0 / 180.0 * std::f64::consts::PI);

/// Samples by position, from which bounds at other points are estimated.
pub(super) struct BoundEstimator {
    places: Vec<Place>,
    values: Vec<[f64; 3]>,
    /// True if the growth of highlights can be measured. False if there are lower bounds: f may
    /// equal them or be far above.
    has_growth: bool,
    /// Contrasts of each sample, computed on demand.
    contrasts: Vec<OnceLock<Vec<Contrast>>>,
}

/// Largest ratio, per channel, by which samples get brighter up to this distance from the mirror
/// direction.
struct Contrast {
    /// As [`Place::half`].
    half: f64,
    most: [f64; 3],
}

/// Position of a pair of directions, as bounds use it.
#[derive(Clone, Copy)]
pub(super) struct Place {
    /// 1/2 ln(tan^2 theta_h + 1e-7): about ln tan theta_h. Smaller is nearer to the mirror
    /// direction.
    pub(super) half: f64,
    /// theta_d in radians.
    pub(super) theta_d: f64,
}

impl Place {
    pub(super) fn of(pair: &DirectionPair) -> Self {
        let of = |input: Input| input.evaluate(pair, DVec2::ZERO);
        let cosine = of(Input::HalfDotLight).clamp(0.0, 1.0);
        Self { half: of(Input::LogTanHalf), theta_d: libm::acos(cosine) }
    }

    /// Distance in theta_d.
    fn apart(&self, other: &Self) -> f64 {
        (self.theta_d - other.theta_d).abs()
    }
}

impl BoundEstimator {
    pub(super) fn new(samples: &Samples) -> Self {
        let bounds = samples.lower_bounds().iter().map(|bound| (bound.pair, bound.f));
        let has_growth = samples.lower_bounds().is_empty();
        let more = bounds.chain(samples.expected().iter().copied());
        let (more_pairs, more): (Vec<_>, Vec<_>) = more.unzip();
        let places: Vec<Place> =
            samples.pairs().par_iter().chain(&more_pairs).map(Place::of).collect();
        let contrasts = places.iter().map(|_| OnceLock::new()).collect();
        let values = [samples.values(), &more].concat();
        Self { places, values, has_growth, contrasts }
    }

    /// Copy that does not extrapolate growth.
    #[cfg(test)]
    pub(super) fn without_growth(self) -> Self {
        Self { has_growth: false, ..self }
    }

    /// Upper and lower bound at a point; `None` where samples give none.
    pub(super) fn bounds(&self, point: &Place) -> [Option<[f64; 3]>; 2] {
        let is_close = point.half < CLOSE;
        let near =
            |place: &Place| place.apart(point) < ALIKE.0 && place.half >= point.half - NEARER;
        // If no sample is as near to the mirror direction, the local samples do not show the height
        // of the peak.
        let is_known =
            is_close && self.places.iter().any(|place| near(place) && place.half <= point.half);
        let above = self.largest(MARGINS.0, |place| {
            if is_known { near(place) } else { place.half >= point.half - NEARER }
        });
        let is_grown = self.has_growth && is_close && !is_known;
        let above = match (above, is_grown.then(|| self.grown(point)).flatten()) {
            (Some(above), Some(grown)) => Some([0, 1, 2].map(|c| above[c].min(GROWN * grown[c]))),
            (above, _) => above,
        };
        let below = self.largest(MARGINS.1, |place| {
            let is_farther = place.half >= point.half && place.half < CLOSE;
            is_close && is_farther && place.apart(point) < ALIKE.1
        });
        [above, below]
    }

    /// Largest value per channel of the samples that count, times the margin.
    fn largest(&self, margin: f64, counts: impl Fn(&Place) -> bool) -> Option<[f64; 3]> {
        let among = self.places.iter().zip(&self.values).filter(|(place, _)| counts(place));
        among
            .map(|(_, value)| value.map(|f| margin * f))
            .reduce(|a, b| [0, 1, 2].map(|c| a[c].max(b[c])))
    }

    /// Extrapolates samples of about the same theta_d to a point nearer to the mirror direction: by
    /// their growth where they are nearest to it, or by the contrast of samples at any theta_d,
    /// whichever is larger. In ln f over ln theta_h, a highlight flattens towards the mirror
    /// direction, so that growth measured farther out bounds it. But a narrow highlight may be
    /// below the diffuse part everywhere except close to the mirror direction, hence the contrast.
    /// `None` if samples are missing.
    fn grown(&self, point: &Place) -> Option<[f64; 3]> {
        let beside = |k: &usize| self.places[*k].apart(point) < ALIKE.0;
        let beside: Vec<usize> = (0..self.places.len()).filter(beside).collect();
        // Materials get brighter towards the horizon, so only samples with at least the point's
        // theta_d bound it.
        let lower = beside.iter().copied().filter(|k| self.places[*k].theta_d >= point.theta_d);
        let half = |k: usize| self.places[k].half;
        let at = lower.min_by(|a, b| half(*a).total_cmp(&half(*b)))?;
        let contrast = self.contrast(at, point)?;
        let mut grown = [0.0; 3];
        for (c, grown) in grown.iter_mut().enumerate() {
            let (near, most) = self.brightest(&beside, f64::NEG_INFINITY..=half(at) + WINDOW, c)?;
            let farther = half(at) + WINDOW..=half(at) + 2.0 * WINDOW;
            let (far, least) = self.brightest(&beside, farther, c)?;
            let growth = libm::log(most / least).max(0.0) / (far - near).max(WINDOW / 2.0);
            let times = libm::exp(GROWTH * growth * (near - point.half).max(0.0));
            *grown = most * times.max(contrast[c]);
        }
        grown.iter().all(|f| f.is_finite() && *f > 0.0).then_some(grown)
    }

    /// Position (`half`) and value of the brightest of these samples in a range of `half`.
    fn brightest(&self, of: &[usize], range: RangeInclusive<f64>, c: usize) -> Option<(f64, f64)> {
        let all = of.iter().map(|k| (self.places[*k].half, self.values[*k][c]));
        all.filter(|(half, _)| range.contains(half)).max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Ratio of the brightest samples between sample `at` and the point, at any theta_d, to samples
    /// beside them about as far from the mirror direction as `at`. `None` if `at` is too far from
    /// the mirror direction.
    fn contrast(&self, at: usize, point: &Place) -> Option<[f64; 3]> {
        let contrasts = || self.contrasts(self.places[at].half);
        let contrasts = (self.places[at].half < CLOSE + WINDOW)
            .then(|| self.contrasts[at].get_or_init(contrasts))?;
        let nearer = contrasts.partition_point(|contrast| contrast.half >= point.half - NEARER);
        Some(nearer.checked_sub(1).map_or([1.0; 3], |last| contrasts[last].most))
    }

    /// Ratios by which samples get brighter from `from` towards the mirror direction, at any
    /// theta_d; from the farthest to the nearest, each at least as large as those before.
    fn contrasts(&self, from: f64) -> Vec<Contrast> {
        let is_between = |k: &usize| self.places[*k].half <= from + WINDOW;
        let mut close: Vec<usize> = (0..self.places.len()).filter(is_between).collect();
        close.sort_by(|a, b| self.places[*b].half.total_cmp(&self.places[*a].half));
        let mut most = [1.0f64; 3];
        let mut contrasts = Vec::new();
        for peak in close.iter().filter(|k| self.places[**k].half < from) {
            let alike = |k: &&usize| self.places[**k].apart(&self.places[*peak]) < ALIKE.0;
            let beside: Vec<usize> = close.iter().filter(alike).copied().collect();
            for (c, most) in most.iter_mut().enumerate() {
                if let Some((_, f)) = self.brightest(&beside, from..=from + WINDOW, c)
                    && f > 0.0
                {
                    *most = most.max(self.values[*peak][c] / f);
                }
            }
            contrasts.push(Contrast { half: self.places[*peak].half, most });
        }
        contrasts
    }
}
