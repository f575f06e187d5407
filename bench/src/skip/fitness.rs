//! Candidates that can no longer win: selection with exact abort and with racing, against
//! evaluating everything.

use anyhow::{Result, ensure};
use brood_eval::{CanonicalEvaluator, Screening, Selected, select_best};
use brood_program::Program;

use super::{Saving, Workload};
use crate::measure::{fastest_of_each_ms, programs};
use crate::target;

/// Number of samples of the target.
const SAMPLES: usize = 4096;
/// Number of candidates per genome of the workload.
const CANDIDATES: u32 = 10;
/// Number of selected candidates.
const SELECTED: usize = 20;
/// Share of the candidates that a race passes on.
const SHARE: f64 = 0.05;

/// Measures exact abort and racing.
pub fn measure(workload: &Workload) -> Result<Vec<Saving>> {
    let population = programs(workload.seed, CANDIDATES * workload.genomes);
    let population: Vec<&Program> = population.iter().collect();
    // Another seed, so that the target is not in the population.
    let reference = programs(workload.seed.wrapping_add(1), 1).remove(0);
    let target = target::of(&reference, SAMPLES, workload.seed)?;
    let evaluator = CanonicalEvaluator::default();
    let select = |screening| -> Result<Selected> {
        Ok(select_best(&evaluator, &population, &target, SELECTED, screening)?)
    };
    let all = select(Screening::None)?;
    let exact = select(Screening::Exact)?;
    ensure!(exact.best == all.best, "exact screening changed a selection");
    let race = select(Screening::Race { share: SHARE })?;
    let timed = |screening| select(screening).map(|_| ());
    let [all_ms, exact_ms, race_ms] = fastest_of_each_ms(
        workload.repeats,
        [&mut || timed(Screening::None), &mut || timed(Screening::Exact), &mut || {
            timed(Screening::Race { share: SHARE })
        }],
    )?;
    let saving = |name: &str, selected: &Selected, with_ms| Saving {
        name: name.to_owned(),
        counted: "blocks of 256 samples, of all candidates",
        without: selected.blocks,
        with: selected.blocks_evaluated,
        timed: "selection of the best 20, translation included",
        without_ms: all_ms,
        with_ms,
        percent_same: {
            let same = all.best.iter().filter(|one| selected.best.contains(one)).count();
            100.0 * same as f64 / all.best.len() as f64
        },
    };
    Ok(vec![
        saving("fitness, exact abort", &exact, exact_ms),
        saving("fitness, race", &race, race_ms),
    ])
}
