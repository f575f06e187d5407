//! Random models, mutation and crossover of layers, parameter by parameter, with amounts as for
//! instructions and constants.
//!
//! Steps are taken on the scale of each parameter ([`Parameter::share`]), so that a roughness near
//! 0.01 doubles as easily as one near 0.3. docs/maths/variation.md has the table of rates.

use super::strength::Strength;
use crate::locks::LockedLayers;
use crate::random::{Operator, Stream};
use crate::{BirthKey, LAYERS_MAX, Model, ModelKind, Parameter};

/// Standard deviation of random values from the defaults, as a share of the range.
const SPREAD: f64 = 0.25;
/// Standard deviation of a perturbation at amount 1, as a share of the range.
const STEP: f64 = 0.3;
/// Probability that a choice mutates at amount 1.
const CHOICE_RATE: f32 = 0.1;

/// Returns one random model.
pub(super) fn random(key: BirthKey) -> Vec<Model> {
    let mut stream = Stream::new(key, Operator::RandomLayers);
    let kind = kind(&mut stream);
    let model = Model::new(kind);
    let values: Vec<f64> = each_value(&model)
        .map(|(parameter, value)| match words(parameter) {
            Some(words) => f64::from(stream.below(words)),
            None => perturbed(parameter, value, SPREAD, &mut stream),
        })
        .collect();
    vec![Model::from_parameter_values(kind, &values).expect("values are drawn from their ranges")]
}

/// Mutates parts that are not locked. With `force`, at least one value changes at any amount above
/// 0, if any may.
pub(super) fn mutate(
    layers: &mut [Model],
    strength: Strength,
    key: BirthKey,
    force: bool,
    locked: &LockedLayers,
) {
    let mutation = strength.amount;
    if layers.is_empty() || mutation <= 0.0 {
        return;
    }
    let mut stream = Stream::new(key, Operator::MutateLayers);
    let mut changed = false;
    for (layer, model) in layers.iter_mut().enumerate() {
        if !locked.locks_kind(layer) && stream.chance(strength.kind_rate()) {
            *model = converted(model, different_kind(model.kind(), &mut stream));
            changed = true;
        }
        let mut values = model.parameter_values().to_vec();
        for (at, (parameter, value)) in each_value(model).enumerate() {
            let is_choice = words(parameter).is_some();
            let rate = if is_choice { CHOICE_RATE * mutation } else { strength.value_rate() };
            if !locked.locks_value(layer, at) && stream.chance(rate) {
                values[at] = different_value(parameter, value, strength, &mut stream);
                changed |= values[at].to_bits() != value.to_bits();
            }
        }
        *model = with_values(model, &values);
    }
    if force && !changed {
        mutate_one(layers, strength, locked, &mut stream);
    }
}

/// Mutates one value of one layer, if any may change.
fn mutate_one(
    layers: &mut [Model],
    strength: Strength,
    locked: &LockedLayers,
    stream: &mut Stream,
) {
    let mut free: Vec<(usize, usize)> = layers
        .iter()
        .enumerate()
        .flat_map(|(layer, model)| {
            let can_change = |(parameter, _)| words(parameter) != Some(1);
            let values = each_value(model).enumerate();
            values.filter(move |(_, value)| can_change(*value)).map(move |(at, _)| (layer, at))
        })
        .filter(|(layer, at)| !locked.locks_value(*layer, *at))
        .collect();
    let is_number = |(layer, at): &(usize, usize)| {
        each_value(&layers[*layer]).nth(*at).is_some_and(|(one, _)| words(one).is_none())
    };
    // A choice changes more than a small step of a number.
    if !strength.forces_choices() && free.iter().any(is_number) {
        free.retain(is_number);
    }
    if free.is_empty() {
        return;
    }
    let (layer, at) = free[stream.below(free.len() as u32) as usize];
    let model = &layers[layer];
    let (parameter, value) = each_value(model).nth(at).expect("it is one of its own");
    let mut values = model.parameter_values().to_vec();
    values[at] = different_value(parameter, value, strength, stream);
    layers[layer] = with_values(model, &values);
}

/// Crosses the layers of two parents: values of layers at the same index, whole models, and layers
/// that only the second parent has. `share` is the expected share of the second parent. If
/// `may_lose` is false, the child keeps at least one layer.
pub(super) fn recombine(
    (first, second): (&[Model], &[Model]),
    share: f32,
    key: BirthKey,
    (locked, may_lose): (&LockedLayers, bool),
) -> Vec<Model> {
    if first.is_empty() && second.is_empty() {
        return Vec::new();
    }
    let mut stream = Stream::new(key, Operator::RecombineLayers);
    let mut layers: Vec<Model> = first
        .iter()
        .enumerate()
        .map(|(layer, own)| match second.get(layer) {
            Some(other) => crossover((own, other), layer, share, locked, &mut stream),
            None => own.clone(),
        })
        .collect();
    // From the last to the first, so that removals do not shift the indices of layers still to be
    // visited.
    for layer in (second.len()..first.len()).rev() {
        let last = layers.len() == 1 && !may_lose;
        if !locked.locks_kind(layer) && !last && stream.chance(0.5 * share) {
            layers.remove(layer);
        }
    }
    let more = second.iter().skip(first.len());
    for other in more.take(if locked.is_closed() { 0 } else { LAYERS_MAX - layers.len() }) {
        if layers.is_empty() && !may_lose || stream.chance(share) {
            layers.push(other.clone());
        }
    }
    layers
}

/// Crosses two models at one index: sometimes takes the other's kind, and takes some of the other's
/// values of shared parameters.
fn crossover(
    (own, other): (&Model, &Model),
    layer: usize,
    share: f32,
    locked: &LockedLayers,
    stream: &mut Stream,
) -> Model {
    // If the other's kind is taken, shared parameters are still drawn one by one.
    let taken =
        !locked.locks_kind(layer) && own.kind() != other.kind() && stream.chance(0.5 * share);
    let base = if taken { converted(own, other.kind()) } else { own.clone() };
    let base = if taken { with_choices_of(base, other) } else { base };
    let mut values = base.parameter_values().to_vec();
    let mut at = 0;
    for (parameter, own_values) in base.parameters() {
        let theirs = other.get(parameter.name).filter(|theirs| theirs.len() == own_values.len());
        let draw = stream.chance(share);
        let is_shared = own.get(parameter.name).is_some();
        for (offset, value) in own_values.iter().enumerate() {
            let Some(theirs) = theirs else { continue };
            // Parameters that only the other model has come with its kind.
            let take = (draw || taken && !is_shared) && !locked.locks_value(layer, at + offset);
            let theirs = theirs[offset].clamp(parameter.range.0, parameter.range.1);
            let fits = words(parameter).is_none() || own.kind() == other.kind();
            values[at + offset] = if take && fits { theirs } else { *value };
        }
        at += own_values.len();
    }
    with_values(&base, &values)
}

/// Returns the model with the choices of another model of the same kind.
fn with_choices_of(model: Model, other: &Model) -> Model {
    other.parameters().filter(|(parameter, _)| words(parameter).is_some()).fold(
        model,
        |model, (parameter, values)| {
            model.with(parameter.name, values).expect("both are of one kind")
        },
    )
}

/// Returns a model of another kind with the values of the parameters that both kinds have.
pub(super) fn converted(model: &Model, kind: ModelKind) -> Model {
    model.parameters().fold(Model::new(kind), |made, (parameter, values)| {
        let Some(own) = kind.parameters().iter().find(|own| own.name == parameter.name) else {
            return made;
        };
        if words(own).is_some() || own.count() != values.len() {
            return made;
        }
        let (low, high) = own.range;
        let values: Vec<f64> = values.iter().map(|value| value.clamp(low, high)).collect();
        made.with(own.name, &values).expect("values have been brought into the range")
    })
}

fn kind(stream: &mut Stream) -> ModelKind {
    ModelKind::ALL[stream.below(ModelKind::ALL.len() as u32) as usize]
}

/// Draws a kind other than `own`.
fn different_kind(own: ModelKind, stream: &mut Stream) -> ModelKind {
    let mut others = ModelKind::ALL.iter().filter(|kind| **kind != own);
    let drawn = stream.below(ModelKind::ALL.len() as u32 - 1) as usize;
    *others.nth(drawn).expect("there is more than one kind")
}

/// Number of words of a choice; `None` for a scalar or a colour.
fn words(parameter: &Parameter) -> Option<u32> {
    parameter.words().map(|words| u32::try_from(words.len()).expect("there are few words"))
}

/// Iterates over all values, each with its parameter; a colour has three.
fn each_value(model: &Model) -> impl Iterator<Item = (&'static Parameter, f64)> {
    model
        .parameters()
        .flat_map(|(parameter, values)| values.iter().map(move |value| (parameter, *value)))
}

/// Draws a different value. A choice of one word stays.
fn different_value(
    parameter: &Parameter,
    value: f64,
    strength: Strength,
    stream: &mut Stream,
) -> f64 {
    match words(parameter) {
        Some(1) => value,
        Some(count) => {
            // Any word but the present one.
            let drawn = f64::from(stream.below(count - 1));
            if drawn >= value { drawn + 1.0 } else { drawn }
        }
        None if stream.chance(strength.redraw()) => parameter.at_share(f64::from(stream.unit())),
        None => perturbed(parameter, value, STEP * f64::from(strength.amount), stream),
    }
}

/// Perturbs a value on the scale of its range; the ends reflect.
fn perturbed(parameter: &Parameter, value: f64, step: f64, stream: &mut Stream) -> f64 {
    let share = parameter.share(value) + step * f64::from(stream.bell());
    let folded = share.rem_euclid(2.0);
    parameter.at_share(if folded > 1.0 { 2.0 - folded } else { folded })
}

/// Model of the same kind with other values, in its ranges.
pub(super) fn with_values(model: &Model, values: &[f64]) -> Model {
    Model::from_parameter_values(model.kind(), values).expect("operators keep to the ranges")
}

#[cfg(test)]
#[path = "layer_tests.rs"]
mod tests;
