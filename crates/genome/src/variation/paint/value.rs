//! Random values of the parameters of an effect and their mutation, palettes apart.

use brood_brdf::{Parameter, ParameterKind, ParameterValues};

use super::threshold::{self, reflected};
use crate::effect::{self, EffectKind};
use crate::locks::LockedEffects;
use crate::random::Stream;

/// Standard deviation of random numbers from their centres, as a share of the range.
pub(super) const SPREAD: f64 = 0.18;
/// Probability and standard deviation of a step of a number at amount 1.
const NUMBER_RATE: f64 = 0.6;
const NUMBER_STEP: f64 = 0.5;
/// Probability that the basis changes at amount 1, and that another choice does.
const BASIS_RATE: f64 = 0.5;
const CHOICE_RATE: f64 = 0.1;
/// Probability that the index of refraction takes a step at amount 1.
const INDEX_RATE: f64 = 0.8;
/// Share of random light effects that follow the eye.
const FACING: f32 = 0.1;

/// Draws a step of a number, 0 for most of them at small amounts.
pub(super) fn step(amount: f64, stream: &mut Stream) -> f64 {
    let is_drawn = f64::from(stream.unit()) < NUMBER_RATE * amount;
    let step = NUMBER_STEP * amount * f64::from(stream.bell());
    if is_drawn { step } else { 0.0 }
}

/// Draws values about their centres. Colours keep their defaults.
pub(super) fn random(kind: EffectKind, stream: &mut Stream) -> ParameterValues {
    let mut values = ParameterValues::new(kind.name(), kind.parameters());
    let mut draw = || SPREAD * f64::from(stream.bell());
    let steps = [draw(), draw()];
    set_thresholds(&mut values, threshold::moved(kind, threshold::centre(kind), steps));
    for parameter in kind.parameters() {
        let is_of_light = kind == EffectKind::Light;
        let drawn = match (parameter.kind, parameter.name) {
            (_, "from" | "to") | (ParameterKind::DisplayColor { .. }, _) => continue,
            // A dimmed light effect shows only its dark colours.
            (_, "strength") if is_of_light => continue,
            // There is no program to shift the amount, and lights are white in most scenes.
            (_, "brush" | "property" | "exponent") => continue,
            (ParameterKind::Choice { .. }, "by") => f64::from(u8::from(stream.chance(FACING))),
            (ParameterKind::Choice { words }, _) => f64::from(stream.below(words.len() as u32)),
            (ParameterKind::Scalar { default }, _) => {
                scaled(parameter, default, SPREAD * f64::from(stream.bell()))
            }
            (ParameterKind::Color { .. }, _) => unreachable!("effects have display colours"),
        };
        values.set(parameter.name, &[drawn]).expect("drawn from the range");
    }
    values
}

/// Moves a number on the scale of its range; the ends reflect.
fn scaled(parameter: &Parameter, value: f64, step: f64) -> f64 {
    parameter.at_share(reflected(parameter.share(value) + step))
}

/// Source of a light effect's amount; `None` for other effects.
fn source(values: &ParameterValues) -> Option<&'static str> {
    let mut parameters = values.iter();
    let found = parameters.find(|(parameter, _)| parameter.name == effect::BY);
    found.and_then(|(parameter, values)| parameter.word(values))
}

/// True if children without a change of this number would look alike: it acts only beside another
/// parameter or a program.
fn is_idle(values: &ParameterValues, name: &str, has_program: bool) -> bool {
    let source = source(values);
    let is_brdf = source == Some(effect::BRDF);
    match name {
        "brush" => !has_program || is_brdf,
        "exponent" => source.is_some_and(|source| source != "facing"),
        "shadow" => is_brdf,
        _ => false,
    }
}

/// Mutates the numbers and choices that are not locked.
pub(super) fn mutate(
    values: &mut ParameterValues,
    (kind, locked): (EffectKind, &LockedEffects),
    (amount, has_program): (f64, bool),
    stream: &mut Stream,
) {
    let steps = [step(amount, stream), step(amount, stream)];
    move_thresholds(values, (kind, locked), steps);
    for parameter in kind.parameters() {
        let name = parameter.name;
        let value = values.get(name).expect("the parameter is in the table of the kind")[0];
        let drawn = match parameter.kind {
            ParameterKind::Scalar { .. } if matches!(name, "from" | "to") => continue,
            ParameterKind::Scalar { .. } => match step(amount, stream) {
                0.0 => value,
                _ if is_idle(values, name, has_program) => value,
                step => scaled(parameter, value, step),
            },
            ParameterKind::Choice { words } => {
                let rate = match name {
                    "basis" => BASIS_RATE,
                    "index" => INDEX_RATE,
                    _ => CHOICE_RATE,
                };
                let is_drawn = f64::from(stream.unit()) < rate * amount;
                // A genome has a BRDF to paint or not: mutation does not add or remove it.
                let is_source = name == effect::BY;
                let fixed = usize::from(is_source);
                let is_fixed = is_source && words[value as usize] == effect::BRDF;
                let draw = stream.below((words.len() - fixed) as u32 - 1);
                let other = match name {
                    "index" => f64::from(effect::index_beside(value as u8, draw.is_multiple_of(2))),
                    // Any word but the present one.
                    _ if f64::from(draw) >= value => f64::from(draw) + 1.0,
                    _ => f64::from(draw),
                };
                if is_drawn && !is_fixed { other } else { value }
            }
            ParameterKind::Color { .. } | ParameterKind::DisplayColor { .. } => continue,
        };
        if !locked.locks(kind, name) {
            values.set(name, &[drawn]).expect("mutation keeps to the range");
        }
    }
}

/// Moves one number that is not locked, and returns true; false if there is none.
pub(super) fn mutate_one(
    values: &mut ParameterValues,
    (kind, locked): (EffectKind, &LockedEffects),
    (amount, has_program): (f64, bool),
    stream: &mut Stream,
) -> bool {
    let is_free = |parameter: &&Parameter| {
        matches!(parameter.kind, ParameterKind::Scalar { .. })
            && !locked.locks(kind, parameter.name)
            && !is_idle(values, parameter.name, has_program)
    };
    let free: Vec<&Parameter> = kind.parameters().iter().filter(is_free).collect();
    if free.is_empty() {
        return false;
    }
    let parameter = free[stream.below(free.len() as u32) as usize];
    let step = NUMBER_STEP * amount * f64::from(stream.bell());
    match parameter.name {
        "from" | "to" => move_thresholds(values, (kind, locked), [step, step]),
        name => {
            let value = values.get(name).expect("the parameter is in the table of the kind")[0];
            values.set(name, &[scaled(parameter, value, step)]).expect("it stays in the range");
        }
    }
    true
}

/// Moves the thresholds that are not locked. A free one ends at a locked one.
fn move_thresholds(
    values: &mut ParameterValues,
    (kind, locked): (EffectKind, &LockedEffects),
    steps: [f64; 2],
) {
    let scalar = |name: &str| values.get(name).expect("all effects have thresholds")[0];
    let old = (scalar("from"), scalar("to"));
    let new = match source(values) {
        Some(effect::BRDF) => threshold::moved_levels(old, steps),
        _ => threshold::moved(kind, old, steps),
    };
    let new = match (locked.locks(kind, "from"), locked.locks(kind, "to")) {
        (false, false) => new,
        (true, false) => (old.0, new.1.max(old.0)),
        (false, true) => (new.0.min(old.1), old.1),
        (true, true) => old,
    };
    set_thresholds(values, new);
}

fn set_thresholds(values: &mut ParameterValues, (from, to): (f64, f64)) {
    values.set("from", &[from]).expect("thresholds stay in their ranges");
    values.set("to", &[to]).expect("thresholds stay in their ranges");
}
