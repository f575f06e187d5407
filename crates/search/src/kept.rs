//! The best result so far by the error that is reported: E_log on the held-out samples. Searches
//! choose by the samples that they are given, so a later best may have a larger error on others.

use brood_genome::Genome;
use brood_program::Program;
use brood_target::{Samples, metric};
use serde::{Deserialize, Serialize};

use crate::found::limited;
use crate::gp::Albedos;
use crate::method::{Candidate, Method};

/// Measures the best result of each generation on held-out samples.
pub(crate) struct Reported {
    held_out: Samples,
    albedos: Albedos,
    /// Best candidate that was measured last.
    last: Option<Genome>,
}

/// A result with its error on the held-out samples.
#[derive(Debug, Clone)]
pub(crate) struct Kept {
    pub(crate) candidate: Candidate,
    pub(crate) error: f64,
}

impl Reported {
    pub(crate) fn new(held_out: &Samples) -> Self {
        Self { held_out: held_out.clone(), albedos: Albedos::new(), last: None }
    }

    /// Replaces `kept` if the best candidate has changed and its result has a smaller error.
    pub(crate) fn offer(&mut self, method: &dyn Method, kept: &mut Option<Kept>) {
        let best = method.best().map(|best| best.genome);
        if best == self.last {
            return;
        }
        self.last = best;
        let Some(candidate) = method.result() else { return };
        let Some(error) = self.error(&candidate.genome) else { return };
        if kept.as_ref().is_none_or(|kept| error < kept.error) {
            *kept = Some(Kept { candidate, error });
        }
    }

    /// E_log on the held-out samples under the approximate energy limit; `None` if the program
    /// cannot be evaluated.
    fn error(&self, genome: &Genome) -> Option<f64> {
        let program = Program::lower(genome);
        let divisor = self.albedos.divisors(&[&program])[0];
        let found = self.held_out.observed_of(&limited(program, divisor)).ok()?;
        Some(metric::e_log(&self.held_out.observed(), &found))
    }
}

/// [`Kept`] in a checkpoint.
#[derive(Serialize, Deserialize)]
pub(crate) struct KeptState {
    genome: Vec<u8>,
    parameters: u32,
    fitted: f64,
    held: f64,
    error: f64,
}

impl KeptState {
    pub(crate) fn of(kept: &Kept) -> Self {
        let Kept { candidate: Candidate { genome, parameters, fitted, held }, error } = kept;
        Self {
            genome: genome.canonical_bytes(),
            parameters: u32::try_from(*parameters).expect("materials have few parameters"),
            fitted: *fitted,
            held: *held,
            error: *error,
        }
    }

    /// `None` if the genome is damaged.
    pub(crate) fn kept(self) -> Option<Kept> {
        let Self { genome, parameters, fitted, held, error } = self;
        let genome = Genome::from_canonical_bytes(&genome).ok()?;
        let parameters = usize::try_from(parameters).ok()?;
        Some(Kept { candidate: Candidate { genome, parameters, fitted, held }, error })
    }
}
