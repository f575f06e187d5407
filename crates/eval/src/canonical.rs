//! The canonical evaluator: f32 over blocks of 256 samples, one instruction at a time over a whole
//! block.
//!
//! A program is translated once per batch ([`Code`]) and then run block by block ([`BoundCode`]).
//! The loops are plain code that the compiler vectorises. Every lane computes exactly what
//! [`brood_program::execute`] computes for one sample, so results do not depend on block borders,
//! threads or vector width.

mod block;
mod code;
mod kernel;

use std::cell::RefCell;

use brood_brdf::{Level, SimdKernel};
use brood_genome::{Arithmetic, Output};
use brood_program::Program;
use brood_scene::SampleSet;
use rayon::prelude::*;

pub(crate) use block::{BoundCode, Span, Workspace};
pub(crate) use code::Code;

use crate::evaluator::{EvalResult, Evaluator, Lowered};
use crate::lanes::{BLOCK, LANES, Quarter};
use crate::layer;

/// Number of samples per rayon task.
const TASK: usize = 16 * BLOCK;

/// Evaluates in plain f32 on the CPU; defines the bits that all exact evaluators share.
#[derive(Debug, Clone, Copy)]
pub struct CanonicalEvaluator {
    level: Level,
}

impl Default for CanonicalEvaluator {
    fn default() -> Self {
        Self::with_level(Level::best())
    }
}

impl CanonicalEvaluator {
    /// Creates an evaluator that uses one instruction set; the default is [`Level::best`]. All give
    /// the same bits.
    #[must_use]
    pub fn with_level(level: Level) -> Self {
        Self { level }
    }

    /// Returns the instruction set in use.
    #[must_use]
    pub fn level(&self) -> Level {
        self.level
    }
}

impl Evaluator for CanonicalEvaluator {
    fn name(&self) -> &str {
        "cpu"
    }

    fn is_exact(&self) -> bool {
        true
    }

    fn eval(&self, programs: &[&Program], set: &SampleSet, out: &mut Vec<f32>) -> EvalResult {
        let lowered = Lowered::of(programs, set)?;
        let programs = lowered.programs();
        let samples = set.len();
        // Not cleared first: every value is written below.
        out.resize(programs.len() * 3 * samples, 0.0);
        if samples == 0 {
            return Ok(());
        }
        let codes: Vec<Code<'_>> =
            programs.par_iter().map(|program| Code::new(program, set, self.level)).collect();
        // The reflectance of layers is written to `out` first, where the sum will be.
        let rows = codes.iter().zip(out.chunks_exact_mut(3 * samples));
        let mut layered: Vec<_> =
            rows.filter_map(|(code, out)| Some((code.layers()?, channels(out, samples)))).collect();
        if !layered.is_empty() {
            layer::fill(&mut layered, set, self.level);
        }
        codes.par_iter().zip(out.par_chunks_mut(3 * samples)).for_each(|(code, out)| {
            let [red, green, blue] = channels(out, samples);
            let tasks = red.par_chunks_mut(TASK).zip(green.par_chunks_mut(TASK));
            let tasks = tasks.zip(blue.par_chunks_mut(TASK));
            tasks.enumerate().for_each(|(task, ((red, green), blue))| {
                with_workspace(|workspace| {
                    let out = [red, green, blue];
                    self.level.run(Reflectance { code, start: task * TASK, out, workspace });
                });
            });
        });
        Ok(())
    }
}

/// Splits the values of one program into red, green and blue.
fn channels(out: &mut [f32], samples: usize) -> [&mut [f32]; 3] {
    let (red, rest) = out.split_at_mut(samples);
    let (green, blue) = rest.split_at_mut(samples);
    [red, green, blue]
}

thread_local! {
    static WORKSPACE: RefCell<Workspace> = RefCell::new(Workspace::new());
}

/// Runs `f` with the workspace of the thread. `f` must not wait for other rayon tasks: one of them
/// could run on this thread and borrow the workspace again.
pub(crate) fn with_workspace<R>(f: impl FnOnce(&mut Workspace) -> R) -> R {
    WORKSPACE.with_borrow_mut(f)
}

/// Kernel that computes the reflectance of the samples from `start` on, as many as the rows of
/// `out` are long. If the program has layers, `out` already contains their reflectance.
struct Reflectance<'a> {
    code: &'a Code<'a>,
    start: usize,
    out: [&'a mut [f32]; 3],
    workspace: &'a mut Workspace,
}

impl SimdKernel for Reflectance<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { code, start, mut out, workspace } = self;
        let samples = out[0].len();
        let mut f = [Quarter([0.0; LANES]); 3];
        let mut bound = BoundCode::new(code, workspace);
        for offset in (0..samples).step_by(BLOCK) {
            let mut span = Span::of(offset, samples);
            span.start += start;
            let results = bound.block(span);
            for (quarter, at) in (offset..offset + span.length).step_by(LANES).enumerate() {
                let g = results.quarter(quarter);
                let end = samples.min(at + LANES);
                let layers = code.layers().map(|_| out.each_ref().map(|row| &row[at..end]));
                reflectance(code.program(), g, layers, &mut f);
                for (out, f) in out.iter_mut().zip(&f) {
                    let out = &mut out[at..];
                    match out.first_chunk_mut() {
                        Some(whole) => *whole = f.0,
                        None => out.copy_from_slice(&f.0[..out.len()]),
                    }
                }
            }
        }
    }
}

/// Computes f of one quarter of a block from the results `g` of the program: g^2, plus the
/// reflectance of the layers if there are any, through the output stage. Colours stay as they are.
#[inline(always)]
pub(crate) fn reflectance(
    program: &Program,
    g: [&[f32; LANES]; 3],
    layers: Option<[&[f32]; 3]>,
    f: &mut [Quarter; 3],
) {
    if program.is_color() {
        f.iter_mut().zip(g).for_each(|(f, g)| f.0 = *g);
        return;
    }
    for (f, g) in f.iter_mut().zip(g) {
        for (f, g) in f.0.iter_mut().zip(g) {
            *f = g.square();
        }
    }
    if let Some(layers) = layers {
        for (f, layer) in f.iter_mut().zip(layers) {
            for (f, layer) in f.0.iter_mut().zip(layer) {
                *f += layer;
            }
        }
    }
    let output = program.output();
    // The identity changes no bit: values are not negative.
    if *output != Output::IDENTITY {
        let [red, green, blue] = f;
        for ((red, green), blue) in red.0.iter_mut().zip(&mut green.0).zip(&mut blue.0) {
            [*red, *green, *blue] = output.apply([*red, *green, *blue]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn canonical_evaluator_passes_the_conformance_suite_at_every_level() {
        for level in Level::available() {
            println!("{}", level.name());
            crate::conformance::check(&CanonicalEvaluator::with_level(level));
        }
    }
}
