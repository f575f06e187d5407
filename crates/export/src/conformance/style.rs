//! Styles of the suite: painted materials with random parameters, a third of them with a program,
//! the last with glass.

use brood_brdf::ParameterValues;
use brood_genome::{
    BirthKey, Dialect, Effect, EffectKind, Genome, OpcodeSet, Operator, Start, Stream, Variation,
    preset,
};
use brood_program::Program;

use super::share;

/// Number of styles without glass.
const STYLES: u32 = 48;
/// Number of styles with random glass.
const CLEAR: u32 = 14;
/// Presets of clear bodies.
const PRESETS: [&str; 2] = ["paint-glass", "paint-jelly"];

/// Returns styles with random effects, without programs and with programs of all dialects, and then
/// some with glass.
#[must_use]
pub fn styles() -> Vec<Program> {
    let presets = PRESETS.map(|name| preset::Preset::find(name).expect("the preset exists"));
    let styles = (0..STYLES).map(|slot| Program::lower(&style(slot)));
    let clear = (0..CLEAR).map(|slot| Program::lower(&clear(slot)));
    let presets = presets.iter().map(|preset| Program::lower(preset.genome()));
    styles.chain(clear).chain(presets).collect()
}

/// Style with random glass somewhere above its light.
fn clear(slot: u32) -> Genome {
    let below = style(slot);
    let key = BirthKey { seed: 17, slot, attempt: 0 };
    let stream = &mut Stream::new(key, Operator::RandomLayers);
    let kind = EffectKind::Glass;
    let mut values = ParameterValues::new(kind.name(), kind.parameters());
    for parameter in kind.parameters() {
        let drawn: Vec<f64> = match parameter.words() {
            Some(words) => {
                let count = u32::try_from(words.len()).expect("choices are few");
                vec![f64::from(stream.below(count))]
            }
            None => (0..parameter.count()).map(|_| parameter.at_share(share(stream))).collect(),
        };
        values.set(parameter.name, &drawn).expect("shares are within the range");
    }
    let [from, to] = ["from", "to"].map(|name| values.get(name).expect("glass has ends")[0]);
    values.set("from", &[from.min(to)]).expect("the ends have one range");
    values.set("to", &[from.max(to)]).expect("the ends have one range");
    let glass = Effect::new(kind, values, None).expect("the ends ascend");
    let mut effects = below.effects().to_vec();
    let count = u32::try_from(effects.len()).expect("effects are few");
    effects.insert(1 + stream.below(count) as usize, glass);
    let (instructions, constants) = (below.instructions().to_vec(), *below.constants());
    Genome::painted(*below.dialect(), instructions, Box::new(constants), effects)
        .expect("the effects below are those of a painted genome")
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
