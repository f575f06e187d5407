//! Children judged: scaled, held against the samples, and refused where they stand out between these.

use brood_eval::{CanonicalEvaluator, Evaluator, FitnessEvaluator, Screening, select_best};
use brood_genome::{Genome, Output, RANGE};
use brood_program::{Program, ProgramHash};
use rayon::prelude::*;

use super::cases::{Cases, Wanted};
use super::scale::scale_and_offset;

/// Of the few samples, one in so many is used to solve for scale and offset.
const SCALED: usize = 2;

/// A genome that is held against the samples.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Member {
    pub(super) genome: Genome,
    /// Of the program without scale and offset, by which duplicates are known.
    pub(super) hash: ProgramHash,
    pub(super) operations: u32,
    /// Sum of squared differences over the samples that are fitted.
    pub(super) sum: f64,
    /// Whether its constants have been tuned.
    pub(super) is_tuned: bool,
}

/// A genome with the hash of what it computes but for scale and offset.
pub(super) struct Plain {
    genome: Genome,
    pub(super) hash: ProgramHash,
    program: Program,
}

impl Plain {
    /// # Shapes
    /// One for each genome, in their order.
    pub(super) fn of(genomes: Vec<Genome>) -> Vec<Self> {
        let plain = |genome: Genome| {
            let output = *genome.output();
            let bare = Output::new(*output.matrix(), [1.0; 3], [0.0; 3]).expect("it is one");
            let program = Program::lower(&genome.clone().with_output(bare));
            Self { hash: program.hash(), genome, program }
        };
        genomes.into_par_iter().map(plain).collect()
    }
}

/// The best of these genomes, at most `count`, least sum first, with scale and offset solved for. None of them stands out where
/// samples are few.
pub(super) fn judge(plain: Vec<Plain>, cases: &Cases, count: usize) -> Vec<Member> {
    let scaled = scaled(plain, &cases.few);
    let programs: Vec<&Program> = scaled.iter().map(|(_, program)| program).collect();
    let evaluator = CanonicalEvaluator::default();
    let selected = select_best(&evaluator, &programs, &cases.target, count, Screening::Exact)
        .expect("the canonical evaluator runs every program");
    let best: Vec<&Program> = selected.best.iter().map(|ranked| programs[ranked.program]).collect();
    let is_bounded = bounded(&best, cases);
    let member = |(ranked, is_bounded): (&brood_eval::Ranked, bool)| {
        let (plain, program) = &scaled[ranked.program];
        (is_bounded && ranked.sum.is_finite()).then(|| Member {
            genome: plain.genome.clone(),
            hash: plain.hash,
            operations: operations(program),
            sum: ranked.sum,
            is_tuned: false,
        })
    };
    selected.best.iter().zip(is_bounded).filter_map(member).collect()
}

/// The sum of one genome as it is; infinite where it stands out.
pub(super) fn sum_of(genome: &Genome, cases: &Cases) -> f64 {
    let program = Program::lower(genome);
    let sums = CanonicalEvaluator::default().sums(&[&program], &cases.target);
    let sum = sums.expect("the canonical evaluator runs every program")[0];
    if bounded(&[&program], cases)[0] { sum } else { f64::INFINITY }
}

/// The genome with scale and offset solved for.
pub(super) fn rescaled(genome: Genome, cases: &Cases) -> Genome {
    let plain = Plain::of(vec![genome]);
    let mut scaled = scaled(plain, &cases.few);
    scaled.swap_remove(0).0.genome
}

pub(super) fn operations(program: &Program) -> u32 {
    u32::try_from(program.operations()).expect("1024 instructions make fewer operations")
}

/// Genomes and their programs, scale and offset being solved for.
fn scaled(plain: Vec<Plain>, few: &Wanted) -> Vec<(Plain, Program)> {
    let programs: Vec<&Program> = plain.iter().map(|plain| &plain.program).collect();
    let values = values(&programs, few);
    let rows = |values: &[f64]| values.iter().step_by(SCALED).copied().collect::<Vec<_>>();
    let weight = rows(&few.weight);
    let wanted = [0, 1, 2].map(|channel| {
        few.weighted.iter().step_by(SCALED).map(|value| value[channel]).collect::<Vec<_>>()
    });
    let count = few.len();
    let scale = |(index, mut plain): (usize, Plain)| {
        let output = *plain.genome.output();
        let (mut scale, mut offset) = (*output.scale(), *output.offset());
        for channel in 0..3 {
            let own = &values[(3 * index + channel) * count..][..count];
            let sampled = own.iter().zip(&few.weight).step_by(SCALED);
            let weighted: Vec<f64> = sampled.map(|(f, weight)| f64::from(*f) * weight).collect();
            let start = [f64::from(scale[channel]), f64::from(offset[channel])];
            let found = scale_and_offset(&weighted, &weight, &wanted[channel], start);
            [scale[channel], offset[channel]] = found.map(narrow);
        }
        let output = Output::new(*output.matrix(), scale, offset).expect("they are in the range");
        plain.genome = plain.genome.with_output(output);
        let program = Program::lower(&plain.genome);
        (plain, program)
    };
    plain.into_par_iter().enumerate().map(scale).collect()
}

#[expect(clippy::cast_possible_truncation, reason = "rounded to the nearest f32")]
fn narrow(value: f64) -> f32 {
    value.min(f64::from(RANGE)) as f32
}

/// f of programs, each channel by itself.
pub(super) fn values(programs: &[&Program], wanted: &Wanted) -> Vec<f32> {
    let mut out = Vec::new();
    CanonicalEvaluator::default()
        .eval(programs, &wanted.set, &mut out)
        .expect("the canonical evaluator runs every program");
    out
}

/// Whether each stays below the ceiling where samples are few.
fn bounded(programs: &[&Program], cases: &Cases) -> Vec<bool> {
    let mut out = Vec::new();
    CanonicalEvaluator::default()
        .eval(programs, &cases.narrow, &mut out)
        .expect("the canonical evaluator runs every program");
    let values = out.chunks(3 * cases.narrow.len());
    values.map(|values| values.iter().all(|f| f64::from(*f) <= cases.ceiling)).collect()
}
