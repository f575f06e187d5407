//! The state of a fit of lobes as bytes, and a fit as a search's method.

use serde::{Deserialize, Serialize};

use super::Lobes;
use super::damped::Damped;
use super::finish::Fitted;
use super::schedule::{Fit, Kept};
use crate::Probe;
use crate::method::{Candidate, GoOn, Method, Outcome, Progress};

/// All that the next generations depend on besides samples, shapes and seed.
#[derive(Serialize, Deserialize)]
struct State {
    generation: u32,
    evaluations: u64,
    cost: f64,
    is_under: bool,
    kept: Vec<KeptState>,
}

#[derive(Serialize, Deserialize)]
struct KeptState {
    problem: u32,
    numbers: Vec<f64>,
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

    fn finish(&self, go_on: &mut GoOn<'_>) -> Option<Outcome> {
        outcome(self.refine(self.front(), go_on))
    }

    fn is_short(&self) -> bool {
        false
    }

    fn save(&self) -> Vec<u8> {
        let kept = |kept: &Kept| {
            let Damped { lobes, error, damping, .. } = &kept.damped;
            KeptState {
                problem: u32::try_from(kept.problem).expect("there are few shapes"),
                numbers: lobes.numbers.clone(),
                free: lobes.free.clone(),
                error: *error,
                damping: *damping,
                held: kept.held,
            }
        };
        let kept = self.kept.iter().map(kept).collect();
        let Self { generation, evaluations, cost, is_under, .. } = *self;
        let state = State { generation, evaluations, cost, is_under, kept };
        postcard::to_stdvec(&state).expect("numbers can be written")
    }

    fn load(&mut self, state: &[u8]) -> Option<()> {
        let state: State = postcard::from_bytes(state).ok()?;
        let kept = |kept: KeptState| {
            let problem = usize::try_from(kept.problem).ok()?;
            let shape = self.shapes.get(problem)?.shape.clone();
            let is_whole = kept.numbers.len() == shape.len() && kept.free.len() == shape.len();
            let KeptState { numbers, free, error, damping, held, .. } = kept;
            let lobes = Lobes { shape, numbers, free };
            is_whole.then_some(Kept {
                problem,
                held,
                damped: Damped { lobes, error, damping, tries: 0 },
            })
        };
        let kept = state.kept.into_iter().map(kept).collect::<Option<Vec<_>>>()?;
        self.set_cost(state.cost);
        if state.is_under {
            self.set_under();
        }
        (self.generation, self.evaluations, self.kept) =
            (state.generation, state.evaluations, kept);
        Some(())
    }
}

/// Lobes as a search's result.
pub(crate) fn outcome(front: Vec<Fitted>) -> Option<Outcome> {
    let of = |fitted: Fitted| (candidate(&fitted.lobes, fitted.fitted, fitted.held), fitted.off);
    Outcome::of(front.into_iter().map(of).collect())
}

fn candidate(lobes: &Lobes, fitted: f64, held: f64) -> Candidate {
    let genome = lobes.genome().expect("a search's shapes have room in a program");
    Candidate { genome, numbers: lobes.free(), fitted, held }
}
