//! Tuning of a genome's constants by their derivatives: Levenberg-Marquardt on the sum over all
//! samples.

use brood_eval::{
    CanonicalEvaluator, Direction, FitnessEvaluator, NormalEquations, normal_equations,
};
use brood_genome::Genome;
use brood_program::Tunable;

use super::cases::Cases;
use super::evaluate::{Member, rescaled, sum_of};
use crate::solve::solve;

const INITIAL_DAMPING: f64 = 1e-2;
const DAMPING_DECREASE: f64 = 0.2;
const DAMPING_INCREASE: f64 = 5.0;
/// Damping uses at least this share of the largest diagonal entry.
const DIAGONAL_FLOOR: f64 = 1e-6;
/// Largest change of a constant in one step.
const LONGEST_STEP: f64 = 2.0;
/// Genomes with more constants are not tuned: solving a system of that size costs more than it
/// gains.
const MAX_CONSTANTS: usize = 256;

/// Returns the member with constants, scale and offset that are at least as good, and the number of
/// evaluations.
pub(super) fn tuned(member: &Member, cases: &Cases, steps: usize) -> (Member, u64) {
    let (genome, evaluations) = descend(&member.genome, cases, steps);
    let mut best = Member { is_tuned: true, ..member.clone() };
    for genome in [rescaled(genome.clone(), cases), genome] {
        let sum = sum_of(&genome, cases);
        if sum < best.sum {
            best = Member { genome, sum, ..best };
        }
    }
    (best, evaluations + 2)
}

fn descend(genome: &Genome, cases: &Cases, steps: usize) -> (Genome, u64) {
    let mut tunable = Tunable::lower(genome);
    let free: Vec<usize> =
        (0..tunable.places().len()).filter(|index| tunable.places()[*index].is_some()).collect();
    if free.is_empty() || free.len() > MAX_CONSTANTS {
        return (genome.clone(), 0);
    }
    let direction = Direction::faster(tunable.places().len());
    let (mut damping, mut known, mut evaluations) = (INITIAL_DAMPING, None, 0);
    for _ in 0..steps {
        let normal: &NormalEquations = known
            .get_or_insert_with(|| normal_equations(tunable.program(), &cases.target, direction));
        evaluations += 1;
        let Some(next) = step(&tunable, normal, &free, damping) else { break };
        let sum = CanonicalEvaluator::default().sums(&[next.program()], &cases.target);
        let sum = sum.expect("the canonical evaluator runs every program")[0];
        if sum < normal.sum {
            let is_done = sum > 0.9999 * normal.sum;
            (tunable, known, damping) = (next, None, damping * DAMPING_DECREASE);
            if is_done {
                break;
            }
        } else {
            damping *= DAMPING_INCREASE;
        }
    }
    (tunable.write(genome), evaluations)
}

fn step(
    tunable: &Tunable,
    normal: &NormalEquations,
    free: &[usize],
    damping: f64,
) -> Option<Tunable> {
    let count = free.len();
    let mut matrix = vec![0.0; count * count];
    for (row, a) in free.iter().enumerate() {
        for (column, b) in free.iter().enumerate() {
            matrix[row * count + column] = normal.matrix[a * normal.constants + b];
        }
    }
    let largest = (0..count).map(|k| matrix[k * count + k]).fold(0.0, f64::max);
    for k in 0..count {
        let own = &mut matrix[k * count + k];
        *own += damping * own.max(DIAGONAL_FLOOR * largest);
    }
    let gradient: Vec<f64> = free.iter().map(|index| normal.gradient[*index]).collect();
    let change = solve(matrix, &gradient)?;
    let longest = change.iter().fold(0.0f64, |longest, value| longest.max(value.abs()));
    if !longest.is_finite() {
        return None;
    }
    let length = if longest > LONGEST_STEP { LONGEST_STEP / longest } else { 1.0 };
    let mut next = tunable.clone();
    for (index, change) in free.iter().zip(&change) {
        let value = tunable.program().constants()[*index].reference;
        next.set(*index, value - length * change);
    }
    Some(next)
}
