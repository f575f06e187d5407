//! The state of a fit of models as bytes, and the fit as a search's method.

use brood_brdf::ModelKind;
use serde::{Deserialize, Serialize};

use super::Form;
use super::climb::Climb;
use super::residual::Space;
use super::schedule::{Analytic, Finished, Kept};
use crate::Probe;
use crate::method::{Candidate, GoOn, Method, Outcome, Progress};

/// All that the next generations depend on besides samples, kinds and seed.
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
    climb: Climb,
    held: f64,
}

impl Method for Analytic {
    fn step(&mut self) -> Progress {
        Self::step(self)
    }

    fn progress(&self) -> Progress {
        Self::progress(self)
    }

    fn probe(&self) -> Probe {
        let errors = self.kept.iter().map(|kept| kept.climb.error.sqrt());
        Probe::of(errors.zip(self.kept.iter().map(|kept| &kept.space.form)), 0)
    }

    fn best(&self) -> Option<Candidate> {
        self.kept.first().map(|kept| candidate(Finished::of(kept)))
    }

    fn finish(&self, _: &mut GoOn<'_>) -> Option<Outcome> {
        let of = |found| {
            let candidate = candidate(found);
            let off = candidate.off();
            (candidate, off)
        };
        Outcome::of(self.front().into_iter().map(of).collect())
    }

    fn save(&self) -> Vec<u8> {
        let kept = |kept: &Kept| {
            let Kept { space, climb, held } = kept.clone();
            KeptState { form: space.form, climb, held }
        };
        let state = State {
            generation: self.generation,
            evaluations: self.evaluations,
            kinds: self.kinds.iter().map(|kind| kind.number()).collect(),
            kept: self.kept.iter().map(kept).collect(),
        };
        postcard::to_stdvec(&state).expect("numbers can be written")
    }

    fn load(&mut self, state: &[u8]) -> Option<()> {
        let state: State = postcard::from_bytes(state).ok()?;
        let kept = |KeptState { form, climb, held }: KeptState| {
            if !form.is_sound() {
                return None;
            }
            let space = Space::new(form);
            (space.len() == climb.x.len()).then_some(Kept { space, climb, held })
        };
        let kinds = state.kinds.into_iter().map(ModelKind::from_number);
        self.kinds = kinds.collect::<Option<Vec<_>>>()?;
        self.kept = state.kept.into_iter().map(kept).collect::<Option<Vec<_>>>()?;
        (self.generation, self.evaluations) = (state.generation, state.evaluations);
        Some(())
    }
}

fn candidate(found: Finished) -> Candidate {
    let Finished { models, numbers, fitted, held } = found;
    let genome = Form::genome(models).expect("one or two models are a genome");
    Candidate { genome, numbers, fitted: fitted.sqrt(), held: held.sqrt() }
}
