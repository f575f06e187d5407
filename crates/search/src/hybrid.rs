//! Lobes first, then genetic programs: fits give the least error, programs the short ones, and both are on one front.

use brood_genome::Genome;
use brood_program::Program;
use serde::{Deserialize, Serialize};

use crate::gp::Gp;
use crate::lobes::{Fit, Fitted, outcome};
use crate::method::{Candidate, GoOn, Method, Outcome, Progress};
use crate::{Probe, Samples};

/// Generations of lobes.
const LOBES: u32 = 8;
/// How many times as long as the ones before the last of these takes, in which lobes are shortened and programs begin.
const LAST_TAKES: f64 = 5.0;
/// Of their front, that many are started from.
const STARTED: usize = 6;

/// A search of two strategies.
pub(crate) struct Hybrid {
    lobes: Fit,
    samples: Samples,
    start: Vec<Genome>,
    seed: u64,
    gp: Option<Later>,
}

/// What there is once lobes are done.
struct Later {
    /// The front of lobes, refined on all samples; after a break it is not known before the end.
    found: Option<Outcome>,
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

    /// Genetic programs after the lobes, whose front that is.
    fn later(&self, front: Vec<Fitted>) -> Option<Later> {
        let unrefined = outcome(front)?;
        // Not refined on what the programs are chosen by.
        let genome = |candidate: &Candidate| candidate.genome.clone();
        let step = unrefined.front.len().div_ceil(STARTED).max(1);
        let mut start = self.start.clone();
        start.push(genome(&unrefined.front[unrefined.best]));
        start.extend(unrefined.front.iter().step_by(step).map(genome));
        let gp = Gp::new(&self.samples, &start, self.seed, true);
        Some(Later { found: None, gp })
    }

    /// The front of lobes refined.
    fn found(&self, front: impl Iterator<Item = Fitted>, go_on: &mut GoOn<'_>) -> Option<Outcome> {
        outcome(self.lobes.refine(front, go_on))
    }
}

/// Of two fronts what nothing as short is as good as, from the longest to the shortest, and the better of their best.
fn joined(a: Outcome, b: Outcome) -> Option<Outcome> {
    let [first, second] = [&a, &b].map(|outcome| outcome.front[outcome.best].clone());
    let best = if second.off() < first.off() { second } else { first };
    let mut all: Vec<(usize, Candidate)> = a
        .front
        .into_iter()
        .chain(b.front)
        .map(|candidate| (Program::lower(&candidate.genome).operations(), candidate))
        .collect();
    all.sort_by(|(a, first), (b, second)| a.cmp(b).then(first.off().total_cmp(&second.off())));
    let mut least = f64::INFINITY;
    all.retain(|(_, candidate)| {
        let is_better = candidate.off() < least;
        least = least.min(candidate.off());
        is_better || *candidate == best
    });
    let front: Vec<Candidate> = all.into_iter().rev().map(|(_, candidate)| candidate).collect();
    let index = front.iter().position(|candidate| *candidate == best)?;
    Some(Outcome { front, best: index })
}

impl Method for Hybrid {
    fn step(&mut self) -> Progress {
        match &mut self.gp {
            Some(later) => {
                later.gp.step();
            }
            None => {
                let progress = self.lobes.step();
                if progress.generation == LOBES {
                    let front: Vec<Fitted> = self.lobes.front().collect();
                    let found = self.found(front.iter().cloned(), &mut || true);
                    self.gp = self.later(front).map(|later| Later { found, ..later });
                }
            }
        }
        self.progress()
    }

    fn progress(&self) -> Progress {
        let lobes = Method::progress(&self.lobes);
        let Some(later) = &self.gp else { return lobes };
        let gp = later.gp.progress();
        let (generation, evaluations) =
            (lobes.generation + gp.generation, lobes.evaluations + gp.evaluations);
        let off = |progress: &Progress| progress.fitted.powi(2) + progress.held.powi(2);
        let ahead = if off(&gp) < off(&lobes) { gp } else { lobes };
        Progress { generation, evaluations, ..ahead }
    }

    fn probe(&self) -> Probe {
        match &self.gp {
            Some(later) => later.gp.probe(),
            None => self.lobes.probe(),
        }
    }

    fn best(&self) -> Option<Candidate> {
        let lobes = Method::best(&self.lobes);
        let Some(gp) = self.gp.as_ref().and_then(|later| later.gp.best()) else { return lobes };
        let is_behind = |lobes: &Candidate| gp.off() < lobes.off();
        if lobes.as_ref().is_none_or(is_behind) { Some(gp) } else { lobes }
    }

    fn next_takes(&self) -> f64 {
        let is_last = Method::progress(&self.lobes).generation + 1 == LOBES;
        if self.gp.is_none() && is_last { LAST_TAKES } else { 1.0 }
    }

    fn finish(&self, go_on: &mut GoOn<'_>) -> Option<Outcome> {
        let Some(later) = &self.gp else { return Method::finish(&self.lobes, go_on) };
        let found = match &later.found {
            Some(found) => found.clone(),
            None => self.found(self.lobes.front(), go_on)?,
        };
        match later.gp.finish(go_on) {
            Some(gp) => joined(found, gp),
            None => Some(found),
        }
    }

    fn is_short(&self) -> bool {
        self.gp.as_ref().is_some_and(|later| later.found.is_some())
    }

    fn save(&self) -> Vec<u8> {
        let state =
            State { lobes: self.lobes.save(), gp: self.gp.as_ref().map(|later| later.gp.save()) };
        postcard::to_stdvec(&state).expect("bytes can be written")
    }

    fn load(&mut self, state: &[u8]) -> Option<()> {
        let state: State = postcard::from_bytes(state).ok()?;
        self.lobes.load(&state.lobes)?;
        self.gp = match state.gp {
            Some(state) => {
                let mut later = self.later(self.lobes.front().collect())?;
                later.gp.load(&state)?;
                Some(later)
            }
            None => None,
        };
        Some(())
    }
}
