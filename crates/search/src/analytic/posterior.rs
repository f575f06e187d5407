//! Random materials that match the samples about as well as the best.
//!
//! Each form of models has a probability. The parameters of a form are distributed about as a
//! Gaussian around their fit. Points are drawn from these Gaussians, and then drawn again with
//! their true probabilities as weights.
//!
//! # Source
//! Rubin, *Using the SIR Algorithm to Simulate Posterior Distributions* (1988); Ionides, *Truncated
//! Importance Sampling* (2008), for the largest weight.

use brood_brdf::TableDetail;
use brood_genome::{BirthKey, Genome, Operator, Stream};
use rayon::prelude::*;

use super::Form;
use super::kept::Kept;
use super::residual::Workspace;
use super::schedule::{Analytic, EQUAL};
use crate::method::Posterior;
use crate::solve;

/// Number of points drawn for each form, as a multiple of the wanted materials.
const DRAWN: usize = 2;
/// Number of independent observations that all samples count as, and the least error of every fit
/// as a share of the root mean square of ln(1 + f cos_i). No model is exact. With the values of the
/// search, the quantiles contained only half of the measured f at directions without samples. The
/// example `spread` measures that share.
pub(crate) const OPEN_INDEPENDENT: f64 = 10.0;
const LEAST_ERROR: f64 = 0.18;
/// Attempt of the random streams, which no generation has.
const ATTEMPT: u32 = u32::MAX;

/// A drawn material with its weight.
struct Draw {
    genome: Genome,
    weight: f64,
}

/// A form with its draws, whose weights sum to 1.
struct FormDraws {
    evidence: f64,
    draws: Vec<Draw>,
}

impl Analytic {
    /// Draws `count` materials by their probability after the samples. `None` before the first
    /// generation.
    pub(super) fn posterior(&self, count: usize) -> Option<Posterior> {
        let best = self.kept.first()?;
        let numbered: Vec<(u32, &Kept)> = (0u32..).zip(&self.kept).collect();
        let mut drawn: Vec<FormDraws> = numbered
            .into_par_iter()
            .map_init(Workspace::new, |workspace, (slot, kept)| {
                self.draws(workspace, (slot, kept), DRAWN * count)
            })
            .collect();
        let least = drawn.iter().map(|form| form.evidence).fold(f64::INFINITY, f64::min);
        drawn.iter_mut().for_each(|form| form.evidence -= least);
        let (genomes, error) = (resampled(&drawn, count), self.error(best));
        (!genomes.is_empty()).then_some(Posterior { genomes, error })
    }

    /// Mean squared error of observations by which a fit is judged.
    fn error(&self, kept: &Kept) -> f64 {
        0.5 * (kept.squares[0] + kept.squares[1]) + self.equal * (LEAST_ERROR / EQUAL).powi(2)
    }

    /// Draws points around the fit of a form.
    fn draws(
        &self,
        workspace: &mut Workspace,
        (slot, kept): (u32, &Kept),
        count: usize,
    ) -> FormDraws {
        let Kept { space, fit, .. } = kept;
        let key = BirthKey { seed: self.seed, slot, attempt: ATTEMPT };
        let mut stream = Stream::new(key, Operator::Analytic);
        let prior = self.error(kept) / OPEN_INDEPENDENT;
        let batch = self.few.with_prior(prior);
        let scale = 1.0 / (prior * self.few.total);
        let detail = TableDetail::Coarse;
        let equations = workspace.normal_equations(space, &fit.point, &batch, detail);
        let precision: Vec<f64> = equations.matrix.iter().map(|value| scale * value).collect();
        // The samples alone, without the prior.
        let samples = workspace.normal_equations(space, &fit.point, &self.few, detail);
        let hessian: Vec<f64> = samples.matrix.iter().map(|value| scale * value).collect();
        let evidence = OPEN_INDEPENDENT * libm::log(self.error(kept))
            + space.prior.distance(&fit.point)
            + space.prior.shrinkage(&hessian);
        let Some(upper) = solve::factor(precision, space.len()) else {
            return FormDraws { evidence, draws: Vec::new() };
        };
        let mut distance = |x: &[f64]| scale * workspace.error(space, x, &batch, detail);
        let least = distance(&fit.point);
        let mut all = Vec::with_capacity(count);
        for _ in 0..count {
            let deviations: Vec<f64> = (0..space.len()).map(|_| f64::from(stream.bell())).collect();
            let square: f64 = deviations.iter().map(|z| z * z).sum();
            let change = solve::backward(&upper, deviations);
            let mut x: Vec<f64> = fit.point.iter().zip(change).map(|(x, by)| x + by).collect();
            space.clamp(&mut x);
            // -2 ln of the weight.
            let weight = distance(&x) - least - square;
            let genome = Form::genome(space.models(&x)).expect("one or two models are a genome");
            if weight.is_finite() {
                all.push(Draw { genome, weight });
            }
        }
        let least = all.iter().map(|draw| draw.weight).fold(f64::INFINITY, f64::min);
        all.iter_mut().for_each(|draw| draw.weight = libm::exp(-0.5 * (draw.weight - least)));
        let number = all.len().max(1) as f64;
        let most = weights(&all) / number.sqrt();
        all.iter_mut().for_each(|draw| draw.weight = draw.weight.min(most));
        let sum = weights(&all);
        all.iter_mut().for_each(|draw| draw.weight /= sum);
        FormDraws { evidence, draws: all }
    }
}

fn weights(draws: &[Draw]) -> f64 {
    draws.iter().map(|draw| draw.weight).sum()
}

/// Draws `count` materials by weight, in equal steps of the summed weights. The weight of a
/// material is the probability of its form times its weight within the form.
fn resampled(drawn: &[FormDraws], count: usize) -> Vec<Genome> {
    let share = |form: &FormDraws| match form.draws.is_empty() {
        true => 0.0,
        false => libm::exp(-0.5 * form.evidence),
    };
    let step = drawn.iter().map(share).sum::<f64>() / count.max(1) as f64;
    let (mut passed, mut next) = (0.0, 0.5 * step);
    let mut chosen = Vec::with_capacity(count);
    for form in drawn {
        for draw in &form.draws {
            passed += share(form) * draw.weight;
            while chosen.len() < count && next < passed {
                chosen.push(draw.genome.clone());
                next += step;
            }
        }
    }
    chosen
}
