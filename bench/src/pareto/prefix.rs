//! Sweep of the samples that rank candidates: how well a prefix of a target's shuffled samples
//! predicts the order on all of them.

use anyhow::Result;
use brood_eval::{CanonicalEvaluator, FitnessEvaluator, FitnessTarget};
use brood_program::Program;
use rayon::prelude::*;

use crate::chart::{Axis, Cell, Plot, Point, ResultTable, Series, cells};
use crate::measure::{fastest_ms, median, one_thread, programs, quantile};
use crate::output;
use crate::record::Finding;
use crate::target;

/// Number of candidates that a selection keeps.
const TOP: usize = 20;
/// Share of the population that a prefix passes on.
const PASSED: f64 = 0.05;
/// Samples of a block, the unit in which sums advance.
const BLOCK: usize = 256;

/// Amount of work of the sweep.
struct Workload {
    population: u32,
    samples: usize,
    targets: u32,
    /// Number of programs that are timed.
    timed: usize,
    repeats: u32,
}

/// Results of one prefix length for all targets.
struct PrefixResult {
    samples: usize,
    /// Microseconds per genome on one thread.
    us: f64,
    /// Share of the true best candidates that the prefix passes on, for each target.
    kept: Vec<f64>,
    /// Kendall's tau between the order on the prefix and on all samples, for each target.
    tau: Vec<f64>,
}

/// Measures the finding.
pub fn measure(short: bool, seed: u64) -> Result<Finding> {
    let workload = if short {
        Workload { population: 200, samples: 512, targets: 1, timed: 20, repeats: 1 }
    } else {
        Workload { population: 2000, samples: 4096, targets: 2, timed: 200, repeats: 3 }
    };
    let population = programs(seed, workload.population);
    // Another seed, so that no target is in the population.
    let targets = programs(seed.wrapping_add(1), workload.targets);
    let targets: Result<Vec<FitnessTarget>> =
        targets.iter().map(|program| target::shuffled(program, workload.samples, seed)).collect();
    let targets = targets?;
    let lengths: Vec<usize> =
        (0..).map(|k| BLOCK << k).take_while(|length| *length <= workload.samples).collect();
    let population: Vec<&Program> = population.iter().collect();
    let pool = one_thread()?;
    let empty = |samples: &usize| PrefixResult {
        samples: *samples,
        us: f64::INFINITY,
        kept: Vec::new(),
        tau: Vec::new(),
    };
    let mut results: Vec<PrefixResult> = lengths.iter().map(empty).collect();
    // Interleaved, so that a slow phase of the machine affects all lengths.
    for _ in 0..workload.repeats {
        for result in &mut results {
            let timed = &population[..workload.timed];
            let us = pool.install(|| time_us(timed, &targets[0], result.samples))?;
            result.us = result.us.min(us);
        }
    }
    let bar = output::bar(workload.targets.into(), "prefix");
    for target in &targets {
        let sums = prefix_sums(&population, target, &lengths)?;
        let full = &sums[lengths.len() - 1];
        for (by_prefix, result) in sums.iter().zip(&mut results) {
            result.kept.push(kept_share(by_prefix, full));
            result.tau.push(tau(by_prefix, full));
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(Finding {
        name: "prefix",
        note: format!(
            "{} random genomes against {} random targets on {} shuffled direction pairs, logarithmic loss; the best \
             {:.0} % by the prefix are kept, and the share of the true best {TOP} among them is listed; tau compares the whole order; \
             time of translation and fitness of one genome on one thread; racing, if requested, uses the \
             first tenth of the samples",
            workload.population,
            workload.targets,
            workload.samples,
            100.0 * PASSED,
        ),
        table: table(&results, workload.samples),
        raw: None,
        chart: chart(&results, &workload).into(),
    })
}

/// Sums of all programs, for each prefix.
fn prefix_sums(
    programs: &[&Program],
    target: &FitnessTarget,
    lengths: &[usize],
) -> Result<Vec<Vec<f64>>> {
    let evaluator = CanonicalEvaluator::default();
    let mut population = evaluator.population(programs, target);
    let all: Vec<usize> = (0..programs.len()).collect();
    let mut done = 0;
    let mut sums = Vec::with_capacity(lengths.len());
    for length in lengths {
        population.extend(&all, done..length / BLOCK, f64::INFINITY)?;
        done = length / BLOCK;
        sums.push(population.fitness().iter().map(|fitness| fitness.sum).collect());
    }
    Ok(sums)
}

/// Time of translation and sums over a prefix, in microseconds per genome.
fn time_us(programs: &[&Program], target: &FitnessTarget, samples: usize) -> Result<f64> {
    let evaluator = CanonicalEvaluator::default();
    let all: Vec<usize> = (0..programs.len()).collect();
    let (ms, ()) = fastest_ms(2, || {
        let mut population = evaluator.population(programs, target);
        Ok(population.extend(&all, 0..samples / BLOCK, f64::INFINITY)?)
    })?;
    Ok(1e3 * ms / programs.len() as f64)
}

/// Share of the true best that are among the candidates passed on by the prefix.
fn kept_share(by_prefix: &[f64], full: &[f64]) -> f64 {
    let best = |errors: &[f64], count: usize| {
        let mut order: Vec<usize> = (0..errors.len()).collect();
        order.sort_by(|a, b| errors[*a].total_cmp(&errors[*b]).then(a.cmp(b)));
        order.truncate(count);
        order
    };
    let top = TOP.min(full.len());
    let passed = best(by_prefix, (PASSED * full.len() as f64) as usize);
    let found = best(full, top).iter().filter(|index| passed.contains(index)).count();
    found as f64 / top as f64
}

/// Kendall's tau-b: 1 for the same order, 0 for none in common; ties count as neither.
fn tau(a: &[f64], b: &[f64]) -> f64 {
    let order = |x: f64, y: f64| f64::from(i8::from(x > y) - i8::from(x < y));
    let of = |i: usize| {
        let (mut both, mut in_a, mut in_b) = (0.0, 0.0, 0.0);
        for j in 0..i {
            let (x, y) = (order(a[i], a[j]), order(b[i], b[j]));
            both += x * y;
            in_a += x * x;
            in_b += y * y;
        }
        [both, in_a, in_b]
    };
    let add = |x: [f64; 3], y: [f64; 3]| [x[0] + y[0], x[1] + y[1], x[2] + y[2]];
    // Integers below 2^53: the sum is exact in any order.
    let [both, in_a, in_b] = (0..a.len()).into_par_iter().map(of).reduce(|| [0.0; 3], add);
    both / (in_a * in_b).sqrt()
}

fn table(results: &[PrefixResult], all: usize) -> ResultTable {
    let mut table = ResultTable::default();
    for result in results {
        let kept = median(&result.kept);
        table.push(cells! {
            knob: "fitness prefix",
            value: result.samples,
            time_ms: result.us * 1e-3,
            error: 1.0 - median(&result.tau),
            error_metric: "1 - Kendall tau, median target",
            kept: kept,
            kept_worst: quantile(&result.kept, 0.0),
            kendall_tau: median(&result.tau),
            default: Cell::yes_if(result.samples == all),
        });
    }
    table
}

fn chart(results: &[PrefixResult], workload: &Workload) -> Plot {
    let series = |name: &str, share: f64| {
        let point = |result: &PrefixResult| Point {
            x: result.us,
            y: 50.0 * (1.0 - quantile(&result.tau, share)),
            label: result.samples.to_string(),
            is_default: result.samples == workload.samples,
            ..Point::default()
        };
        Series::dotted(name, results.iter().map(point))
    };
    Plot {
        title: "Number of samples that rank candidates".to_owned(),
        subtitle: format!(
            "{} random genomes, {} random targets",
            workload.population, workload.targets
        ),
        x: Axis::log("time of one genome on one thread, us"),
        y: Axis::linear("pairs of genomes ordered differently than on all samples, %"),
        series: Series::label_first([series("median target", 0.5), series("worst target", 0.0)]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tau_is_1_for_the_same_order_and_minus_1_for_the_reverse() {
        let up: Vec<f64> = (0..50).map(f64::from).collect();
        let down: Vec<f64> = up.iter().map(|x| -x).collect();
        assert_eq!((tau(&up, &up), tau(&up, &down)), (1.0, -1.0));
        // One pair of six in the wrong order.
        let swapped = tau(&[1.0, 2.0, 3.0, 4.0], &[1.0, 2.0, 4.0, 3.0]);
        assert!((swapped - 4.0 / 6.0).abs() < 1e-15, "{swapped}");
    }

    #[test]
    fn kept_share_counts_the_true_best_among_those_passed_on() {
        let full: Vec<f64> = (0..400).map(f64::from).collect();
        assert_eq!(kept_share(&full, &full), 1.0);
        let reversed: Vec<f64> = full.iter().map(|x| -x).collect();
        assert_eq!(kept_share(&reversed, &full), 0.0);
    }
}
