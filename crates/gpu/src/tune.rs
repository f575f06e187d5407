//! Measurement of the fastest layout of the interpreter and the fastest exact guard on a device.
//! They cannot be predicted: drivers place private arrays in registers, cache or memory.

use std::time::{Duration, Instant};

use brood_brdf::{Input, InputMask};
use brood_genome::{BirthKey, Dialect, Variation};
use brood_program::Program;

use crate::GpuError;
use crate::engine::Engine;
use crate::guard::Guard;
use crate::interpreter_layout::InterpreterLayout;
use crate::probe::inputs;
use crate::residency::Rows;
use crate::shader::Style;

/// No further candidate is tried after this time, to bound the start-up time.
const LIMIT: Duration = Duration::from_millis(1200);
/// Number of programs of the measured batch.
const PROGRAMS: u32 = 20;
/// Number of samples of the measured batch.
const SAMPLES: usize = 1 << 16;
/// Number of runs of each candidate; the fastest counts.
const ROUNDS: u32 = 5;

/// Times each layout with each guard and returns those that ran, fastest first, with the device
/// seconds of a brood of 20 over 65,536 samples.
pub(crate) fn tune(
    engine: &mut Engine,
    shapes: &[InterpreterLayout],
    guards: &[Guard],
) -> Result<Vec<(InterpreterLayout, Guard, f64)>, GpuError> {
    let random = Variation::random(Dialect::default());
    let birth = |slot| random.birth(BirthKey { seed: 17, slot, attempt: 0 });
    let programs: Vec<Program> = (0..PROGRAMS).map(|slot| Program::lower(&birth(slot))).collect();
    let programs: Vec<&Program> = programs.iter().collect();
    let mask = programs.iter().fold(InputMask::EMPTY, |mask, p| mask.union(p.inputs()));
    let inputs: Vec<Vec<f32>> =
        inputs().iter().map(|row| row.iter().copied().cycle().take(SAMPLES).collect()).collect();
    let row = |input: Input| inputs[input.index()].as_slice();
    let rows = Rows { set: None, mask, len: SAMPLES, row: &row };
    let mut out = vec![0.0; programs.len() * 3 * SAMPLES];
    let started = Instant::now();
    let mut timed = Vec::new();
    for shape in shapes {
        for guard in guards {
            if !timed.is_empty() && started.elapsed() > LIMIT {
                continue;
            }
            engine.set_style(Style { guard: *guard, shape: *shape, contracts: false });
            let mut best_s = f64::INFINITY;
            for _ in 0..ROUNDS {
                engine.timing = Default::default();
                engine.run(&programs, &rows, &mut out)?;
                best_s = best_s.min(engine.timing.device_s);
            }
            timed.push((*shape, *guard, best_s));
        }
    }
    timed.sort_by(|a, b| a.2.total_cmp(&b.2));
    Ok(timed)
}
