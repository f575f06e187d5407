//! Searches of pictures by lobes and genetic programs: models first, whose prior says what f is
//! likely to be at directions that the pictures do not show.
//!
//! Pictures show f at few of all pairs of directions, and nothing in a fit of lobes or programs
//! holds the others: under another light, such fits are off by the mean brightness and more. So a
//! few generations of models are fitted first. f of the most probable one is expected at pairs of
//! all directions ([`Samples::expected`]), and the strategy then fits samples and expected values
//! together. Where pictures show f, that model is about right, so its values hardly matter there.

use brood_brdf::DirectionPair;
use brood_genome::Genome;
use brood_program::Program;
use brood_target::{Samples, draw_pairs, narrow_pairs};
use serde::{Deserialize, Serialize};

use crate::Probe;
use crate::analytic::Analytic;
use crate::found::limited;
use crate::gp::Albedos;
use crate::method::{Candidate, HasTime, Method, Outcome, Progress};

/// Number of generations of models.
const GENERATIONS: u32 = 6;
/// One in this many pairs is close to the mirror direction, where highlights are.
const NARROW: usize = 3;

/// Creates the method that fits samples with expected values.
type Build = Box<dyn Fn(&Samples) -> Box<dyn Method> + Send>;

/// A search of two stages: models, then the strategy.
pub(crate) struct Guided {
    models: Analytic,
    /// Samples at single pairs of directions.
    samples: Samples,
    seed: u64,
    build: Build,
    method: Option<Box<dyn Method>>,
}

#[derive(Serialize, Deserialize)]
struct State {
    models: Vec<u8>,
    method: Option<Vec<u8>>,
}

impl Guided {
    /// `samples` are those that the strategy fits, `models` a new fit of the same pictures.
    pub(crate) fn new(models: Analytic, samples: Samples, seed: u64, build: Build) -> Self {
        Self { models, samples, seed, build, method: None }
    }

    /// Creates the second stage.
    fn build(&self) -> Box<dyn Method> {
        let expected = self.expected().unwrap_or_default();
        (self.build)(&self.samples.clone().with_expected(expected))
    }

    /// f of the most probable model, at as many pairs as there are samples.
    fn expected(&self) -> Option<Vec<(DirectionPair, [f64; 3])>> {
        let program = Program::lower(&Method::best(&self.models)?.genome);
        let divisor = Albedos::new().divisors(&[&program])[0];
        let count = self.samples.len();
        let mut pairs = draw_pairs(count - count / NARROW, self.seed);
        pairs.extend(narrow_pairs(count / NARROW, self.seed));
        let found = Samples::of_program(&limited(program, divisor), pairs).ok()?;
        let values = found.values().iter().map(|f| f.map(|f| f.max(0.0)));
        Some(found.pairs().iter().copied().zip(values).collect())
    }

    fn current(&self) -> &dyn Method {
        match &self.method {
            Some(method) => &**method,
            None => &self.models,
        }
    }
}

impl Method for Guided {
    fn step(&mut self) -> Progress {
        match &mut self.method {
            Some(method) => {
                method.step();
            }
            None if self.models.progress().generation < GENERATIONS => {
                self.models.step();
            }
            None => {
                let mut method = self.build();
                method.step();
                self.method = Some(method);
            }
        }
        Method::progress(self)
    }

    fn progress(&self) -> Progress {
        let models = self.models.progress();
        let Some(method) = &self.method else { return models };
        let own = method.progress();
        Progress {
            generation: models.generation + own.generation,
            evaluations: models.evaluations + own.evaluations,
            ..own
        }
    }

    fn probe(&self) -> Probe {
        self.current().probe()
    }

    fn best(&self) -> Option<Candidate> {
        self.current().best()
    }

    fn result(&self) -> Option<Candidate> {
        self.current().result()
    }

    fn finish(&self, has_time: &mut HasTime<'_>) -> Option<Outcome> {
        self.current().finish(has_time)
    }

    fn finishes_quickly(&self) -> bool {
        self.current().finishes_quickly()
    }

    fn next_step_cost(&self) -> f64 {
        self.current().next_step_cost()
    }

    fn emigrants(&self) -> Vec<Genome> {
        self.current().emigrants()
    }

    fn immigrate(&mut self, genomes: &[Genome]) {
        if let Some(method) = &mut self.method {
            method.immigrate(genomes);
        }
    }

    fn save(&self) -> Vec<u8> {
        let method = self.method.as_ref().map(|method| method.save());
        let state = State { models: Method::save(&self.models), method };
        postcard::to_stdvec(&state).expect("plain data serialises")
    }

    fn load(&mut self, state: &[u8]) -> Option<()> {
        let state: State = postcard::from_bytes(state).ok()?;
        Method::load(&mut self.models, &state.models)?;
        self.method = match state.method {
            Some(state) => {
                let mut method = self.build();
                method.load(&state)?;
                Some(method)
            }
            None => None,
        };
        Some(())
    }
}

#[cfg(test)]
#[path = "guided_tests.rs"]
mod tests;
