//! Dead components, value numbering and folding: the same genomes with each lowering pass left out.

use anyhow::{Context, Result};
use brood_eval::{CanonicalEvaluator, Evaluator};
use brood_program::Program;

use super::unlowered::Unlowered;
use super::{Saving, Workload};
use crate::measure::{fastest_of_each_ms, genomes};

/// Number of samples of a fitness evaluation.
const SAMPLES: usize = 4096;

/// Measures lowering as a whole, and each of its passes against the passes before it.
pub fn measure(workload: &Workload) -> Result<Vec<Saving>> {
    let set = brood_eval::conformance::hard_samples(workload.seed, SAMPLES);
    // As written, then after each pass: number of operations, and programs.
    let mut forms: [(u64, Vec<Program>); 4] = Default::default();
    for genome in genomes(workload.seed, workload.genomes) {
        let lowered = Program::lower(&genome);
        let written = Unlowered::as_written(&genome);
        let live = written.live();
        let numbered = live.numbered();
        for (form, code) in forms.iter_mut().zip([&written, &live, &numbered]) {
            form.0 += code.operations() as u64;
            form.1.push(code.program(&lowered).context("pack the code of a genome")?);
        }
        forms[3].0 += lowered.operations() as u64;
        forms[3].1.push(lowered);
    }
    let evaluator = CanonicalEvaluator::default();
    let evaluate = |programs: &[Program]| {
        let mut f = Vec::new();
        programs.iter().try_for_each(|program| Ok(evaluator.eval(&[program], &set, &mut f)?))
    };
    let [written, live, numbered, lowered] = &forms;
    // Computes the inputs before the clock starts.
    evaluate(&written.1)?;
    let times = fastest_of_each_ms(
        workload.repeats,
        [
            &mut || evaluate(&written.1),
            &mut || evaluate(&live.1),
            &mut || evaluate(&numbered.1),
            &mut || evaluate(&lowered.1),
        ],
    )?;
    let saving = |name: &str, from: usize, to: usize| Saving {
        name: name.to_owned(),
        counted: "scalar operations of all genomes",
        without: forms[from].0,
        with: forms[to].0,
        timed: "evaluation of all genomes on 4096 samples",
        without_ms: times[from],
        with_ms: times[to],
        percent_same: 100.0,
    };
    Ok(vec![
        saving("all of lowering", 0, 3),
        saving("dead components", 0, 1),
        saving("value numbering", 1, 2),
        saving("folding", 2, 3),
    ])
}
