//! Start-up probe: checks that an adapter, with a given shader, is bit-equal to the canonical
//! evaluator.
//!
//! A few dozen random programs, painted materials and sweeps of every function run on the device
//! and on the CPU, there with [`execute`], which defines the results; the bits are compared. The
//! probe takes milliseconds and decides whether the adapter counts as exact.

use brood_brdf::{Input, InputMask, Lighting};
use brood_eval::conformance::wild_style;
use brood_genome::{
    BirthKey, Dialect, Genome, OpcodeSet, Operator, Output, RANGE, Stream, Variation,
};
use brood_program::{Program, execute};

use crate::GpuError;
use crate::engine::Engine;
use crate::guard::Finding;
use crate::residency::Rows;

/// Not a multiple of any width in the shader, so that ends of rows are probed as well.
const SAMPLES: usize = 1003;
/// Number of random programs, besides the sweeps.
const RANDOM_PROGRAMS: u32 = 24;
/// Number of painted materials.
const STYLES: u64 = 9;

/// Runs the probe on an engine with its current style.
pub(crate) fn probe(engine: &mut Engine) -> Result<Finding, GpuError> {
    let programs = programs();
    let inputs = inputs();
    let references: Vec<&Program> = programs.iter().collect();
    let rows = Rows {
        mask: Input::ALL.into_iter().collect::<InputMask>(),
        set: None,
        row: &|input| &inputs[input.index()],
        len: SAMPLES,
    };
    let mut out = vec![f32::NAN; programs.len() * 3 * SAMPLES];
    engine.run(&references, &rows, &mut out)?;
    Ok(compare(&programs, &inputs, &out))
}

/// Compares the values of the device with the canonical ones.
fn compare(programs: &[Program], inputs: &[Vec<f32>], out: &[f32]) -> Finding {
    let (mut different, mut flushed) = (0u32, 0u32);
    let mut first = String::new();
    for (index, program) in programs.iter().enumerate() {
        for sample in 0..SAMPLES {
            let f: [f32; 3] =
                execute(program, |input| inputs[input.index()][sample], |c| c.canonical);
            for (channel, expected) in f.into_iter().enumerate() {
                let got = out[(3 * index + channel) * SAMPLES + sample];
                if got.to_bits() == expected.to_bits() {
                    continue;
                }
                if expected.is_subnormal() && got.abs() <= 0.0 {
                    flushed += 1;
                    continue;
                }
                if different == 0 {
                    first = format!(
                        "; first: program {index}, channel {channel}, sample {sample}: \
                         {got:?}, expected {expected:?}"
                    );
                }
                different += 1;
            }
        }
    }
    let compared = out.len();
    Finding {
        exact: different == 0 && flushed == 0,
        flushes_subnormals: flushed > 0,
        detail: format!(
            "{different} of {compared} values differ, {flushed} subnormal ones are zero{first}"
        ),
    }
}

/// Returns the programs of the probe.
fn programs() -> Vec<Program> {
    let mut genomes: Vec<Genome> = sweeps();
    for slot in 0..RANDOM_PROGRAMS {
        let dialect = if slot % 2 == 0 {
            Dialect::default()
        } else {
            Dialect { opcodes: OpcodeSet::Extended, registers: 10, ..Dialect::default() }
        };
        let output = (slot % 3 == 0).then(|| {
            let saturated = Output::saturation(0.7).expect("a saturation within 0 to 1");
            Output::new(*saturated.matrix(), [0.3, 1.7, 1.1], [0.01, 0.0, 0.3])
                .expect("numbers within the range")
        });
        let key = BirthKey { seed: 11, slot, attempt: 0 };
        genomes.push(Variation::random(dialect).with_output(output).birth(key));
    }
    let programs = genomes.iter().map(Program::lower);
    let lightings = [1, 2, 8].map(|lights| Lighting { lights, has_shadows: true });
    let styles = (0..STYLES).zip(lightings.into_iter().cycle());
    let styles = styles.map(|(seed, lights)| Program::lower(&wild_style(seed)).painted(lights));
    programs.chain(styles).collect()
}

/// Returns genomes that apply every function to an input. Results are squared, which loses their
/// sign; the green channel adds 2 first, which shows it.
fn sweeps() -> Vec<Genome> {
    let functions = ["SIN", "COS", "EX2", "LG2", "RCP", "RSQ", "SPL"];
    let mut texts: Vec<String> = functions
        .into_iter()
        .map(|f| format!("{f} R2.x, R1.z\nADD R2.y, R2.x, C0.x\n{f} R2.z, -R1.w\n"))
        .collect();
    texts.push("MUL R2.x, R1.z, R1.w\nADD R2.y, R1.z, R1.w\nMAD R2.z, R1.z, R1.w, C0.z\n".into());
    texts
        .into_iter()
        .map(|text| {
            let head = "brood 1\n.dialect extended smooth registers 10\n.const C0 2 -1 0.3 0.25\n";
            format!("{head}{text}MOV R0.xyz, R2\n").parse().expect("a valid genome text")
        })
        .collect()
}

/// Returns a row for every input, those of painted materials included: mostly numbers as in scenes;
/// for u and v numbers of all magnitudes, small enough that some squares are subnormal.
pub(crate) fn inputs() -> Vec<Vec<f32>> {
    let key = BirthKey { seed: 12, slot: 0, attempt: 0 };
    let mut stream = Stream::new(key, Operator::RandomConstants);
    Input::ALL
        .into_iter()
        .map(|input| {
            let wide = matches!(input, Input::U | Input::V);
            let mut number = || {
                if !wide && stream.chance(0.9) {
                    return stream.unit() * 4.0 - 2.0;
                }
                let exponent = 127 - 72 + stream.below(72 + 17);
                let number = f32::from_bits(stream.bits() & 0x807f_ffff | exponent << 23);
                number.clamp(-RANGE, RANGE)
            };
            (0..SAMPLES).map(|_| number()).collect()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the canonical values, as an exact adapter would.
    fn canonical(programs: &[Program], inputs: &[Vec<f32>]) -> Vec<f32> {
        let mut out = vec![0.0; programs.len() * 3 * SAMPLES];
        for (index, program) in programs.iter().enumerate() {
            for sample in 0..SAMPLES {
                let f = execute(program, |i| inputs[i.index()][sample], |c| c.canonical);
                for (channel, f) in f.into_iter().enumerate() {
                    out[(3 * index + channel) * SAMPLES + sample] = f;
                }
            }
        }
        out
    }

    #[test]
    fn compare_detects_one_bit_and_flushed_subnormals() {
        let (programs, inputs) = (programs(), inputs());
        let mut out = canonical(&programs, &inputs);
        let finding = compare(&programs, &inputs, &out);
        assert!(finding.exact && !finding.flushes_subnormals, "{}", finding.detail);

        let subnormal = out.iter().filter(|f| f.is_subnormal()).count();
        assert!(subnormal > 20, "only {subnormal} results are subnormal, more than 20 are needed");
        for f in &mut out {
            *f = if f.is_subnormal() { 0.0 } else { *f };
        }
        let finding = compare(&programs, &inputs, &out);
        assert!(!finding.exact && finding.flushes_subnormals, "{}", finding.detail);

        let at = out.iter().position(|f| f.is_normal()).unwrap();
        out = canonical(&programs, &inputs);
        out[at] = f32::from_bits(out[at].to_bits() + 1);
        let finding = compare(&programs, &inputs, &out);
        assert!(!finding.exact && !finding.flushes_subnormals, "{}", finding.detail);
    }

    #[test]
    fn probe_programs_use_every_operation() {
        let programs = programs();
        for operation in brood_program::Operation::ALL {
            let steps = programs.iter().flat_map(Program::steps);
            let used = steps.filter(|step| step.operation == operation).count();
            assert!(used > 0, "{}", operation.name());
        }
    }
}
