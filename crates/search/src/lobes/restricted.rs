//! Fit of lobes with some weights fixed. Each unit and term keeps its role, so that the parameters
//! of different materials are comparable.

use brood_genome::lobes::Shape;
use brood_genome::{BirthKey, Operator, Stream};
use brood_target::Samples;
use rayon::prelude::*;

use super::Lobes;
use super::bounds::Bounds;
use super::known::BoundEstimator;
use super::normal_equations::e_log;
use super::schedule::Problem;
use super::seed::colour;
use super::terms::Terms;
use crate::levenberg_marquardt::Solution;

/// Number of starts, and numbers of those that are refined further.
const STARTS: u32 = 8;
const BETTER: usize = 2;
/// Steps of all starts, of the better ones, and of the best one.
const STEPS: [usize; 3] = [20, 40, 60];
/// Ridge cost of weights, relative to the error of the best fit.
const RIDGE: f64 = 1e-2;

/// Shape, start and free weights of a restricted fit. Colours are always free.
#[derive(Debug, Clone)]
pub struct Restricted {
    /// Inputs and size.
    pub shape: Shape,
    /// Weights to start from; colours are fitted first.
    pub start: Vec<f64>,
    /// Standard deviation of each weight of a start; 0 for weights that keep their value.
    pub spread: Vec<f64>,
}

/// Fits samples from several starts. Returns the parameters and E_log on all samples.
///
/// # Panics
/// If `start` or `spread` has not one value for each parameter.
#[must_use]
pub fn fit_restricted(samples: &Samples, how: &Restricted, seed: u64) -> (Vec<f64>, f64) {
    let Restricted { shape, start, spread } = how;
    assert!(start.len() == shape.len() && spread.len() == shape.len());
    let known = BoundEstimator::new(samples);
    let bounds = [Bounds::of_fits(&known, seed), Bounds::of_pool(&known, seed)];
    let mut problem = Problem::new(samples, shape.clone(), &bounds, Terms::ALL);
    let drawn = |slot: u32| {
        let key = BirthKey { seed, slot, attempt: 0 };
        let mut stream = Stream::new(key, Operator::Lobes);
        let mut lobes = Lobes::new(shape.clone());
        for (at, parameter) in lobes.parameters.iter_mut().enumerate() {
            *parameter = start[at] + spread[at] * f64::from(stream.bell());
            lobes.free[at] = spread[at] > 0.0 || at >= shape.colour(0, 0);
        }
        colour(&mut lobes, &problem.points);
        let mut fit = Solution::of(lobes, &problem.part);
        fit.refine(&problem.part, STEPS[0]);
        fit
    };
    let mut fits: Vec<Solution<Lobes>> = (0..STARTS).into_par_iter().map(drawn).collect();
    fits.sort_by(|a, b| a.error.total_cmp(&b.error));
    fits.truncate(BETTER);
    problem.whole.cost = RIDGE * fits[0].error;
    let Problem { whole, pool, .. } = &problem;
    fits.par_iter_mut().for_each(|fit| {
        *fit = fit.clone().on(whole);
        fit.refine(whole, STEPS[1]);
    });
    fits.sort_by(|a, b| a.error.total_cmp(&b.error));
    let mut best = fits.swap_remove(0);
    best.refine(whole, STEPS[2]);
    let best = pool.enforce(best, whole);
    let error = e_log(&best.point, whole);
    (best.point.parameters, error)
}
