//! Errors of a found material on its target.

use brood_eval::{EvalError, energy_limit};
use brood_genome::Genome;
use brood_program::Program;
use brood_target::{MeasuredTarget, Samples, metric};
use rayon::prelude::*;

use crate::method::{Candidate, Outcome};

/// A found material with its errors, measured under the energy limit.
#[derive(Debug, Clone)]
pub struct Found {
    /// The material.
    pub genome: Genome,
    /// Number of scalar operations per sample, under the energy limit.
    pub operations: usize,
    /// Number of fitted parameters.
    pub parameters: usize,
    /// E_log on the fitted samples: training and validation samples together.
    pub fitted: f64,
    /// E_log on the held-out samples.
    pub e_log: f64,
    /// E_cbrt on the held-out samples.
    pub e_cbrt: f64,
    /// Relative L2 error on the held-out samples.
    pub relative_l2: f64,
    /// Divisor of the energy limit; 1 if the material is within it.
    pub divisor: f64,
}

impl Found {
    /// Measures several candidates in parallel.
    ///
    /// # Errors
    /// Returns [`EvalError`] if a program cannot be evaluated.
    pub fn all(candidates: &[Candidate], target: &MeasuredTarget) -> Result<Vec<Self>, EvalError> {
        candidates.par_iter().map(|candidate| Self::of(candidate, target)).collect()
    }

    /// Measures one candidate.
    ///
    /// # Errors
    /// Returns [`EvalError`] if its program cannot be evaluated.
    pub fn of(candidate: &Candidate, target: &MeasuredTarget) -> Result<Self, EvalError> {
        let Candidate { genome, parameters, .. } = candidate;
        let program = Program::lower(genome);
        let divisor = energy_limit(&program).divisor;
        let program = limited(program, divisor);
        let (held, fitted) = (pair(&program, &target.held)?, pair(&program, &target.fitted)?);
        Ok(Self {
            genome: genome.clone(),
            operations: program.steps().len(),
            parameters: *parameters,
            fitted: metric::e_log(&fitted[0], &fitted[1]),
            e_log: metric::e_log(&held[0], &held[1]),
            e_cbrt: metric::e_cbrt(&held[0], &held[1]),
            relative_l2: metric::relative_l2(&held[0], &held[1]),
            divisor,
        })
    }

    /// Index of the best candidate of a measured front: the one of least E_log on the held-out
    /// samples, which is the error that users see, or the choice of a search by probability.
    ///
    /// # Panics
    /// If the front has another number of candidates.
    #[must_use]
    pub fn best(front: &[Self], outcome: &Outcome) -> usize {
        assert_eq!(front.len(), outcome.front.len(), "every candidate is measured");
        if outcome.is_settled {
            return outcome.best;
        }
        // The search's choice comes first, so that it stands among equals.
        let all = std::iter::once(outcome.best).chain(0..front.len());
        let least = all.min_by(|a, b| front[*a].e_log.total_cmp(&front[*b].e_log));
        least.expect("the front has the choice")
    }

    /// Returns E_log on the samples as they were measured: the error that the target's floor is a
    /// lower bound of. `None` if the target has no floor.
    ///
    /// # Errors
    /// Returns [`EvalError`] if the program cannot be evaluated.
    pub fn e_log_as_measured(&self, target: &MeasuredTarget) -> Result<Option<f64>, EvalError> {
        let Some(measured) = &target.measured else { return Ok(None) };
        let program = limited(Program::lower(&self.genome), self.divisor);
        let [wanted, found] = pair(&program, &measured.samples)?;
        Ok(Some(metric::e_log(&wanted, &found)))
    }
}

/// Returns the program under the energy limit of that divisor.
pub(crate) fn limited(program: Program, divisor: f64) -> Program {
    if divisor > 1.0 { program.divided(divisor) } else { program }
}

/// Observations, and the same of a program.
fn pair(program: &Program, samples: &Samples) -> Result<[Vec<[f64; 3]>; 2], EvalError> {
    Ok([samples.observed(), samples.observed_of(program)?])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gp::breed::random;
    use brood_genome::BirthKey;
    use brood_target::Strategy;

    fn genome() -> Genome {
        random(Strategy::DIALECT, BirthKey { seed: 1, slot: 0, attempt: 0 })
    }

    /// A candidate and its measured error on the held-out samples.
    fn one(e_log: f64) -> (Candidate, Found) {
        let genome = genome();
        let candidate = Candidate { genome: genome.clone(), parameters: 8, fitted: 0.1, held: 0.1 };
        let found = Found {
            genome,
            operations: 10,
            parameters: 8,
            fitted: 0.1,
            e_log,
            e_cbrt: 0.0,
            relative_l2: 0.0,
            divisor: 1.0,
        };
        (candidate, found)
    }

    #[test]
    fn best_has_the_least_held_out_error_unless_the_choice_is_settled() {
        let best = |is_settled: bool, errors: [f64; 3]| {
            let (front, found): (Vec<Candidate>, Vec<Found>) = errors.map(one).into_iter().unzip();
            Found::best(&found, &Outcome { front, best: 1, is_settled })
        };
        assert_eq!(best(false, [0.2, 0.3, 0.1]), 2);
        assert_eq!(best(false, [0.1, 0.1, 0.1]), 1);
        assert_eq!(best(true, [0.2, 0.3, 0.1]), 1);
    }
}
