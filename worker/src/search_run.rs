//! The computing part of a search: generations until there is something to tell, and the front at the end.
//!
//! It knows budgets and what is worth telling; it refuses to know servers.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use brood_eval::express;
use brood_genome::Genome;
use brood_inspect::Specimen;
use brood_protocol::{
    Budget, FoundView, GenerationLine, MeasuredMaterial, SearchGrant, SearchNews,
};
use brood_search::{
    Candidate, Found, KnownView, Options, Pace, Progress, Search, Strategy, TargetFile,
};
use rayon::prelude::*;

use crate::beside::Beside;

/// Generations that take less are told together.
const TELL: Duration = Duration::from_millis(250);
/// A best is told as soon as its error is this much of the one told before.
const NOTABLY: f64 = 0.9;

/// A search at work.
pub(crate) struct Run {
    search: Search,
    target: Arc<TargetFile>,
    budget: Budget,
    target_error: Option<f64>,
    /// Time searched, pauses and the server's time not counted.
    seconds: f64,
    /// Where the budget is one of seconds.
    pace: Option<Pace>,
    /// Error of the best that was told.
    recorded: f64,
    /// Whether there has been a generation, now or before.
    has_begun: bool,
}

/// Some generations.
pub(crate) struct Leg {
    /// What is to be told; nothing where there was no generation.
    pub(crate) news: Option<SearchNews>,
    /// Whether the budget is used up.
    pub(crate) is_over: bool,
}

impl Run {
    /// Begins, or goes on from the checkpoint.
    pub(crate) fn new(grant: SearchGrant, target: Arc<TargetFile>) -> Result<Self, String> {
        let strategy: Strategy = grant
            .strategy
            .parse()
            .map_err(|_| "server and worker are of different versions".to_owned())?;
        let start = grant.start.iter().map(|bytes| Genome::from_canonical_bytes(bytes));
        let start = start.collect::<Result<Vec<_>, _>>().map_err(|error| error.to_string())?;
        let options = Options { strategy, seed: grant.seed, is_mirrored: grant.is_mirrored, start };
        let search = match &grant.checkpoint {
            None => Search::new(&target.target.fitted, &options),
            Some(state) => Search::resume(&target.target.fitted, &options, state)
                .map_err(|error| error.to_string())?,
        };
        Ok(Self {
            search,
            target,
            budget: grant.budget,
            target_error: grant.target_error,
            seconds: grant.seconds,
            pace: match grant.budget {
                Budget::Seconds(seconds) => Some(Pace::new(seconds)),
                Budget::Generations(_) | Budget::Evaluations(_) => None,
            },
            recorded: grant.recorded.unwrap_or(f64::INFINITY),
            has_begun: grant.checkpoint.is_some(),
        })
    }

    /// Generations until the budget is used up, something notable was found, a moment has passed, or nobody wants more.
    pub(crate) fn leg(&mut self, stop: &AtomicBool) -> Result<Leg, String> {
        let begun = Instant::now();
        let (mut lines, mut best) = (Vec::new(), None);
        let mut is_over = self.has_begun && self.is_over(&self.search.progress());
        while !is_over && !stop.load(Ordering::Relaxed) {
            let (step, times) = (Instant::now(), self.search.next_takes());
            let progress = self.search.step();
            let took = step.elapsed().as_secs_f64();
            self.seconds += took;
            if let Some(pace) = &mut self.pace {
                pace.took(took, times);
            }
            self.has_begun = true;
            let probe = self.search.probe();
            lines.push(GenerationLine {
                generation: progress.generation,
                evaluations: progress.evaluations,
                fitted: progress.fitted,
                held: progress.held,
                median: probe.median,
                diversity: probe.diversity,
                repeats: probe.repeats,
                seconds: self.seconds,
            });
            is_over = self.is_over(&progress);
            if progress.held < NOTABLY * self.recorded {
                self.recorded = progress.held;
                best = match self.search.best() {
                    Some(candidate) => Some(measured(&self.target, &candidate)?),
                    None => None,
                };
                break;
            }
            if begun.elapsed() >= TELL {
                break;
            }
        }
        let news = (!lines.is_empty()).then(|| SearchNews::Generations {
            lines,
            checkpoint: self.search.checkpoint(),
            best,
        });
        Ok(Leg { news, is_over })
    }

    /// The front, the best first.
    pub(crate) fn finish(&self, stop: &AtomicBool) -> Result<SearchNews, String> {
        let (begun, mut pace) = (Instant::now(), self.pace);
        // Nobody wants what comes of it once it is to stop.
        let outcome = self.search.finish_while(|| {
            let spent = self.seconds + begun.elapsed().as_secs_f64();
            let is_in_time = pace.as_mut().is_none_or(|pace| pace.has_time(spent));
            is_in_time && !stop.load(Ordering::Relaxed)
        });
        let outcome = outcome.ok_or("the search found nothing")?;
        let best = outcome.front.get(outcome.best);
        let others = outcome.front.iter().enumerate();
        let others = others.filter(|(index, _)| *index != outcome.best).map(|(_, one)| one);
        let front: Vec<&Candidate> = best.into_iter().chain(others).collect();
        let target = &*self.target;
        let front: Result<Vec<_>, _> = front.par_iter().map(|one| measured(target, one)).collect();
        let seconds = self.seconds + begun.elapsed().as_secs_f64();
        Ok(SearchNews::Finished { front: front?, seconds })
    }

    fn is_over(&self, progress: &Progress) -> bool {
        let is_used_up = match self.budget {
            Budget::Seconds(_) => {
                self.pace.is_some_and(|pace| pace.is_over(self.seconds, &self.search))
            }
            Budget::Generations(generations) => progress.generation >= generations,
            Budget::Evaluations(evaluations) => progress.evaluations >= evaluations,
        };
        is_used_up || self.target_error.is_some_and(|error| progress.held <= error)
    }
}

fn measured(file: &TargetFile, candidate: &Candidate) -> Result<MeasuredMaterial, String> {
    let found = Found::of(candidate, &file.target).map_err(|error| error.to_string())?;
    let views = file.pictures.as_ref();
    let views = views.map(|pictures| apart(&pictures.views, &found.genome));
    let count = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
    Ok(MeasuredMaterial {
        genome: found.genome.canonical_bytes(),
        operations: count(found.operations),
        numbers: count(found.numbers),
        e_log: found.e_log,
        e_log_fitted: found.fitted,
        e_cbrt: found.e_cbrt,
        relative_l2: found.relative_l2,
        divisor: found.divisor,
        views,
    })
}

/// How far a material is from each picture, as it is seen under the energy limit.
fn apart(views: &[KnownView], genome: &Genome) -> Vec<FoundView> {
    let program = express(genome);
    let material = Specimen::Bred(genome, &program);
    let one = |known: &KnownView| {
        let Beside { error, flip, .. } = Beside::of(known, &material);
        let held_out = known.setting.is_held_out;
        FoundView { rmse: error.rmse, flip, gain: error.gain, held_out }
    };
    views.iter().map(one).collect()
}
