//! Selection of parents, and their children.

use brood_genome::{BirthKey, Dialect, Genome, MutationScale, Operator, Stream, Variation};
use brood_program::Program;
use rayon::prelude::*;

use super::cases::Cases;
use super::evaluate::{Member, values};
use super::population::Population;

/// Number of samples per case of lexicase selection: a case is a group of samples, with the sum of
/// their squared errors.
const GROUP: usize = 8;
/// Mutation amounts; each child gets one of them at random.
const AMOUNTS: [f32; 4] = [0.02, 0.06, 0.15, 0.35];

/// Draws the children of one island in one generation.
pub(super) struct Breeder<'a> {
    /// Members of the island, the least sum first.
    pub(super) members: &'a [Member],
    /// Errors, [member][case], and the tolerance of each case.
    cases: (Vec<Vec<f64>>, Vec<f64>),
    population: &'a Population,
}

impl<'a> Breeder<'a> {
    pub(super) fn new(members: &'a [Member], cases: &Cases, population: &'a Population) -> Self {
        let errors = errors(members, cases);
        let tolerance = tolerances(&errors);
        Self { members, cases: (errors, tolerance), population }
    }

    /// Returns the child of that key.
    pub(super) fn child(&self, key: BirthKey) -> Genome {
        let mut stream = Stream::new(key, Operator::Genetic);
        let first = &self.members[self.parent(&mut stream)].genome;
        let second = &self.members[self.parent(&mut stream)].genome;
        child_of((first, second), self.population.crossed, key, &mut stream)
    }

    fn parent(&self, stream: &mut Stream) -> usize {
        if stream.chance(self.population.lexicase) {
            self.lexicase(stream)
        } else {
            tournament(self.members.len(), self.population, stream)
        }
    }

    /// Epsilon-lexicase selection: goes through the cases in random order and drops the members
    /// that are worse than the best by more than the case's tolerance.
    ///
    /// # Source
    /// La Cava, Spector and Danai, *Epsilon-Lexicase Selection for Regression* (2016), the static
    /// form.
    fn lexicase(&self, stream: &mut Stream) -> usize {
        let (errors, tolerances) = &self.cases;
        let mut left: Vec<usize> = (0..self.members.len()).collect();
        let mut order: Vec<usize> = (0..tolerances.len()).collect();
        while left.len() > 1 && !order.is_empty() {
            let case = order.swap_remove(stream.below(order.len() as u32) as usize);
            let least = left.iter().map(|at| errors[*at][case]).fold(f64::INFINITY, f64::min);
            left.retain(|at| errors[*at][case] <= least + tolerances[case]);
        }
        left[stream.below(left.len().max(1) as u32) as usize]
    }
}

/// Tournament selection among `count` members, the best first: the lowest index wins.
pub(crate) fn tournament(count: usize, population: &Population, stream: &mut Stream) -> usize {
    let count = u32::try_from(count).expect("populations are small");
    (0..population.tournament).map(|_| stream.below(count)).min().unwrap_or(0) as usize
}

/// Child of two parents: by crossover with probability `crossed`, otherwise a mutation of the
/// first.
pub(crate) fn child_of(
    (first, second): (&Genome, &Genome),
    crossed: f32,
    key: BirthKey,
    stream: &mut Stream,
) -> Genome {
    let amount = AMOUNTS[stream.below(AMOUNTS.len() as u32) as usize];
    let may_cross = first.dialect().is_compatible(second.dialect()) && first != second;
    if may_cross && stream.chance(crossed) {
        let share = 0.1 + 0.4 * stream.unit();
        // Half of the crossovers are without mutation.
        let amount = if stream.chance(0.5) { 0.0 } else { amount };
        let variation = Variation::crossover(first, second, share, amount);
        variation.with_scale(MutationScale::Search).birth(key)
    } else {
        Variation::mutate(first, amount).with_scale(MutationScale::Search).birth(key)
    }
}

/// Random genome of that dialect.
pub(crate) fn random(dialect: Dialect, key: BirthKey) -> Genome {
    Variation::random(dialect).birth(key)
}

/// Mutant of one of the start genomes, chosen at random.
pub(crate) fn start_mutant(start: &[Genome], key: BirthKey) -> Genome {
    let mut stream = Stream::new(key, Operator::Genetic);
    let first = &start[stream.below(start.len() as u32) as usize];
    let amount = AMOUNTS[stream.below(AMOUNTS.len() as u32) as usize];
    Variation::mutate(first, amount).with_scale(MutationScale::Search).birth(key)
}

/// Sums of squared differences of ln(1 + f cos_i) over each group of [`Cases::few`],
/// [member][case].
fn errors(members: &[Member], cases: &Cases) -> Vec<Vec<f64>> {
    let programs: Vec<Program> =
        members.par_iter().map(|member| Program::lower(&member.genome)).collect();
    let programs: Vec<&Program> = programs.iter().collect();
    let (few, values) = (&cases.few, values(&programs, &cases.few));
    let count = few.len();
    let of = |index: usize| {
        let mut sums = vec![0.0; count.div_ceil(GROUP)];
        for channel in 0..3 {
            let own = &values[(3 * index + channel) * count..][..count];
            for (sample, f) in own.iter().enumerate() {
                let found = libm::log1p(f64::from(*f) * few.weight[sample]);
                let off = found - few.log_weighted[sample][channel];
                sums[sample / GROUP] += off * off;
            }
        }
        sums
    };
    (0..members.len()).into_par_iter().map(of).collect()
}

/// Tolerance of each case: the median absolute deviation of the members' errors.
fn tolerances(errors: &[Vec<f64>]) -> Vec<f64> {
    let cases = errors.first().map_or(0, Vec::len);
    let median = |mut values: Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    let of = |case: usize| {
        let own: Vec<f64> = errors.iter().map(|errors| errors[case]).collect();
        let middle = median(own.clone());
        median(own.iter().map(|error| (error - middle).abs()).collect())
    };
    (0..cases).map(of).collect()
}
