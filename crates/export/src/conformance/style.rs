//! Styles of the suite: painted materials with random parameters, a third of them with a program.

use brood_genome::{BirthKey, Dialect, Effect, Genome, OpcodeSet, Start, Variation};
use brood_program::Program;

/// Number of styles.
const STYLES: u32 = 48;

/// Returns styles with random effects, without programs and with programs of all dialects.
#[must_use]
pub fn styles() -> Vec<Program> {
    (0..STYLES).map(|slot| Program::lower(&style(slot))).collect()
}

fn style(slot: u32) -> Genome {
    let key = BirthKey { seed: 13, slot, attempt: 0 };
    let random = Variation::random(Start::Painted.dialect()).with_start(Start::Painted);
    let painted = random.birth(key);
    let opcodes = match slot % 6 {
        0 => OpcodeSet::Directed,
        3 => OpcodeSet::Paper,
        _ => return painted,
    };
    // Programs of the dialect `extended` are valid in `directed`, which has more inputs.
    let of_program = if opcodes == OpcodeSet::Directed { OpcodeSet::Extended } else { opcodes };
    let dialect = Dialect { opcodes: of_program, registers: 16, ..Dialect::default() };
    let program = Variation::random(dialect).birth(key);
    let effects = painted.effects().iter().map(brushed).collect();
    let constants = Box::new(*program.constants());
    let dialect = Dialect { opcodes, ..dialect };
    Genome::painted(dialect, program.instructions().to_vec(), constants, effects)
        .expect("the effects are those of a painted genome")
}

/// The effect with the largest `brush`, if it has one.
fn brushed(effect: &Effect) -> Effect {
    let mut values = effect.values().clone();
    // Other effects than light have no brush.
    let _ = values.set("brush", &[1.0]);
    Effect::new(effect.kind(), values, effect.palette().cloned()).expect("the ends ascend")
}
