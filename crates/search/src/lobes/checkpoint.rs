//! Checkpoint of a fit of lobes, and the fit as a [`Method`].

use serde::{Deserialize, Serialize};

use super::Lobes;
use super::finish::Fitted;
use super::schedule::{Fit, Kept};
use crate::Probe;
use crate::levenberg_marquardt::Solution;
use crate::method::{Candidate, HasTime, Method, Outcome, Progress};

/// State that the next generations depend on besides samples, shapes and seed.
#[derive(Serialize, Deserialize)]
struct State {
    generation: u32,
    evaluations: u64,
    cost: f64,
    has_albedo_penalty: bool,
    kept: Vec<KeptState>,
}

#[derive(Serialize, Deserialize)]
struct KeptState {
    problem: u32,
    parameters: Vec<f64>,
    free: Vec<bool>,
    error: f64,
    damping: f64,
    held: f64,
}

impl Method for Fit {
    fn step(&mut self) -> Progress {
        Self::step(self)
    }

    fn progress(&self) -> Progress {
        Self::progress(self)
    }

    fn probe(&self) -> Probe {
        Self::probe(self)
    }

    fn best(&self) -> Option<Candidate> {
        let Progress { fitted, held, .. } = Self::progress(self);
        Self::best(self).map(|lobes| candidate(lobes, fitted, held))
    }

    fn result(&self) -> Option<Candidate> {
        let refined = self.refine(self.front().take(1), &mut || false);
        refined.into_iter().next().map(|of| candidate(&of.lobes, of.fitted, of.held))
    }

    fn finish(&self, has_time: &mut HasTime<'_>) -> Option<Outcome> {
        outcome(self.refine(self.front(), has_time))
    }

    fn finishes_quickly(&self) -> bool {
        false
    }

    fn save(&self) -> Vec<u8> {
        let kept = |kept: &Kept| {
            let Solution { point: lobes, error, damping, .. } = &kept.fit;
            KeptState {
                problem: u32::try_from(kept.problem).expect("there are few shapes"),
                parameters: lobes.parameters.clone(),
                free: lobes.free.clone(),
                error: *error,
                damping: *damping,
                held: kept.held,
            }
        };
        let kept = self.kept.iter().map(kept).collect();
        let Self { generation, evaluations, cost, has_albedo_penalty, .. } = *self;
        let state = State { generation, evaluations, cost, has_albedo_penalty, kept };
        postcard::to_stdvec(&state).expect("plain data serialises")
    }

    fn load(&mut self, state: &[u8]) -> Option<()> {
        let state: State = postcard::from_bytes(state).ok()?;
        let kept = |kept: KeptState| {
            let problem = usize::try_from(kept.problem).ok()?;
            let shape = self.shapes.get(problem)?.shape.clone();
            let is_whole = kept.parameters.len() == shape.len() && kept.free.len() == shape.len();
            let KeptState { parameters, free, error, damping, held, .. } = kept;
            let lobes = Lobes { shape, parameters, free };
            is_whole.then_some(Kept {
                problem,
                held,
                fit: Solution { error, damping, ..Solution::new(lobes) },
            })
        };
        let kept = state.kept.into_iter().map(kept).collect::<Option<Vec<_>>>()?;
        self.set_cost(state.cost);
        if state.has_albedo_penalty {
            self.add_albedo_penalty();
        }
        (self.generation, self.evaluations, self.kept) =
            (state.generation, state.evaluations, kept);
        Some(())
    }
}

/// Result of a search from a front of lobes.
pub(crate) fn outcome(front: Vec<Fitted>) -> Option<Outcome> {
    let of = |fitted: Fitted| {
        (candidate(&fitted.lobes, fitted.fitted, fitted.held), fitted.ranking_error)
    };
    Outcome::of(front.into_iter().map(of).collect())
}

fn candidate(lobes: &Lobes, fitted: f64, held: f64) -> Candidate {
    let genome = lobes.genome().expect("a search's shapes fit in a program");
    Candidate { genome, parameters: lobes.free(), fitted, held }
}
