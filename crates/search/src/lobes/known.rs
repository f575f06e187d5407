//! What samples say of a material where hardly one is: bounds close to the mirror direction and at grazing angles.
//!
//! Materials fall off from the mirror direction, so a point is bounded from below by samples farther from it, and from above by
//! samples nearer to it, at about the same angle of incidence; where none is nearer, by how fast they grow towards it, and by how
//! much brighter samples get there at other angles of incidence. A bound is held better than the value of the nearest sample:
//! reflectance changes so much there that any value would be wrong.

use std::ops::RangeInclusive;
use std::sync::OnceLock;

use brood_brdf::{DirectionPair, Input};
use glam::DVec2;
use rayon::prelude::*;

use crate::Samples;

/// What a bound is of the largest sample, from above and from below.
const MARGINS: (f64, f64) = (1.3, 0.7);
/// Samples whose ln tan theta_h is by this much less than a point's belong to those it is bounded by from above.
const NEARER: f64 = 0.5;
/// Growth towards the mirror direction is that between the brightest samples of the nearest two such ranges of ln tan theta_h.
const WINDOW: f64 = 1.0;
/// What a bound is of what samples would have grown to, and how many times as fast they may grow: none of twenty materials of MERL
/// passes such a bound where it does not pass the one by the largest sample, one of four of RGL's by 9 % at a few points.
const GROWN: f64 = 1.5;
const GROWTH: f64 = 1.5;
/// ln tan 3 degrees: as far from the mirror direction every material falls off from it.
const CLOSE: f64 = -2.949;
/// theta_d of samples that bound a point is within this of its own, from above and from below.
const ALIKE: (f64, f64) = (10.0 / 180.0 * std::f64::consts::PI, 2.0 / 180.0 * std::f64::consts::PI);

/// Samples, and where they are.
pub(super) struct Known {
    places: Vec<Place>,
    values: Vec<[f64; 3]>,
    /// Whether how highlights grow can be told. Where f is known not to be below a value it may be that, and says nothing of it.
    grows: bool,
    /// Of each sample, how many times as bright others get nearer to the mirror direction, and where, once that has been asked for.
    contrasts: Vec<OnceLock<Vec<Contrast>>>,
}

/// How many times as bright samples are at most that are no nearer to the mirror direction than this.
struct Contrast {
    half: f64,
    most: [f64; 3],
}

/// What a bound looks at of a pair.
#[derive(Clone, Copy)]
pub(super) struct Place {
    /// 1/2 ln(tan^2 theta_h + 1e-7).
    pub(super) half: f64,
    /// In radians.
    pub(super) theta_d: f64,
}

impl Place {
    pub(super) fn of(pair: &DirectionPair) -> Self {
        let of = |input: Input| input.evaluate(pair, DVec2::ZERO);
        let cosine = of(Input::HalfDotLight).clamp(0.0, 1.0);
        Self { half: of(Input::LogTanHalf), theta_d: libm::acos(cosine) }
    }

    /// How far apart they are in theta_d.
    fn apart(&self, other: &Self) -> f64 {
        (self.theta_d - other.theta_d).abs()
    }
}

impl Known {
    pub(super) fn new(samples: &Samples) -> Self {
        let (pairs_below, below): (Vec<_>, Vec<_>) = samples.least().iter().copied().unzip();
        let places: Vec<Place> =
            samples.pairs().par_iter().chain(&pairs_below).map(Place::of).collect();
        let contrasts = places.iter().map(|_| OnceLock::new()).collect();
        let values = [samples.values(), &below].concat();
        Self { places, values, grows: below.is_empty(), contrasts }
    }

    /// The same, where how highlights grow cannot be told.
    #[cfg(test)]
    pub(super) fn without_growth(self) -> Self {
        Self { grows: false, ..self }
    }

    /// At most and at least this, where samples say so.
    pub(super) fn bounds(&self, point: &Place) -> [Option<[f64; 3]>; 2] {
        let is_close = point.half < CLOSE;
        let near =
            |place: &Place| place.apart(point) < ALIKE.0 && place.half >= point.half - NEARER;
        // Where no sample is as near to the mirror direction, the local ones say nothing of how high the peak is.
        let is_known =
            is_close && self.places.iter().any(|place| near(place) && place.half <= point.half);
        let above = self.largest(MARGINS.0, |place| {
            if is_known { near(place) } else { place.half >= point.half - NEARER }
        });
        let is_grown = self.grows && is_close && !is_known;
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

    /// The largest of the samples that count, in each channel, times the margin.
    fn largest(&self, margin: f64, counts: impl Fn(&Place) -> bool) -> Option<[f64; 3]> {
        let among = self.places.iter().zip(&self.values).filter(|(place, _)| counts(place));
        among
            .map(|(_, value)| value.map(|f| margin * f))
            .reduce(|a, b| [0, 1, 2].map(|c| a[c].max(b[c])))
    }

    /// What samples at about the same theta_d would have grown to at a point nearer to the mirror direction than they are, if they
    /// went on growing as they do where they are nearest to it, or got as much brighter as samples do at any theta_d. Highlights
    /// grow the slower, in ln f over ln theta_h, the nearer they are, but may hide below an even rest until they are close.
    fn grown(&self, point: &Place) -> Option<[f64; 3]> {
        let beside = |k: &usize| self.places[*k].apart(point) < ALIKE.0;
        let beside: Vec<usize> = (0..self.places.len()).filter(beside).collect();
        // Materials get brighter towards the horizon: a sample that is farther from it than the point alone says too little.
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

    /// The brightest of these samples whose 1/2 ln(tan^2 theta_h + 1e-7) is in that range, and its own.
    fn brightest(&self, of: &[usize], range: RangeInclusive<f64>, c: usize) -> Option<(f64, f64)> {
        let all = of.iter().map(|k| (self.places[*k].half, self.values[*k][c]));
        all.filter(|(half, _)| range.contains(half)).max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// How many times as bright samples between that one and the point are, at any theta_d, as those beside them that are about as
    /// far from the mirror direction as that one; none where it is so far from it that this would say little.
    fn contrast(&self, at: usize, point: &Place) -> Option<[f64; 3]> {
        let contrasts = || self.contrasts(self.places[at].half);
        let contrasts = (self.places[at].half < CLOSE + WINDOW)
            .then(|| self.contrasts[at].get_or_init(contrasts))?;
        let nearer = contrasts.partition_point(|contrast| contrast.half >= point.half - NEARER);
        Some(nearer.checked_sub(1).map_or([1.0; 3], |last| contrasts[last].most))
    }

    /// How many times as bright samples get from there on towards the mirror direction, at any theta_d, and where.
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
