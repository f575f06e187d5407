//! Tuning of a genome's constants by their derivatives: Levenberg-Marquardt steps on the sum over
//! all training samples.

use brood_eval::{CanonicalEvaluator, Direction, FitnessEvaluator, normal_equations};
use brood_genome::Genome;
use brood_program::Tunable;

use super::cases::Cases;
use super::evaluate::{Member, rescaled, sum_of};
use crate::levenberg_marquardt::{NormalEquations, Problem, Rules, Solution};

const RULES: Rules = Rules {
    diagonal_floor: 1e-6,
    decrease: 0.2,
    increase: 5.0,
    // Off: members get so few steps that damping stays small.
    max_damping: f64::INFINITY,
    enough: f64::NEG_INFINITY,
    converged: (1, 1e-4),
    stops_when_singular: true,
};
/// Largest change of a constant in one step.
const LONGEST_STEP: f64 = 2.0;
/// Genomes with more constants are not tuned: solving a system of that size costs more than it
/// gains.
const MAX_CONSTANTS: usize = 256;

/// Returns the member with tuned constants, scale and offset, or as it is if no change reduces its
/// sum; and the number of evaluations.
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
    let tunable = Tunable::lower(genome);
    let free: Vec<usize> =
        (0..tunable.places().len()).filter(|index| tunable.places()[*index].is_some()).collect();
    if free.is_empty() || free.len() > MAX_CONSTANTS {
        return (genome.clone(), 0);
    }
    let direction = Direction::faster(tunable.places().len());
    let mut solution = Solution::new(tunable);
    let tried = solution.minimise(&mut Tuning { cases, free, direction }, &RULES, steps);
    (solution.point.write(genome), tried)
}

/// The sum of squared differences as a function of the constants of a program.
struct Tuning<'a> {
    cases: &'a Cases,
    /// Constants that can be written back to the genome.
    free: Vec<usize>,
    direction: Direction,
}

impl Problem for Tuning<'_> {
    type Point = Tunable;

    fn error(&mut self, tunable: &Tunable) -> f64 {
        let sums = CanonicalEvaluator::default().sums(&[tunable.program()], &self.cases.target);
        sums.expect("the canonical evaluator runs every program")[0]
    }

    fn normal_equations(&mut self, at: &mut Solution<Tunable>) -> NormalEquations {
        let all = normal_equations(at.point.program(), &self.cases.target, self.direction);
        at.error = all.sum;
        NormalEquations { matrix: all.matrix, gradient: all.gradient }.of(&self.free)
    }

    fn longest_step(&self, _: usize) -> f64 {
        LONGEST_STEP
    }

    fn moved(&self, tunable: &Tunable, change: &[f64]) -> Option<Tunable> {
        let mut next = tunable.clone();
        for (index, change) in self.free.iter().zip(change) {
            let value = tunable.program().constants()[*index].reference;
            next.set(*index, value - change);
        }
        Some(next)
    }
}
