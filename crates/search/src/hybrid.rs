//! Hybrid strategy: lobes first, then genetic programs. Lobes give the least error, genetic
//! programs the shortest code; the result is one front of both.

use brood_genome::Genome;
use brood_program::Program;
use brood_target::Samples;
use serde::{Deserialize, Serialize};

use crate::Probe;
use crate::gp::Gp;
use crate::lobes::{Fit, Fitted, outcome};
use crate::method::{Candidate, HasTime, Method, Outcome, Progress};

/// Number of generations of lobes.
const LOBES: u32 = 8;
/// Estimated duration of the last of these generations, as a multiple of the others. It also prunes
/// the lobes and creates the first genetic programs.
const LAST_GENERATION_COST: f64 = 5.0;
/// Number of candidates of the lobes' front that the genetic programs start from.
const GP_STARTS: usize = 6;

/// A search of two stages: lobes, then genetic programs.
pub(crate) struct Hybrid {
    lobes: Fit,
    samples: Samples,
    start: Vec<Genome>,
    seed: u64,
    gp: Option<GpStage>,
}

/// The second stage.
struct GpStage {
    /// Front of lobes refined on all samples. Not part of the checkpoint: `None` after a resume,
    /// and then computed by [`Method::finish`].
    lobes_front: Option<Outcome>,
    gp: Gp,
}

#[derive(Serialize, Deserialize)]
struct State {
    lobes: Vec<u8>,
    gp: Option<Vec<u8>>,
}

impl Hybrid {
    pub(crate) fn new(lobes: Fit, samples: &Samples, start: &[Genome], seed: u64) -> Self {
        Self { lobes, samples: samples.clone(), start: start.to_vec(), seed, gp: None }
    }

    /// Creates the second stage from the front of the lobes.
    fn gp_stage(&self, front: Vec<Fitted>) -> Option<GpStage> {
        let unrefined = outcome(front)?;
        // The unrefined front: refined candidates are fitted to the validation samples, by which
        // genetic programs are chosen.
        let genome = |candidate: &Candidate| candidate.genome.clone();
        let step = unrefined.front.len().div_ceil(GP_STARTS).max(1);
        let mut start = self.start.clone();
        start.push(genome(&unrefined.front[unrefined.best]));
        start.extend(unrefined.front.iter().step_by(step).map(genome));
        let gp = Gp::new(&self.samples, &start, self.seed, true);
        Some(GpStage { lobes_front: None, gp })
    }

    /// Best genetic program, if it is better than the best lobes.
    fn better_program(&self) -> Option<Candidate> {
        let best = self.gp.as_ref()?.gp.best()?;
        let lobes = Method::progress(&self.lobes).ranking_error();
        (best.ranking_error() < lobes).then_some(best)
    }

    /// Refines the front of lobes on all samples.
    fn refined(
        &self,
        front: impl Iterator<Item = Fitted>,
        has_time: &mut HasTime<'_>,
    ) -> Option<Outcome> {
        outcome(self.lobes.refine(front, has_time))
    }
}

/// Merges two fronts: drops candidates that a shorter or equally short one matches in error, orders
/// the rest from the longest to the shortest, and keeps the better of both best candidates.
fn merge(a: Outcome, b: Outcome) -> Option<Outcome> {
    let [first, second] = [&a, &b].map(|outcome| outcome.front[outcome.best].clone());
    let best = if second.ranking_error() < first.ranking_error() { second } else { first };
    let mut all: Vec<(usize, Candidate)> = a
        .front
        .into_iter()
        .chain(b.front)
        .map(|candidate| (Program::lower(&candidate.genome).operations(), candidate))
        .collect();
    all.sort_by(|(a, first), (b, second)| {
        a.cmp(b).then(first.ranking_error().total_cmp(&second.ranking_error()))
    });
    let mut least = f64::INFINITY;
    all.retain(|(_, candidate)| {
        let is_better = candidate.ranking_error() < least;
        least = least.min(candidate.ranking_error());
        is_better || *candidate == best
    });
    let front: Vec<Candidate> = all.into_iter().rev().map(|(_, candidate)| candidate).collect();
    let index = front.iter().position(|candidate| *candidate == best)?;
    Some(Outcome { front, best: index, is_settled: false })
}

impl Method for Hybrid {
    fn step(&mut self) -> Progress {
        match &mut self.gp {
            Some(stage) => {
                stage.gp.step();
            }
            None => {
                let progress = self.lobes.step();
                if progress.generation == LOBES {
                    let front: Vec<Fitted> = self.lobes.front().collect();
                    let lobes_front = self.refined(front.iter().cloned(), &mut || true);
                    self.gp = self.gp_stage(front).map(|stage| GpStage { lobes_front, ..stage });
                }
            }
        }
        self.progress()
    }

    fn progress(&self) -> Progress {
        let lobes = Method::progress(&self.lobes);
        let Some(stage) = &self.gp else { return lobes };
        let gp = stage.gp.progress();
        let (generation, evaluations) =
            (lobes.generation + gp.generation, lobes.evaluations + gp.evaluations);
        let ahead = if gp.ranking_error() < lobes.ranking_error() { gp } else { lobes };
        Progress { generation, evaluations, ..ahead }
    }

    fn probe(&self) -> Probe {
        match &self.gp {
            Some(stage) => stage.gp.probe(),
            None => self.lobes.probe(),
        }
    }

    fn best(&self) -> Option<Candidate> {
        self.better_program().or_else(|| Method::best(&self.lobes))
    }

    fn result(&self) -> Option<Candidate> {
        self.better_program().or_else(|| Method::result(&self.lobes))
    }

    fn next_step_cost(&self) -> f64 {
        let is_last = Method::progress(&self.lobes).generation + 1 == LOBES;
        if self.gp.is_none() && is_last { LAST_GENERATION_COST } else { 1.0 }
    }

    fn finish(&self, has_time: &mut HasTime<'_>) -> Option<Outcome> {
        let Some(stage) = &self.gp else { return Method::finish(&self.lobes, has_time) };
        let lobes_front = match &stage.lobes_front {
            Some(lobes_front) => lobes_front.clone(),
            None => self.refined(self.lobes.front(), has_time)?,
        };
        match stage.gp.finish(has_time) {
            Some(gp) => merge(lobes_front, gp),
            None => Some(lobes_front),
        }
    }

    fn finishes_quickly(&self) -> bool {
        self.gp.as_ref().is_some_and(|stage| stage.lobes_front.is_some())
    }

    fn emigrants(&self) -> Vec<Genome> {
        self.gp.as_ref().map_or_else(Vec::new, |stage| stage.gp.emigrants())
    }

    fn immigrate(&mut self, genomes: &[Genome]) {
        if let Some(stage) = &mut self.gp {
            stage.gp.immigrate(genomes);
        }
    }

    fn save(&self) -> Vec<u8> {
        let state =
            State { lobes: self.lobes.save(), gp: self.gp.as_ref().map(|stage| stage.gp.save()) };
        postcard::to_stdvec(&state).expect("plain data serialises")
    }

    fn load(&mut self, state: &[u8]) -> Option<()> {
        let state: State = postcard::from_bytes(state).ok()?;
        self.lobes.load(&state.lobes)?;
        self.gp = match state.gp {
            // The genomes that islands restart from are not in the checkpoint: prunes again.
            Some(state) => {
                let mut stage = self.gp_stage(self.lobes.front().collect())?;
                stage.gp.load(&state)?;
                Some(stage)
            }
            None => None,
        };
        Some(())
    }
}
