//! Spread of the materials that match samples about as well as the best: the directions in which
//! they differ, their darkest and brightest values, and the picture to take next.
//!
//! Owns the statistics of drawn materials ([`Search::posterior`]). Independent of how they are
//! drawn.

mod next;

use std::f64::consts::FRAC_PI_2;

use brood_eval::{EvalError, energy_limit};
use brood_genome::Genome;
use brood_program::Program;
use brood_target::{Samples, draw_pairs};
use rayon::prelude::*;

pub use next::NextPicture;

use crate::found::limited;
use crate::{Posterior, Search};

/// Number of drawn materials.
const COUNT: usize = 48;
/// Rows and columns of the map, over 0 to 90 degrees.
const CELLS: usize = 30;
/// Number of pairs of all directions at which the error is estimated.
const PAIRS: usize = 512;
const PAIRS_SEED: u64 = 5;
/// Quantiles of the darkest and the brightest values.
const QUANTILES: [f64; 2] = [0.05, 0.95];

/// Materials that match samples about as well as the best.
#[derive(Debug, Clone)]
pub struct Spread {
    /// Programs of the materials, under the energy limit.
    programs: Vec<Program>,
    /// Mean squared error of observations.
    error: f64,
}

/// Map over theta_h (columns) and theta_d (rows) at phi_d = 90 degrees, in cells of 3 degrees.
#[derive(Debug, Clone, PartialEq)]
pub struct SpreadMap {
    /// Share of the samples in each cell, by theta_h and theta_d of their directions.
    pub seen: Vec<f64>,
    /// Standard deviation of ln f over the drawn materials; the mean of the channels.
    pub deviation: Vec<f64>,
}

impl SpreadMap {
    /// Number of rows and of columns.
    pub const CELLS: usize = CELLS;
}

impl Spread {
    /// Draws materials that match the samples of a search; `None` if its strategy has no
    /// probabilities.
    #[must_use]
    pub fn of(search: &Search) -> Option<Self> {
        let Posterior { genomes, error } = search.posterior(COUNT)?;
        let program = |genome: &Genome| {
            let program = Program::lower(genome);
            let divisor = energy_limit(&program).divisor;
            limited(program, divisor)
        };
        Some(Self { programs: genomes.par_iter().map(program).collect(), error })
    }

    /// Programs of the materials, under the energy limit.
    #[must_use]
    pub fn programs(&self) -> &[Program] {
        &self.programs
    }

    /// Expected E_log over all directions: the root mean square deviation of ln(1 + f cos_i) over
    /// the drawn materials.
    ///
    /// # Errors
    /// Returns [`EvalError`] if a program cannot be evaluated.
    pub fn e_log(&self) -> Result<f64, EvalError> {
        let all = self.everywhere()?;
        Ok(deviation(&all))
    }

    /// ln(1 + f cos_i) of every material at pairs of all directions.
    fn everywhere(&self) -> Result<Vec<Vec<f64>>, EvalError> {
        let samples = draw_pairs(PAIRS, PAIRS_SEED);
        self.each(|program| {
            let found = Samples::of_program(program, samples.clone())?.weighted();
            Ok(found.as_flattened().iter().map(|f| libm::log1p(f.max(0.0))).collect())
        })
    }

    fn each<T: Send>(
        &self,
        of: impl Fn(&Program) -> Result<T, EvalError> + Sync + Send,
    ) -> Result<Vec<T>, EvalError> {
        self.programs.par_iter().map(of).collect()
    }

    /// Maps the spread and the samples over theta_h and theta_d.
    ///
    /// # Errors
    /// Returns [`EvalError`] if a program cannot be evaluated.
    pub fn map(&self, samples: &Samples) -> Result<SpreadMap, EvalError> {
        let middle = |index: usize| (index as f64 + 0.5) / CELLS as f64 * FRAC_PI_2;
        let pairs: Vec<_> = (0..CELLS * CELLS)
            .map(|cell| brood_target::pair_of_half(middle(cell % CELLS), middle(cell / CELLS)))
            .collect();
        let above: Vec<usize> = (0..pairs.len()).filter(|cell| pairs[*cell].is_some()).collect();
        let known: Vec<_> = pairs.into_iter().flatten().collect();
        let all = self.each(|program| {
            let found = Samples::of_program(program, known.clone())?;
            let logs = found.values().as_flattened().iter().map(|f| libm::log(f.max(LEAST)));
            Ok(logs.collect::<Vec<f64>>())
        })?;
        let variances = variances(&all);
        let mut deviation = vec![0.0; CELLS * CELLS];
        for (of_cell, cell) in variances.chunks_exact(3).zip(&above) {
            deviation[*cell] = of_cell.iter().map(|variance| variance.sqrt()).sum::<f64>() / 3.0;
        }
        Ok(SpreadMap { seen: seen(samples), deviation })
    }

    /// The 5 and 95 % quantiles of each value over the materials, such as the radiance of a pixel.
    /// `values` has one row per material.
    ///
    /// # Panics
    /// If rows have different lengths.
    #[must_use]
    pub fn range(values: &[Vec<f32>]) -> [Vec<f32>; 2] {
        let count = values.first().map_or(0, Vec::len);
        let mut range = [Vec::with_capacity(count), Vec::with_capacity(count)];
        for at in 0..count {
            let mut all: Vec<f32> = values.iter().map(|row| row[at]).collect();
            all.sort_by(f32::total_cmp);
            for (range, quantile) in range.iter_mut().zip(QUANTILES) {
                let place = quantile * (all.len() - 1) as f64;
                range.push(all[place.round() as usize]);
            }
        }
        range
    }
}

/// Factors of theta_h within the range that a direction of an environment stands for.
const AROUND: [f64; 7] = [0.8, 0.86, 0.93, 1.0, 1.07, 1.14, 1.22];
/// Least f of which the logarithm is taken.
const LEAST: f64 = 1e-4;

/// Share of the samples in each cell of the map.
fn seen(samples: &Samples) -> Vec<f64> {
    let mut seen = vec![0.0; CELLS * CELLS];
    let mut add = |pair: &brood_brdf::DirectionPair, share: f64, factor: f64| {
        let half = (pair.wi() + pair.wo()).normalize();
        let cell = |cosine: f64, factor: f64| {
            let angle = factor * libm::acos(cosine.clamp(0.0, 1.0));
            ((angle / FRAC_PI_2 * CELLS as f64) as usize).min(CELLS - 1)
        };
        seen[cell(half.dot(pair.wi()), 1.0) * CELLS + cell(half.z, factor)] += share;
    };
    samples.pairs().iter().for_each(|pair| add(pair, 1.0, 1.0));
    let means = samples.means();
    for mean in 0..means.len() {
        for (at, share) in means.terms(mean) {
            // Shares of f are those of f cos_i times the cosine.
            let pair = &means.pairs()[*at as usize];
            let share = f64::from(share[1]) / pair.cos_i();
            // Directions of environments stand for a range of theta_h.
            match means.is_isotropic() {
                true => AROUND.iter().for_each(|by| add(pair, share / AROUND.len() as f64, *by)),
                false => add(pair, share, 1.0),
            }
        }
    }
    let sum = seen.iter().sum::<f64>().max(1.0);
    seen.into_iter().map(|count| count / sum).collect()
}

/// Variance of each column; rows are materials.
fn variances(rows: &[Vec<f64>]) -> Vec<f64> {
    let columns = rows.first().map_or(0, Vec::len);
    let number = rows.len().max(1) as f64;
    let variance = |column: usize| {
        let mean = rows.iter().map(|row| row[column]).sum::<f64>() / number;
        rows.iter().map(|row| (row[column] - mean).powi(2)).sum::<f64>() / number
    };
    (0..columns).map(variance).collect()
}

/// Root of the mean variance.
fn deviation(rows: &[Vec<f64>]) -> f64 {
    let variances = variances(rows);
    (variances.iter().sum::<f64>() / variances.len().max(1) as f64).sqrt()
}

#[cfg(test)]
#[path = "spread_tests.rs"]
mod tests;
