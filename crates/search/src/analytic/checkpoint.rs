//! Checkpoint of an analytic fit, and the fit as a [`Method`].

use brood_brdf::ModelKind;
use serde::{Deserialize, Serialize};

use super::Form;
use super::kept::{Finished, Kept};
use super::residual::Space;
use super::schedule::Analytic;
use crate::Probe;
use crate::levenberg_marquardt::Solution;
use crate::method::{Candidate, HasTime, Method, Outcome, Posterior, Progress};

/// State that the next generations depend on besides samples, kinds and seed.
#[derive(Serialize, Deserialize)]
struct State {
    generation: u32,
    evaluations: u64,
    /// [`ModelKind::number`].
    kinds: Vec<u8>,
    kept: Vec<KeptState>,
}

#[derive(Serialize, Deserialize)]
struct KeptState {
    form: Form,
    x: Vec<f64>,
    error: f64,
    held: f64,
    squares: [f64; 2],
    evidence: f64,
}

impl Method for Analytic {
    fn step(&mut self) -> Progress {
        Self::step(self)
    }

    fn progress(&self) -> Progress {
        Self::progress(self)
    }

    fn posterior(&self, count: usize) -> Option<Posterior> {
        Self::posterior(self, count)
    }

    fn probe(&self) -> Probe {
        let errors = self.kept.iter().map(|kept| kept.squares[0].sqrt());
        Probe::of(errors.zip(self.kept.iter().map(|kept| &kept.space.form)), 0)
    }

    fn best(&self) -> Option<Candidate> {
        self.kept.first().map(|kept| candidate(Finished::of(kept)))
    }

    fn finish(&self, _: &mut HasTime<'_>) -> Option<Outcome> {
        let front = self.front();
        let more_probable =
            |a: usize, b: usize| if front[b].evidence <= front[a].evidence { b } else { a };
        let best = (0..front.len()).reduce(more_probable)?;
        let front = front.into_iter().map(candidate).collect();
        Some(Outcome { front, best, is_settled: true })
    }

    fn save(&self) -> Vec<u8> {
        let kept = |kept: &Kept| {
            let Kept { space, fit, held, squares, evidence } = kept.clone();
            let error = fit.error;
            KeptState { form: space.form, x: fit.point, error, held, squares, evidence }
        };
        let state = State {
            generation: self.generation,
            evaluations: self.evaluations,
            kinds: self.kinds.iter().map(|kind| kind.number()).collect(),
            kept: self.kept.iter().map(kept).collect(),
        };
        postcard::to_stdvec(&state).expect("plain data serialises")
    }

    fn load(&mut self, state: &[u8]) -> Option<()> {
        let state: State = postcard::from_bytes(state).ok()?;
        let prior = self.prior.clone();
        let kept = |KeptState { form, x, error, held, squares, evidence }: KeptState| {
            if !form.is_sound() {
                return None;
            }
            let space = Space::new(form, &prior);
            let fit = Solution { error, ..Solution::new(x) };
            let is_whole = space.len() == fit.point.len();
            is_whole.then_some(Kept { space, fit, held, squares, evidence })
        };
        let kinds = state.kinds.into_iter().map(ModelKind::from_number);
        self.kinds = kinds.collect::<Option<Vec<_>>>()?;
        self.kept = state.kept.into_iter().map(kept).collect::<Option<Vec<_>>>()?;
        (self.generation, self.evaluations) = (state.generation, state.evaluations);
        Some(())
    }
}

fn candidate(found: Finished) -> Candidate {
    let Finished { models, parameters, fitted, held, .. } = found;
    let genome = Form::genome(models).expect("one or two models are a genome");
    Candidate { genome, parameters, fitted: fitted.sqrt(), held: held.sqrt() }
}
