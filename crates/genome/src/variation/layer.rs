//! What happens to layers: models drawn, pushed and crossed, parameter by parameter, with the amounts that instructions and
//! constants have.
//!
//! Steps are taken on the scale of each parameter ([`Parameter::share`]), so that a roughness doubles as easily near 0.01 as
//! near 0.3. docs/maths/variation.md has the table.

use crate::locks::HeldLayers;
use crate::random::{Operator, Stream};
use crate::{BirthKey, LAYERS_MAX, Model, ModelKind, Parameter};

/// How far the values of a model from nothing are from the defaults, in shares of the range.
const SPREAD: f64 = 0.25;
/// Probability that a number mutates at amount 1: that of a constant.
const NUMBER_RATE: f32 = 0.5;
/// How far a number is pushed at amount 1, in shares of the range.
const STEP: f64 = 0.3;
/// Share of mutations of numbers that draw afresh instead of pushing.
const REDRAW: f32 = 0.1;
/// Probability that a choice of words mutates at amount 1.
const CHOICE_RATE: f32 = 0.1;
/// Probability that a model gives way to another one at amount 1; it grows with the square of the amount, as for instructions.
const KIND_RATE: f32 = 0.15;

/// One model from nothing.
pub(super) fn random(key: BirthKey) -> Vec<Model> {
    let mut stream = Stream::new(key, Operator::RandomLayers);
    let kind = kind(&mut stream);
    let model = Model::new(kind);
    let numbers: Vec<f64> = each_number(&model)
        .map(|(parameter, number)| match words(parameter) {
            Some(words) => f64::from(stream.below(words)),
            None => pushed(parameter, number, SPREAD, &mut stream),
        })
        .collect();
    vec![Model::from_numbers(kind, &numbers).expect("values are drawn from their ranges")]
}

/// Mutates in place what is not held. With `force`, something changes at any amount above 0 where anything may.
pub(super) fn mutate(
    layers: &mut [Model],
    mutation: f32,
    key: BirthKey,
    force: bool,
    held: &HeldLayers,
) {
    if layers.is_empty() {
        return;
    }
    let mut stream = Stream::new(key, Operator::MutateLayers);
    let mut changed = false;
    for (layer, model) in layers.iter_mut().enumerate() {
        if !held.kind(layer) && stream.chance(KIND_RATE * mutation * mutation) {
            *model = converted(model, another_kind(model.kind(), &mut stream));
            changed = true;
        }
        let mut numbers = model.numbers().to_vec();
        for (at, (parameter, number)) in each_number(model).enumerate() {
            let rate = if words(parameter).is_some() { CHOICE_RATE } else { NUMBER_RATE };
            if !held.number(layer, at) && stream.chance(rate * mutation) {
                numbers[at] = another(parameter, number, mutation, &mut stream);
                changed |= numbers[at].to_bits() != number.to_bits();
            }
        }
        *model = of_same_kind(model, &numbers);
    }
    if force && !changed && mutation > 0.0 {
        mutate_one(layers, mutation, held, &mut stream);
    }
}

/// Mutates one number of one layer, if any may.
fn mutate_one(layers: &mut [Model], mutation: f32, held: &HeldLayers, stream: &mut Stream) {
    let free: Vec<(usize, usize)> = layers
        .iter()
        .enumerate()
        .flat_map(|(layer, model)| {
            let can_change = |(parameter, _)| words(parameter) != Some(1);
            let numbers = each_number(model).enumerate();
            numbers.filter(move |(_, number)| can_change(*number)).map(move |(at, _)| (layer, at))
        })
        .filter(|(layer, at)| !held.number(*layer, *at))
        .collect();
    if free.is_empty() {
        return;
    }
    let (layer, at) = free[stream.below(free.len() as u32) as usize];
    let model = &layers[layer];
    let (parameter, number) = each_number(model).nth(at).expect("it is one of its own");
    let mut numbers = model.numbers().to_vec();
    numbers[at] = another(parameter, number, mutation, stream);
    layers[layer] = of_same_kind(model, &numbers);
}

/// The layers of the first parent with parts of the second's: numbers of layers at the same place, whole models, layers that
/// the first has not. `share` is the expected share of the second. `may_lose` says whether a child without layers is one.
pub(super) fn recombine(
    (first, second): (&[Model], &[Model]),
    share: f32,
    key: BirthKey,
    (held, may_lose): (&HeldLayers, bool),
) -> Vec<Model> {
    if first.is_empty() && second.is_empty() {
        return Vec::new();
    }
    let mut stream = Stream::new(key, Operator::RecombineLayers);
    let mut layers: Vec<Model> = first
        .iter()
        .enumerate()
        .map(|(layer, own)| match second.get(layer) {
            Some(other) => crossed((own, other), layer, share, held, &mut stream),
            None => own.clone(),
        })
        .collect();
    // From the last, so that those before keep their places.
    for layer in (second.len()..first.len()).rev() {
        let last = layers.len() == 1 && !may_lose;
        if !held.kind(layer) && !last && stream.chance(0.5 * share) {
            layers.remove(layer);
        }
    }
    let more = second.iter().skip(first.len());
    for other in more.take(if held.is_closed() { 0 } else { LAYERS_MAX - layers.len() }) {
        if layers.is_empty() && !may_lose || stream.chance(share) {
            layers.push(other.clone());
        }
    }
    layers
}

/// Two models at one place: now and then the other's kind, and of the parameters that both have some of the other's.
fn crossed(
    (own, other): (&Model, &Model),
    layer: usize,
    share: f32,
    held: &HeldLayers,
    stream: &mut Stream,
) -> Model {
    // Of a kind that is taken over, the parameters that both have are still drawn one by one.
    let taken = !held.kind(layer) && own.kind() != other.kind() && stream.chance(0.5 * share);
    let base = if taken { converted(own, other.kind()) } else { own.clone() };
    let base = if taken { with_own_words(base, other) } else { base };
    let mut numbers = base.numbers().to_vec();
    let mut at = 0;
    for (parameter, values) in base.parameters() {
        let theirs = other.get(parameter.name).filter(|theirs| theirs.len() == values.len());
        let draw = stream.chance(share);
        let is_shared = own.get(parameter.name).is_some();
        for (offset, value) in values.iter().enumerate() {
            let Some(theirs) = theirs else { continue };
            // What only the other one has comes with its kind.
            let take = (draw || taken && !is_shared) && !held.number(layer, at + offset);
            let theirs = theirs[offset].clamp(parameter.range.0, parameter.range.1);
            let fits = words(parameter).is_none() || own.kind() == other.kind();
            numbers[at + offset] = if take && fits { theirs } else { *value };
        }
        at += values.len();
    }
    of_same_kind(&base, &numbers)
}

/// The model with the words that another one of its kind has chosen.
fn with_own_words(model: Model, other: &Model) -> Model {
    other.parameters().filter(|(parameter, _)| words(parameter).is_some()).fold(
        model,
        |model, (parameter, numbers)| {
            model.with(parameter.name, numbers).expect("both are of one kind")
        },
    )
}

/// A model of another kind, with the values of the parameters that both have.
fn converted(model: &Model, kind: ModelKind) -> Model {
    model.parameters().fold(Model::new(kind), |made, (parameter, numbers)| {
        let Some(own) = kind.parameters().iter().find(|own| own.name == parameter.name) else {
            return made;
        };
        if words(own).is_some() || own.count() != numbers.len() {
            return made;
        }
        let (low, high) = own.range;
        let numbers: Vec<f64> = numbers.iter().map(|number| number.clamp(low, high)).collect();
        made.with(own.name, &numbers).expect("values have been brought into the range")
    })
}

fn kind(stream: &mut Stream) -> ModelKind {
    ModelKind::ALL[stream.below(ModelKind::ALL.len() as u32) as usize]
}

/// Any kind but that one.
fn another_kind(own: ModelKind, stream: &mut Stream) -> ModelKind {
    let mut others = ModelKind::ALL.iter().filter(|kind| **kind != own);
    let drawn = stream.below(ModelKind::ALL.len() as u32 - 1) as usize;
    *others.nth(drawn).expect("there is more than one kind")
}

/// How many words a choice has; none where it is a number.
fn words(parameter: &Parameter) -> Option<u32> {
    parameter.words().map(|words| u32::try_from(words.len()).expect("there are few words"))
}

fn each_number(model: &Model) -> impl Iterator<Item = (&'static Parameter, f64)> {
    model
        .parameters()
        .flat_map(|(parameter, numbers)| numbers.iter().map(move |number| (parameter, *number)))
}

/// Another value of a number or a choice.
fn another(parameter: &Parameter, number: f64, mutation: f32, stream: &mut Stream) -> f64 {
    match words(parameter) {
        Some(1) => number,
        Some(count) => {
            // Any word but the present one.
            let drawn = f64::from(stream.below(count - 1));
            if drawn >= number { drawn + 1.0 } else { drawn }
        }
        None if stream.chance(REDRAW) => parameter.at_share(f64::from(stream.unit())),
        None => pushed(parameter, number, STEP * f64::from(mutation), stream),
    }
}

/// A value pushed along the scale of its range; the ends reflect.
fn pushed(parameter: &Parameter, number: f64, step: f64, stream: &mut Stream) -> f64 {
    let share = parameter.share(number) + step * f64::from(stream.bell());
    let folded = share.rem_euclid(2.0);
    parameter.at_share(if folded > 1.0 { 2.0 - folded } else { folded })
}

fn of_same_kind(model: &Model, numbers: &[f64]) -> Model {
    Model::from_numbers(model.kind(), numbers).expect("operators keep to the ranges")
}

#[cfg(test)]
#[path = "layer_tests.rs"]
mod tests;
