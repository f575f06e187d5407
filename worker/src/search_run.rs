//! Computation of a search: batches of generations, and the front at the end. Enforces the budget.
//! Independent of the server.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use brood_eval::{Developed, EvalError, encode_png, express};
use brood_genome::Genome;
use brood_inspect::Specimen;
use brood_protocol::{
    Arrival, Budget, FoundView, GenerationLine, MaterialSpread, MeasuredMaterial, NOTABLE_RATIO,
    NextScene, ReportedSpread, SearchGrant, SearchUpdate,
};
use brood_search::{
    Candidate, Found, MIGRATION, NextPicture, Options, Progress, Search, SearchError, Spread,
    SpreadMap, TimeBudget, island_seed,
};
use brood_target::{KnownView, Objective, Strategy, TargetFile};
use rayon::prelude::*;

use crate::lease::Interrupted;
use crate::search_target::SearchTarget;
use crate::spread_picture::darkest_and_brightest;
use crate::view_comparison::ViewComparison;

/// Interval between reports. Shorter generations are reported together.
const REPORT_INTERVAL: Duration = Duration::from_millis(250);
/// Interval between checkpoints. A worker that dies loses the work since its last one.
const SAVE_INTERVAL: Duration = Duration::from_secs(10);

/// Running search.
pub(crate) struct SearchRun {
    search: Search,
    target: Arc<SearchTarget>,
    budget: Budget,
    target_error: Option<f64>,
    /// True if the search has several islands.
    has_islands: bool,
    /// True if an island before this has reached the target error.
    is_told_to_end: bool,
    /// Search time in seconds, without pauses and the server's response times.
    seconds: f64,
    /// Present if the budget is a time.
    pace: Option<TimeBudget>,
    /// Validation error of the best material reported so far.
    recorded: f64,
    /// True if a generation has completed, in this lease or before.
    has_begun: bool,
    /// Time of the last checkpoint.
    saved: Instant,
}

/// Batch of generations.
pub(crate) struct StepBatch {
    /// Report, or `None` if there was no generation.
    pub(crate) update: Option<SearchUpdate>,
    /// True if the budget is used up or the target error is reached.
    pub(crate) is_over: bool,
}

impl SearchRun {
    /// Starts a search or resumes it from the checkpoint.
    pub(crate) fn new(grant: SearchGrant, target: Arc<SearchTarget>) -> Result<Self, Interrupted> {
        let strategy: Result<Strategy, _> = grant.strategy.parse();
        let strategy = strategy.map_err(|_| Interrupted::unknown("strategy", &grant.strategy))?;
        let objective = Objective::from_name(&grant.objective)
            .ok_or_else(|| Interrupted::unknown("objective", &grant.objective))?;
        let start = grant.start.iter().map(|bytes| Genome::from_canonical_bytes(bytes));
        let start = start.collect::<Result<Vec<_>, _>>();
        let start = start.map_err(|error| Interrupted::Failed(error.to_string()))?;
        let (seed, is_mirrored) = (island_seed(grant.seed, grant.island), grant.is_mirrored);
        let options = Options { strategy, seed, is_mirrored, start, objective };
        let search = match &grant.checkpoint {
            None => Search::new(&target.file.target.fitted, &options),
            Some(state) => match Search::resume(&target.file.target.fitted, &options, state) {
                Ok(search) => search,
                Err(error @ SearchError::Later) => {
                    return Err(Interrupted::OtherVersion(error.to_string()));
                }
                Err(error) => return Err(Interrupted::Failed(error.to_string())),
            },
        };
        let mut run = Self {
            search: search.reporting(&target.file.target.held),
            target,
            has_islands: grant.islands > 1,
            is_told_to_end: false,
            budget: grant.budget,
            target_error: grant.target_error,
            seconds: grant.seconds,
            pace: match grant.budget {
                Budget::Seconds(seconds) => Some(TimeBudget::new(seconds)),
                Budget::Generations(_) | Budget::Evaluations(_) => None,
            },
            recorded: grant.recorded.unwrap_or(f64::INFINITY),
            has_begun: grant.checkpoint.is_some(),
            saved: Instant::now(),
        };
        if let Some(arrival) = &grant.arrival {
            run.take(arrival).map_err(Interrupted::Failed)?;
        }
        Ok(run)
    }

    /// Adds the programs of the previous island, or notes its end.
    pub(crate) fn take(&mut self, arrival: &Arrival) -> Result<(), String> {
        match arrival {
            Arrival::Migrants(genomes) => {
                let genomes = genomes.iter().map(|bytes| Genome::from_canonical_bytes(bytes));
                let genomes = genomes.collect::<Result<Vec<_>, _>>().map_err(|e| e.to_string())?;
                self.search.immigrate(&genomes);
            }
            Arrival::Ended { is_reached } => self.is_told_to_end |= is_reached,
        }
        Ok(())
    }

    /// Runs generations until the budget is used up, programs migrate, a notably better material is
    /// found, the report interval has passed, or `stop` is set.
    pub(crate) fn step_batch(&mut self, stop: &AtomicBool) -> Result<StepBatch, String> {
        let started = Instant::now();
        let (mut lines, mut best, mut emigrants) = (Vec::new(), None, None);
        let mut is_over = self.has_begun && self.is_over(&self.search.progress());
        while !is_over && !stop.load(Ordering::Relaxed) {
            let (step, times) = (Instant::now(), self.search.next_step_cost());
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
            if self.has_islands && !is_over && progress.generation.is_multiple_of(MIGRATION) {
                let genomes = self.search.emigrants();
                emigrants = Some(genomes.iter().map(Genome::canonical_bytes).collect());
            }
            if progress.held < NOTABLE_RATIO * self.recorded {
                self.recorded = progress.held;
                best = match self.search.best() {
                    Some(candidate) => Some(measure(&self.target.file, &candidate)?),
                    None => None,
                };
                break;
            }
            if emigrants.is_some() || started.elapsed() >= REPORT_INTERVAL {
                break;
            }
        }
        if lines.is_empty() {
            return Ok(StepBatch { update: None, is_over });
        }
        let saves = is_over
            || best.is_some()
            || emigrants.is_some()
            || self.saved.elapsed() >= SAVE_INTERVAL;
        let checkpoint = saves.then(|| self.checkpoint());
        Ok(StepBatch {
            update: Some(SearchUpdate::Generations { lines, checkpoint, best, emigrants }),
            is_over,
        })
    }

    /// Returns a checkpoint after the last generation; `None` before the first. Also `None` if an
    /// earlier island has reached the target error: the next lease begins at the last stored
    /// checkpoint and gets the end of that island again.
    pub(crate) fn save(&mut self) -> Option<SearchUpdate> {
        (self.has_begun && !self.is_told_to_end).then(|| SearchUpdate::Generations {
            lines: Vec::new(),
            checkpoint: Some(self.checkpoint()),
            best: None,
            emigrants: None,
        })
    }

    fn checkpoint(&mut self) -> Vec<u8> {
        self.saved = Instant::now();
        self.search.checkpoint()
    }

    /// Returns the front, the best material first.
    pub(crate) fn finish(&self, stop: &AtomicBool) -> Result<SearchUpdate, String> {
        let (started, mut pace) = (Instant::now(), self.pace);
        // Stop early if the result is no longer needed.
        let outcome = self.search.finish_while(|| {
            let spent = self.seconds + started.elapsed().as_secs_f64();
            let is_in_time = pace.as_mut().is_none_or(|pace| pace.has_time(spent));
            is_in_time && !stop.load(Ordering::Relaxed)
        });
        let outcome = outcome.ok_or("the search found nothing")?;
        let file = &self.target.file;
        let mut front = Found::all(&outcome.front, &file.target).map_err(|e| e.to_string())?;
        let best = Found::best(&front, &outcome);
        front[..=best].rotate_right(1);
        let front = front.par_iter().map(|found| measured(file, found)).collect();
        let seconds = self.seconds + started.elapsed().as_secs_f64();
        let is_reached = self.is_reached(&self.search.progress());
        Ok(SearchUpdate::Finished { front, seconds, is_reached })
    }

    /// Returns the spread of the materials that match the pictures of the target; `None` for other
    /// targets, and for strategies without probabilities.
    pub(crate) fn spread(&self) -> Result<Option<SearchUpdate>, String> {
        let TargetFile { target, pictures: Some(pictures), .. } = &self.target.file else {
            return Ok(None);
        };
        let Some(spread) = Spread::of(&self.search) else { return Ok(None) };
        let view = pictures.views.iter().find(|view| !view.setting.is_held_out);
        let view = view.expect("a target has a picture that is fitted");
        let measured = || -> Result<(MaterialSpread, [Developed; 2]), EvalError> {
            let SpreadMap { seen, deviation } = spread.map(&target.fitted)?;
            let next = spread.next_pictures(view)?;
            let pictures = darkest_and_brightest(&spread, view, &next)?;
            let next = NextPicture::worth_taking(&next).map(|next| NextScene {
                scene: next.scene.clone(),
                light_deg: next.light_deg,
                e_log: next.e_log[1],
            });
            let cells = u32::try_from(SpreadMap::CELLS).expect("the map is small");
            let e_log = spread.e_log()?;
            let measured = MaterialSpread { e_log, cells, seen, deviation, next, pictures: true };
            Ok((measured, pictures))
        };
        let (measured, pictures) = measured().map_err(|error| error.to_string())?;
        let spread = serde_json::to_string(&measured).expect("a spread is plain data");
        let [darkest, brightest] =
            pictures.map(|picture| encode_png(picture.width, picture.height, &picture.rgba));
        Ok(Some(SearchUpdate::Spread(ReportedSpread { spread, darkest, brightest })))
    }

    fn is_over(&self, progress: &Progress) -> bool {
        let is_used_up = match self.budget {
            Budget::Seconds(_) => {
                self.pace.is_some_and(|pace| pace.is_over(self.seconds, &self.search))
            }
            Budget::Generations(generations) => progress.generation >= generations,
            Budget::Evaluations(evaluations) => progress.evaluations >= evaluations,
        };
        is_used_up || self.is_reached(progress)
    }

    /// True if this island, or one before it, has reached the target error.
    fn is_reached(&self, progress: &Progress) -> bool {
        self.is_told_to_end || self.target_error.is_some_and(|error| progress.held <= error)
    }
}

fn measure(file: &TargetFile, candidate: &Candidate) -> Result<MeasuredMaterial, String> {
    let found = Found::of(candidate, &file.target).map_err(|error| error.to_string())?;
    Ok(measured(file, &found))
}

/// Compares a material that was found with the pictures of the target.
fn measured(file: &TargetFile, found: &Found) -> MeasuredMaterial {
    let views = file.pictures.as_ref();
    let views = views.map(|pictures| compare_views(&pictures.views, &found.genome));
    let count = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
    MeasuredMaterial {
        genome: found.genome.canonical_bytes(),
        operations: count(found.operations),
        numbers: count(found.parameters),
        e_log: found.e_log,
        e_log_fitted: found.fitted,
        e_cbrt: found.e_cbrt,
        relative_l2: found.relative_l2,
        divisor: found.divisor,
        views,
    }
}

/// Compares a material under the energy limit with each image of the target.
fn compare_views(views: &[KnownView], genome: &Genome) -> Vec<FoundView> {
    let program = express(genome);
    let material = Specimen::Bred(genome, &program);
    let one = |known: &KnownView| {
        let ViewComparison { error, flip, .. } = ViewComparison::of(known, &material);
        let held_out = known.setting.is_held_out;
        FoundView { rmse: error.rmse, flip, gain: error.gain, held_out }
    };
    views.iter().map(one).collect()
}
