//! Evaluation of children: solves for scale and offset, sums errors over samples and lower bounds
//! under the energy limit, and rejects genomes that exceed the bound between samples.

use brood_eval::{CanonicalEvaluator, Evaluator, FitnessEvaluator, Screening, select_best};
use brood_genome::{Genome, Output, RANGE};
use brood_program::{Program, ProgramHash};
use rayon::prelude::*;

use super::cases::{Cases, TargetSamples};
use super::scale::{Observed, scale_and_offset};

/// One in this many of the few samples is used to solve for scale and offset.
const SCALED: usize = 2;

/// An evaluated genome.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Member {
    pub(super) genome: Genome,
    /// Hash of the program without scale and offset, which identifies duplicates.
    pub(super) hash: ProgramHash,
    /// Number of scalar operations per sample.
    pub(super) operations: u32,
    /// Sum over training samples and channels of the squared differences of log2(1 + f cos_i). The
    /// energy limit applies to f. Lower bounds count where f is below them.
    pub(super) sum: f64,
    /// True if tuning of its constants has been tried.
    pub(super) is_tuned: bool,
}

/// A genome with the program, and its hash, of what it computes with scale 1 and offset 0. Genomes
/// of equal hash differ only in scale and offset, which are solved for.
pub(super) struct BareGenome {
    genome: Genome,
    pub(super) hash: ProgramHash,
    program: Program,
}

impl BareGenome {
    /// Computes the bare programs of these genomes.
    ///
    /// # Shapes
    /// One for each genome, in their order.
    pub(super) fn of(genomes: Vec<Genome>) -> Vec<Self> {
        let bare = |genome: Genome| {
            let output = *genome.output();
            let unscaled =
                Output::new(*output.matrix(), [1.0; 3], [0.0; 3]).expect("the matrix is valid");
            let program = Program::lower(&genome.clone().with_output(unscaled));
            Self { hash: program.hash(), genome, program }
        };
        genomes.into_par_iter().map(bare).collect()
    }
}

/// Returns the best of these genomes, at most `count`, with scale and offset solved for. Leaves out
/// those whose sum without the energy limit is not below `worst`, and those that exceed the bound
/// where samples are few.
pub(super) fn evaluate(
    bare: Vec<BareGenome>,
    cases: &Cases,
    (count, worst): (usize, f64),
) -> Vec<Member> {
    let scaled = scaled(bare, cases);
    let programs: Vec<&Program> = scaled.iter().map(|(_, program)| program).collect();
    let (best, sums): (Vec<usize>, Vec<f64>) =
        selected(&programs, cases, (count, worst)).into_iter().unzip();
    let of_best: Vec<&Program> = best.iter().map(|at| programs[*at]).collect();
    let sums = limited_sums(&of_best, &sums, cases);
    let member = |(at, sum): (&usize, f64)| {
        let (bare, program) = &scaled[*at];
        sum.is_finite().then(|| Member {
            genome: bare.genome.clone(),
            hash: bare.hash,
            operations: operations(program),
            sum,
            is_tuned: false,
        })
    };
    best.iter().zip(sums).filter_map(member).collect()
}

/// The best programs without the energy limit, at most `count`, with their sums over the samples.
/// Leaves out those whose sum over samples and lower bounds is not below `worst`.
fn selected(
    programs: &[&Program],
    cases: &Cases,
    (count, worst): (usize, f64),
) -> Vec<(usize, f64)> {
    // With lower bounds, the best by samples alone may not be the best.
    let first = if cases.bounds.is_some() { programs.len() } else { count };
    let evaluator = CanonicalEvaluator::default();
    let selected = select_best(&evaluator, programs, &cases.target, first, Screening::Exact);
    let ranked = selected.expect("the canonical evaluator runs every program").best;
    let of_ranked: Vec<&Program> = ranked.iter().map(|one| programs[one.program]).collect();
    let whole = beyond(&of_ranked, cases).into_iter().zip(&ranked).map(|(by, one)| one.sum + by);
    let mut best: Vec<(f64, (usize, f64))> =
        whole.zip(ranked.iter().map(|one| (one.program, one.sum))).collect();
    best.retain(|(sum, _)| *sum < worst);
    best.sort_by(|a, b| a.0.total_cmp(&b.0));
    best.truncate(count);
    best.into_iter().map(|(_, one)| one).collect()
}

/// Sums of programs under the energy limit, from their sums without it; infinite for those that
/// exceed the bound where samples are few.
fn limited_sums(programs: &[&Program], sums: &[f64], cases: &Cases) -> Vec<f64> {
    let limited = cases.limited(programs);
    let all: Vec<&Program> = limited.iter().map(|(program, _)| program).collect();
    let divided: Vec<&Program> =
        limited.iter().filter(|(_, divisor)| *divisor > 1.0).map(|(program, _)| program).collect();
    let mut of_divided = sums_of(&divided, cases).into_iter();
    let beyond = beyond(&all, cases);
    let mut sum = |(at, is_bounded): (usize, bool)| {
        let sum = if limited[at].1 > 1.0 { of_divided.next() } else { Some(sums[at]) };
        let sum = sum.expect("every divided program has a sum");
        if is_bounded { sum + beyond[at] } else { f64::INFINITY }
    };
    bounded(&all, cases).into_iter().enumerate().map(&mut sum).collect()
}

/// Sums over the lower bounds.
fn beyond(programs: &[&Program], cases: &Cases) -> Vec<f64> {
    let Some(bounds) = &cases.bounds else { return vec![0.0; programs.len()] };
    let mut out = Vec::new();
    CanonicalEvaluator::default()
        .eval(programs, &bounds.set, &mut out)
        .expect("the canonical evaluator runs every program");
    out.chunks(3 * bounds.set.len()).map(|values| bounds.sum(values)).collect()
}

/// Sums of programs as they are, over the samples alone.
fn sums_of(programs: &[&Program], cases: &Cases) -> Vec<f64> {
    let sums = CanonicalEvaluator::default().sums(programs, &cases.target);
    sums.expect("the canonical evaluator runs every program")
}

/// Sum of one genome as it is, under the energy limit; infinite if it exceeds the bound where
/// samples are few.
pub(super) fn sum_of(genome: &Genome, cases: &Cases) -> f64 {
    let program = Program::lower(genome);
    limited_sums(&[&program], &sums_of(&[&program], cases), cases)[0]
}

/// Returns the genome with scale and offset solved for.
pub(super) fn rescaled(genome: Genome, cases: &Cases) -> Genome {
    let bare = BareGenome::of(vec![genome]);
    let mut scaled = scaled(bare, cases);
    scaled.swap_remove(0).0.genome
}

pub(super) fn operations(program: &Program) -> u32 {
    u32::try_from(program.operations()).expect("programs have fewer than 2^32 operations")
}

/// Genomes and their programs, with scale and offset solved for.
fn scaled(bare: Vec<BareGenome>, cases: &Cases) -> Vec<(BareGenome, Program)> {
    let programs: Vec<&Program> = bare.iter().map(|bare| &bare.program).collect();
    let (few, bounds) = (&cases.few, cases.bounds.as_ref().map(|bounds| &bounds.few));
    let of_few = values(&programs, few);
    let of_bounds = bounds.map_or_else(Vec::new, |bounds| values(&programs, bounds));
    // Rows of few samples, then of lower bounds.
    let sampled = |row: fn(&TargetSamples, usize) -> f64| {
        let samples = (0..few.len()).step_by(SCALED).map(move |at| row(few, at));
        let bounds =
            bounds.into_iter().flat_map(move |of| (0..of.len()).map(move |at| row(of, at)));
        samples.chain(bounds).collect::<Vec<f64>>()
    };
    let weight = sampled(|of, at| of.weight[at]);
    let count = few.len().div_ceil(SCALED);
    let observed: Vec<Observed> = [
        sampled(|of, at| of.weighted[at][0]),
        sampled(|of, at| of.weighted[at][1]),
        sampled(|of, at| of.weighted[at][2]),
    ]
    .into_iter()
    .enumerate()
    .map(|(channel, y)| {
        let known = cases.bounds.iter().flat_map(|bounds| &bounds.few_known);
        let is_bound = known.map(|known| !known[channel]);
        let is_bound = std::iter::repeat_n(false, count).chain(is_bound).collect();
        Observed::new(weight.clone(), y, is_bound)
    })
    .collect();
    let scale = |(index, mut bare): (usize, BareGenome)| {
        let output = *bare.genome.output();
        let (mut scale, mut offset) = (*output.scale(), *output.offset());
        for channel in 0..3 {
            let row = 3 * index + channel;
            let own = of_few[row * few.len()..][..few.len()].iter().step_by(SCALED);
            let number = bounds.map_or(0, TargetSamples::len);
            let own = own.chain(&of_bounds[row * number..][..number]);
            let weighted: Vec<f64> =
                own.zip(&weight).map(|(f, weight)| f64::from(*f) * weight).collect();
            let start = [f64::from(scale[channel]), f64::from(offset[channel])];
            let found = scale_and_offset(&weighted, &observed[channel], start);
            [scale[channel], offset[channel]] = found.map(narrow);
        }
        let output =
            Output::new(*output.matrix(), scale, offset).expect("scale and offset are in range");
        bare.genome = bare.genome.with_output(output);
        let program = Program::lower(&bare.genome);
        (bare, program)
    };
    bare.into_par_iter().enumerate().map(scale).collect()
}

#[expect(clippy::cast_possible_truncation, reason = "rounded to the nearest f32")]
fn narrow(value: f64) -> f32 {
    value.min(f64::from(RANGE)) as f32
}

/// f of the programs, [program][channel][sample].
pub(super) fn values(programs: &[&Program], samples: &TargetSamples) -> Vec<f32> {
    let mut out = Vec::new();
    CanonicalEvaluator::default()
        .eval(programs, &samples.set, &mut out)
        .expect("the canonical evaluator runs every program");
    out
}

/// True for each program that stays below the ceiling where samples are few.
fn bounded(programs: &[&Program], cases: &Cases) -> Vec<bool> {
    let mut out = Vec::new();
    CanonicalEvaluator::default()
        .eval(programs, &cases.narrow, &mut out)
        .expect("the canonical evaluator runs every program");
    let values = out.chunks(3 * cases.narrow.len());
    values.map(|values| values.iter().all(|f| f64::from(*f) <= cases.ceiling)).collect()
}
