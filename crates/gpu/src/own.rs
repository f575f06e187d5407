//! Pipelines of single programs: when one is worth its compilation, which are kept, and the proof that each gives the
//! bits of the interpreter before it is used.

use std::time::Instant;

use brood_program::{Program, ProgramHash};

use crate::engine::{Batch, Engine};
use crate::pipeline::Compiled;
use crate::straight::{MAX_STEPS, source};
use crate::{GpuError, OwnPipelinePolicy};

/// Programs that are watched at once.
const WATCHED: usize = 256;
/// Pipelines that are kept.
const KEPT: usize = 32;
/// What a step is taken to cost in compilation until one was compiled. Measured on llvmpipe, which is slow at it.
const FIRST_GUESS_S: f64 = 1e-3;

#[derive(Debug)]
struct Watched {
    hash: ProgramHash,
    /// What interpreting it took so far.
    spent_s: f64,
    last_use: u64,
    state: State,
}

#[derive(Debug)]
enum State {
    Interpreted,
    Own(Compiled),
    /// Its own code was refused, or gave other bits; it stays with the interpreter.
    Rejected,
}

/// The programs that were evaluated alone of late.
#[derive(Debug)]
pub(crate) struct OwnPipelines {
    policy: OwnPipelinePolicy,
    watched: Vec<Watched>,
    compile_s_per_step: f64,
    clock: u64,
}

impl OwnPipelines {
    pub(crate) fn new(policy: OwnPipelinePolicy) -> Self {
        Self { policy, watched: Vec::new(), compile_s_per_step: FIRST_GUESS_S, clock: 0 }
    }

    /// The pipeline of a program, if it has one.
    pub(crate) fn pipeline(&mut self, hash: ProgramHash) -> Option<Compiled> {
        match &self.watch(hash)?.state {
            State::Own(compiled) => Some(compiled.clone()),
            State::Interpreted | State::Rejected => None,
        }
    }

    /// Takes note of what interpreting a program took.
    pub(crate) fn note(&mut self, hash: ProgramHash, seconds: f64) {
        if let Some(watched) = self.watch(hash) {
            watched.spent_s += seconds;
        }
    }

    /// Whether as much was spent on interpreting as compilation is going to take: whatever comes after, this costs at
    /// most twice what the better choice would have cost.
    pub(crate) fn is_worth_while(&mut self, hash: ProgramHash, steps: usize) -> bool {
        let always = self.policy == OwnPipelinePolicy::Always;
        let price_s = self.compile_s_per_step * steps.max(8) as f64;
        let Some(watched) = self.watch(hash) else { return false };
        let is_due = always || watched.spent_s >= price_s;
        is_due && steps <= MAX_STEPS && matches!(watched.state, State::Interpreted)
    }

    /// Keeps a pipeline, and lets go the one used longest ago where there are too many.
    pub(crate) fn keep(&mut self, hash: ProgramHash, compiled: Compiled) {
        if let Some(watched) = self.watch(hash) {
            watched.state = State::Own(compiled);
        }
        let is_own = |watched: &&mut Watched| matches!(watched.state, State::Own(_));
        if self.watched.iter_mut().filter(is_own).count() > KEPT {
            let oldest = self.watched.iter_mut().filter(is_own).min_by_key(|w| w.last_use);
            if let Some(oldest) = oldest {
                (oldest.state, oldest.spent_s) = (State::Interpreted, 0.0);
            }
        }
    }

    fn reject(&mut self, hash: ProgramHash) {
        if let Some(watched) = self.watch(hash) {
            watched.state = State::Rejected;
        }
    }

    fn note_compilation(&mut self, steps: usize, seconds: f64) {
        self.compile_s_per_step = seconds / steps.max(8) as f64;
    }

    /// What is known of a program, as used now; nothing where the policy forbids pipelines.
    fn watch(&mut self, hash: ProgramHash) -> Option<&mut Watched> {
        if self.policy == OwnPipelinePolicy::Never {
            return None;
        }
        self.clock += 1;
        let place = self.watched.iter().position(|watched| watched.hash == hash);
        let place = place.unwrap_or_else(|| {
            if self.watched.len() == WATCHED {
                let oldest = (0..WATCHED).min_by_key(|at| self.watched[*at].last_use);
                self.watched.swap_remove(oldest.expect("it is full"));
            }
            let state = State::Interpreted;
            self.watched.push(Watched { hash, spent_s: 0.0, last_use: 0, state });
            self.watched.len() - 1
        });
        let watched = &mut self.watched[place];
        watched.last_use = self.clock;
        Some(watched)
    }
}

impl Engine {
    /// Compiles code of a program's own and keeps it if it gives the bits that the interpreter has just given.
    pub(crate) fn make_own(
        &mut self,
        program: &Program,
        batch: &Batch<'_, '_>,
        interpreted: &[f32],
    ) -> Result<(), GpuError> {
        let hash = program.hash();
        let started = Instant::now();
        let text = source(program, self.style);
        let mut compiled =
            match self.compile(crate::shader::Kernel::Reflectance, &text, self.style.guard) {
                Ok(compiled) => compiled,
                Err(error @ GpuError::Rejected(_)) => {
                    tracing::warn!(%error, program = %hash, "no pipeline of its own");
                    self.own.reject(hash);
                    return Ok(());
                }
                Err(error) => return Err(error),
            };
        let mut out = vec![f32::NAN; interpreted.len()];
        // Some drivers compile only now.
        self.reflectances(batch, self.style, &mut compiled, &mut out)?;
        let seconds = started.elapsed().as_secs_f64();
        self.own.note_compilation(program.steps().len(), seconds);
        let is_equal = out.iter().zip(interpreted).all(|(a, b)| a.to_bits() == b.to_bits());
        if is_equal {
            tracing::debug!(program = %hash, seconds, "a pipeline of its own");
            self.own.keep(hash, compiled);
        } else {
            tracing::warn!(program = %hash, "its own pipeline gives other bits; not used");
            self.own.reject(hash);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hash(number: u16) -> ProgramHash {
        let mut bytes = [0; 32];
        bytes[..2].copy_from_slice(&number.to_le_bytes());
        ProgramHash::from_bytes(bytes)
    }

    #[test]
    fn program_is_compiled_when_interpreting_it_has_cost_as_much() {
        let mut own = OwnPipelines::new(OwnPipelinePolicy::WhenItPays);
        own.note_compilation(100, 0.1);
        own.note(hash(1), 0.03);
        assert!(!own.is_worth_while(hash(1), 50));
        own.note(hash(1), 0.03);
        assert!(own.is_worth_while(hash(1), 50));
        assert!(!own.is_worth_while(hash(1), 70), "larger programs cost more");
        assert!(!own.is_worth_while(hash(2), 50), "another program");
        own.reject(hash(1));
        assert!(!own.is_worth_while(hash(1), 50));
    }

    #[test]
    fn watching_is_bounded_and_forgets_what_was_used_longest_ago() {
        let mut own = OwnPipelines::new(OwnPipelinePolicy::WhenItPays);
        for number in 0..2000 {
            own.note(hash(7), 1.0);
            own.note(hash(1000 + number), 0.0);
        }
        assert_eq!(own.watched.len(), WATCHED);
        assert!(own.is_worth_while(hash(7), 1000));
    }

    #[test]
    fn policy_decides_against_every_measurement() {
        let mut never = OwnPipelines::new(OwnPipelinePolicy::Never);
        never.note(hash(1), 1e9);
        assert!(!never.is_worth_while(hash(1), 1));
        let mut always = OwnPipelines::new(OwnPipelinePolicy::Always);
        assert!(always.is_worth_while(hash(1), MAX_STEPS));
        assert!(!always.is_worth_while(hash(1), MAX_STEPS + 1));
    }
}
