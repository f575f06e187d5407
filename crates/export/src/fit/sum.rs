//! The sum of lobes that is nearest to a material.
//!
//! f cos_i of a material is approximated by a sum of a diffuse lobe, lobes of GGX and velvet. Each
//! lobe has a weight for red, green and blue at each of some inclinations of the eye, linear
//! between them. The weights are at least 0, with about the least mean of |df cos_i|; then those of
//! each inclination are scaled so that the sum reflects as much light as the material.

use std::f64::consts::FRAC_PI_2;

use brood_brdf::{Brdf, Claims, DirectionPair};
use glam::DVec3;
use rayon::prelude::*;

use super::least::Normal;
use super::lobe::Lobe;
use super::view::View;
use crate::table::{Source, Symmetry};

/// Inclinations of the eye with weights. Cycles samples colour ramps at 256 places: 255 is divided
/// by 17, so each is at one of them.
pub(super) const STOPS: usize = 18;
/// The place of an inclination is its share of a right angle to this power: denser at grazing.
pub(super) const PLACE_POWER: f64 = 1.2;
/// Largest inclination at which weights are fitted, in radians: at 90 degrees nothing is seen.
const STEEPEST: f64 = 1.56;
/// Lobes of a fit.
const LOBES: usize = 8;
/// Share of the reflected light below which a lobe is left out.
const LEAST_SHARE: f64 = 0.002;
/// Lobes that are left out at once, as a share of those beyond [`LOBES`].
const DROPPED: f64 = 0.34;
/// Rounds that turn squares of errors into magnitudes, while lobes are chosen and at the end.
const ROUNDS: [usize; 2] = [3, 10];
/// Error below which it counts by its square, as a share of the mean of f cos_i.
const SMALL_ERROR: f64 = 0.01;

/// A lobe and its weights at the inclinations of the eye.
#[derive(Debug, Clone)]
pub(super) struct Weighted {
    pub(super) lobe: Lobe,
    pub(super) weights: Vec<DVec3>,
}

/// Sum of lobes nearest to a material.
#[derive(Debug)]
pub(super) struct Fit {
    pub(super) lobes: Vec<Weighted>,
}

impl Fit {
    /// Fits a material.
    pub(super) fn of(source: &Source<'_>) -> Self {
        let is_anisotropic = source.symmetry() != Symmetry::Isotropic;
        let views: Vec<View> = (0..STOPS)
            .into_par_iter()
            .map(|stop| View::of(source, inclination_of(stop as f64), is_anisotropic))
            .collect();
        let mut lobes = Lobe::candidates(is_anisotropic);
        loop {
            let shares = shares(&views, &lobes);
            let mut order: Vec<usize> = (0..lobes.len()).collect();
            order.sort_by(|a, b| shares[*b].total_cmp(&shares[*a]));
            let useful = shares.iter().filter(|share| **share > LEAST_SHARE).count();
            let many = lobes.len().saturating_sub(LOBES);
            let kept = useful.min(lobes.len() - (many as f64 * DROPPED).ceil() as usize);
            if kept == lobes.len() || kept == 0 {
                break;
            }
            order.truncate(kept);
            order.sort_unstable();
            lobes = order.into_iter().map(|k| lobes[k]).collect();
        }
        let fitted: Vec<Vec<DVec3>> =
            views.par_iter().map(|view| Fitted::of(view, &lobes, ROUNDS[1]).scaled(view)).collect();
        let weights = |k: usize| fitted.iter().map(|weights| weights[k]).collect();
        let lobes = lobes.iter().enumerate();
        Self {
            lobes: lobes.map(|(k, lobe)| Weighted { lobe: *lobe, weights: weights(k) }).collect(),
        }
    }
}

impl Brdf for Fit {
    fn f(&self, pair: &DirectionPair) -> DVec3 {
        if pair.cos_i() <= 0.0 || pair.cos_o() <= 0.0 {
            return DVec3::ZERO;
        }
        let share = libm::acos(pair.cos_o().min(1.0)) / FRAC_PI_2;
        let place = libm::pow(share, PLACE_POWER) * (STOPS - 1) as f64;
        let stop = (place as usize).min(STOPS - 2);
        let weight =
            |lobe: &Weighted| lobe.weights[stop].lerp(lobe.weights[stop + 1], place - stop as f64);
        let sum: DVec3 = self.lobes.iter().map(|lobe| weight(lobe) * lobe.lobe.value(pair)).sum();
        sum / pair.cos_i()
    }

    fn claims(&self) -> Claims {
        Claims::default()
    }
}

/// Inclination of the eye at a place between 0 and the last stop, in radians.
pub(super) fn inclination_of(place: f64) -> f64 {
    let share = place / (STOPS - 1) as f64;
    (FRAC_PI_2 * libm::pow(share, 1.0 / PLACE_POWER)).min(STEEPEST)
}

/// Share of the light that each lobe reflects, mean over views.
fn shares(views: &[View], lobes: &[Lobe]) -> Vec<f64> {
    let of_view = |view: &View| {
        let fitted = Fitted::of(view, lobes, ROUNDS[0]);
        let light = |k: usize| {
            let rows = fitted.rows.iter().map(|row| fitted.weights[k] * row[k]);
            rows.zip(&view.error_weights).map(|(value, weight)| value.element_sum() * weight).sum()
        };
        let light: Vec<f64> = (0..lobes.len()).map(light).collect();
        let sum = light.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        light.into_iter().map(|light| light / sum).collect::<Vec<_>>()
    };
    let by_view: Vec<Vec<f64>> = views.par_iter().map(of_view).collect();
    let mean = |k: usize| by_view.iter().map(|view| view[k]).sum::<f64>() / views.len() as f64;
    (0..lobes.len()).map(mean).collect()
}

/// Weights of lobes at one view.
struct Fitted {
    /// Value of each lobe, by pair.
    rows: Vec<Vec<f64>>,
    weights: Vec<DVec3>,
}

impl Fitted {
    /// Weights with about the least sum of magnitudes of errors.
    fn of(view: &View, lobes: &[Lobe], rounds: usize) -> Self {
        let rows: Vec<Vec<f64>> =
            view.pairs.iter().map(|pair| lobes.iter().map(|l| l.value(pair)).collect()).collect();
        let albedos: Vec<f64> = (0..lobes.len())
            .map(|k| rows.iter().zip(&view.solid_angles).map(|(row, angle)| row[k] * angle).sum())
            .collect();
        let albedo = view.albedo(view.values.iter().copied());
        let mut weights = vec![DVec3::ZERO; lobes.len()];
        for channel in 0..3 {
            let wanted: Vec<f64> = view.values.iter().map(|value| value[channel]).collect();
            let sum: f64 = wanted.iter().zip(&view.error_weights).map(|(f, w)| f * w).sum();
            let small = SMALL_ERROR * sum / view.error_weights.iter().sum::<f64>();
            if small <= 0.0 || albedo[channel] <= 0.0 {
                continue;
            }
            let mut errors = wanted.clone();
            for _ in 0..rounds {
                let weighted = view.error_weights.iter().zip(&errors);
                let counts: Vec<f64> =
                    weighted.map(|(weight, error)| weight / error.abs().max(small)).collect();
                // The albedo is a row too: an error of all of it counts as much as an error of
                // all values. Without it, scaling to it would move the weights far.
                let all: f64 = wanted.iter().zip(&counts).map(|(f, count)| f * f * count).sum();
                let albedo = albedo[channel];
                let row = (&albedos[..], albedo, all / (albedo * albedo));
                let rows_of = rows.iter().zip(&wanted).zip(&counts);
                let rows_of = rows_of.map(|((row, wanted), count)| (&row[..], *wanted, *count));
                let found = Normal::of(lobes.len(), rows_of.chain([row])).solve();
                for ((error, row), wanted) in errors.iter_mut().zip(&rows).zip(&wanted) {
                    *error = row.iter().zip(&found).map(|(a, x)| a * x).sum::<f64>() - wanted;
                }
                weights.iter_mut().zip(found).for_each(|(weight, x)| weight[channel] = x);
            }
        }
        Self { rows, weights }
    }

    /// The weights, scaled so that as much light is reflected as by the material.
    fn scaled(self, view: &View) -> Vec<DVec3> {
        let wanted = view.albedo(view.values.iter().copied());
        let sum = |row: &Vec<f64>| -> DVec3 {
            row.iter().zip(&self.weights).map(|(value, weight)| *weight * *value).sum()
        };
        let found = view.albedo(self.rows.iter().map(sum));
        let ratio = [0, 1, 2].map(|channel| match found[channel] > 0.0 {
            true => wanted[channel] / found[channel],
            false => 1.0,
        });
        self.weights.into_iter().map(|weight| weight * DVec3::from(ratio)).collect()
    }
}
