//! Own pipelines: straight-line shaders of single programs (straight.rs). This module decides when
//! to compile one, and caches them.

use brood_program::ProgramHash;

use crate::OwnPipelinePolicy;
use crate::pipeline::Compiled;
use crate::straight::MAX_STEPS;

/// Number of programs whose cost is tracked.
const TRACKED: usize = 256;
/// Capacity of the cache of pipelines.
const PIPELINES: usize = 32;
/// Initial estimate of compilation seconds per step, until one was measured. Measured on llvmpipe,
/// where compilation is slow.
const FIRST_GUESS_S: f64 = 1e-3;

/// A program that was evaluated alone.
#[derive(Debug)]
struct Tracked {
    hash: ProgramHash,
    /// Seconds spent on interpreting it.
    spent_s: f64,
    /// Value of [`OwnPipelines::clock`] at the last use.
    last_use: u64,
    state: State,
}

/// How a program is evaluated.
#[derive(Debug)]
enum State {
    /// By the interpreter, so far.
    Interpreted,
    /// By its own pipeline.
    Own(Compiled),
    /// Compilation of its own pipeline was rejected, or gave other bits; the program stays with the
    /// interpreter.
    Rejected,
}

/// Programs that were recently evaluated alone, with their pipelines.
#[derive(Debug)]
pub(crate) struct OwnPipelines {
    policy: OwnPipelinePolicy,
    tracked: Vec<Tracked>,
    /// Estimate of the seconds of a compilation, per step.
    compile_s_per_step: f64,
    /// Number of look-ups so far.
    clock: u64,
}

impl OwnPipelines {
    pub(crate) fn new(policy: OwnPipelinePolicy) -> Self {
        Self { policy, tracked: Vec::new(), compile_s_per_step: FIRST_GUESS_S, clock: 0 }
    }

    /// Returns the pipeline of a program, if it has one.
    pub(crate) fn pipeline(&mut self, hash: ProgramHash) -> Option<Compiled> {
        match &self.track(hash)?.state {
            State::Own(compiled) => Some(compiled.clone()),
            State::Interpreted | State::Rejected => None,
        }
    }

    /// Records the seconds spent on interpreting a program.
    pub(crate) fn note(&mut self, hash: ProgramHash, seconds: f64) {
        if let Some(tracked) = self.track(hash) {
            tracked.spent_s += seconds;
        }
    }

    /// True if interpreting the program has taken as long as compiling it is expected to take.
    /// However often the program is evaluated later, this costs at most about twice as much as the
    /// better choice.
    pub(crate) fn is_worth_while(&mut self, hash: ProgramHash, steps: usize) -> bool {
        let always = self.policy == OwnPipelinePolicy::Always;
        let compile_s = self.compile_s_per_step * steps.max(8) as f64;
        let Some(tracked) = self.track(hash) else { return false };
        let is_due = always || tracked.spent_s >= compile_s;
        is_due && steps <= MAX_STEPS && matches!(tracked.state, State::Interpreted)
    }

    /// Stores a pipeline, and evicts the least recently used one if there are too many.
    pub(crate) fn store(&mut self, hash: ProgramHash, compiled: Compiled) {
        if let Some(tracked) = self.track(hash) {
            tracked.state = State::Own(compiled);
        }
        let is_own = |tracked: &&mut Tracked| matches!(tracked.state, State::Own(_));
        if self.tracked.iter_mut().filter(is_own).count() > PIPELINES {
            let oldest = self.tracked.iter_mut().filter(is_own).min_by_key(|w| w.last_use);
            if let Some(oldest) = oldest {
                (oldest.state, oldest.spent_s) = (State::Interpreted, 0.0);
            }
        }
    }

    /// Records that a program stays with the interpreter.
    pub(crate) fn reject(&mut self, hash: ProgramHash) {
        if let Some(tracked) = self.track(hash) {
            tracked.state = State::Rejected;
        }
    }

    /// Records the seconds that a compilation took.
    pub(crate) fn note_compilation(&mut self, steps: usize, seconds: f64) {
        self.compile_s_per_step = seconds / steps.max(8) as f64;
    }

    /// Returns the entry of a program and marks it as used; `None` if the policy forbids pipelines.
    fn track(&mut self, hash: ProgramHash) -> Option<&mut Tracked> {
        if self.policy == OwnPipelinePolicy::Never {
            return None;
        }
        self.clock += 1;
        let place = self.tracked.iter().position(|tracked| tracked.hash == hash);
        let place = place.unwrap_or_else(|| {
            if self.tracked.len() == TRACKED {
                let oldest = (0..TRACKED).min_by_key(|at| self.tracked[*at].last_use);
                self.tracked.swap_remove(oldest.expect("there are tracked programs"));
            }
            let state = State::Interpreted;
            self.tracked.push(Tracked { hash, spent_s: 0.0, last_use: 0, state });
            self.tracked.len() - 1
        });
        let tracked = &mut self.tracked[place];
        tracked.last_use = self.clock;
        Some(tracked)
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
    fn program_is_compiled_when_interpreting_it_has_taken_as_long() {
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
    fn tracking_is_bounded_and_evicts_the_least_recently_used() {
        let mut own = OwnPipelines::new(OwnPipelinePolicy::WhenItPays);
        for number in 0..2000 {
            own.note(hash(7), 1.0);
            own.note(hash(1000 + number), 0.0);
        }
        assert_eq!(own.tracked.len(), TRACKED);
        assert!(own.is_worth_while(hash(7), 1000));
    }

    #[test]
    fn policy_overrides_every_measurement() {
        let mut never = OwnPipelines::new(OwnPipelinePolicy::Never);
        never.note(hash(1), 1e9);
        assert!(!never.is_worth_while(hash(1), 1));
        let mut always = OwnPipelines::new(OwnPipelinePolicy::Always);
        assert!(always.is_worth_while(hash(1), MAX_STEPS));
        assert!(!always.is_worth_while(hash(1), MAX_STEPS + 1));
    }
}
