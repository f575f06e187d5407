//! A material that was found, held against its target.

use brood_eval::{EvalError, energy_limit};
use brood_genome::Genome;
use brood_program::Program;
use rayon::prelude::*;

use crate::method::Candidate;
use crate::{MeasuredTarget, Samples, metric};

/// A material that was found, as far off as it is under the energy limit.
#[derive(Debug, Clone)]
pub struct Found {
    /// The material.
    pub genome: Genome,
    /// Scalar operations a sample, under the energy limit.
    pub operations: usize,
    /// Numbers that were fitted.
    pub numbers: usize,
    /// E_log on the samples it was fitted to.
    pub fitted: f64,
    /// E_log on those held out.
    pub e_log: f64,
    /// E_cbrt on those held out.
    pub e_cbrt: f64,
    /// Relative L2 difference on those held out.
    pub relative_l2: f64,
    /// By what the energy limit divides.
    pub divisor: f64,
}

impl Found {
    /// Measures candidates at once.
    pub fn all(candidates: &[Candidate], target: &MeasuredTarget) -> Result<Vec<Self>, EvalError> {
        candidates.par_iter().map(|candidate| Self::of(candidate, target)).collect()
    }

    /// Measures a candidate.
    pub fn of(candidate: &Candidate, target: &MeasuredTarget) -> Result<Self, EvalError> {
        let Candidate { genome, numbers, .. } = candidate;
        let program = Program::lower(genome);
        let divisor = energy_limit(&program).divisor;
        let program = if divisor > 1.0 { program.divided(divisor) } else { program };
        let of = |samples: &Samples| {
            let found = Samples::of_program(&program, samples.pairs().to_vec())?;
            Ok::<_, EvalError>((samples.weighted(), found.weighted()))
        };
        let (held, fitted) = (of(&target.held)?, of(&target.fitted)?);
        Ok(Self {
            genome: genome.clone(),
            operations: program.steps().len(),
            numbers: *numbers,
            fitted: metric::e_log(&fitted.0, &fitted.1),
            e_log: metric::e_log(&held.0, &held.1),
            e_cbrt: metric::e_cbrt(&held.0, &held.1),
            relative_l2: metric::relative_l2(&held.0, &held.1),
            divisor,
        })
    }
}
