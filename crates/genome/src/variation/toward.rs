//! Steps of models in the directions of a steer, after their mutation.

use super::layer::{converted, with_values};
use crate::locks::LockedLayers;
use crate::random::{Operator, Stream};
use crate::steer::{Toward, gloss_sign};
use crate::{BirthKey, Model, ModelKind, Parameter, ParameterKind};

/// Further scalars that make a model glossier (1) or rougher (-1).
const ALSO: [(&str, f64); 3] = [("b", 1.0), ("metallic", 1.0), ("sigma", -1.0)];
/// Colours that are strengths of highlights (1) or of what is below them (-1).
const STRENGTHS: [(&str, f64); 9] = [
    ("a", 1.0),
    ("albedo", -1.0),
    ("alpha", -1.0),
    ("base_color", -0.5),
    ("diffuse", -1.0),
    ("f0", 1.0),
    ("rho_d", -1.0),
    ("rho_s", 1.0),
    ("specular", 1.0),
];
/// Colours of which a larger red and a smaller blue is warmer (1), or cooler (-1).
const COLOURS: [(&str, f64); 10] = [
    ("a", 1.0),
    ("albedo", 1.0),
    ("base_color", 1.0),
    ("diffuse", 1.0),
    ("eta", -1.0),
    ("f0", 1.0),
    ("k", 1.0),
    ("rho_d", 1.0),
    ("rho_s", 1.0),
    ("specular", 1.0),
];
/// Step towards glossier from which a model without a highlight becomes one under a coat.
const COAT: f64 = 0.1;
/// Change of a scalar at a step of 1, as a share of its range.
const GLOSS_STEP: f64 = 0.3;
/// Change of log2 of a strength at a step of 1.
const STRENGTH_STEP: f64 = 3.0;
/// Change of log2 of red, green and blue at a step of 1.
const WARM_STEP: [f64; 3] = [1.6, 0.3, -2.2];

/// Moves the parameters of the models that are not locked by a step in each direction.
pub(super) fn step(
    layers: &mut [Model],
    (toward, amount): (Toward, f32),
    key: BirthKey,
    locked: &LockedLayers,
) {
    let (gloss, warmth) = (f64::from(toward.gloss), f64::from(toward.warmth));
    if amount <= 0.0 || toward.gloss == 0 && toward.warmth == 0 {
        return;
    }
    let mut stream = Stream::new(key, Operator::Toward);
    for (layer, model) in layers.iter_mut().enumerate() {
        let mut step = || Toward::step(amount, key.attempt, &mut stream);
        let (gloss, warmth) = (gloss * step(), warmth * step());
        // A matt base gets a coat, unless the step is small.
        let is_matt = gloss >= COAT && !has_highlight(model);
        if is_matt && !locked.locks_kind(layer) {
            *model = converted(model, ModelKind::Coated);
        }
        let mut values = model.parameter_values().to_vec();
        let mut at = 0;
        for (parameter, own) in model.parameters() {
            let free: Vec<bool> =
                (at..at + own.len()).map(|at| !locked.locks_value(layer, at)).collect();
            let new = &mut values[at..][..own.len()];
            match parameter.kind {
                ParameterKind::Scalar { .. } => {
                    let change =
                        GLOSS_STEP * gloss * (gloss_sign(parameter) + sign(&ALSO, parameter));
                    if free[0] && change != 0.0 {
                        let share = (parameter.share(own[0]) + change).clamp(0.0, 1.0);
                        new[0] = parameter.at_share(share);
                    }
                }
                ParameterKind::Color { .. } => {
                    let strength = STRENGTH_STEP * gloss * sign(&STRENGTHS, parameter);
                    let warmth = warmth * sign(&COLOURS, parameter);
                    let change = WARM_STEP.map(|step| strength + warmth * step);
                    multiply(new, change, parameter.range, &free);
                }
                // Only effects have colours of displays.
                ParameterKind::Choice { .. } | ParameterKind::DisplayColor { .. } => {}
            }
            at += own.len();
        }
        *model = with_values(model, &values);
    }
}

/// True if a scalar of the model forms a highlight.
fn has_highlight(model: &Model) -> bool {
    model.parameters().any(|(parameter, _)| gloss_sign(parameter) != 0.0)
}

fn sign(of: &[(&str, f64)], parameter: &Parameter) -> f64 {
    of.iter().find(|(name, _)| *name == parameter.name).map_or(0.0, |(_, sign)| *sign)
}

/// Multiplies the free channels by 2^`change`, or by less if one would exceed its range, so that
/// the hue changes as it should.
fn multiply(new: &mut [f64], change: [f64; 3], (low, high): (f64, f64), free: &[bool]) {
    if change == [0.0; 3] {
        return;
    }
    let wanted = |at: usize, old: f64| if free[at] { old * libm::exp2(change[at]) } else { old };
    let largest = (0..3).map(|at| wanted(at, new[at])).fold(0.0, f64::max);
    let factor = if largest > high { high / largest } else { 1.0 };
    for at in (0..3).filter(|at| free[*at]) {
        new[at] = (factor * wanted(at, new[at])).clamp(low, high);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_names_are_parameters() {
        let all: Vec<&Parameter> =
            ModelKind::ALL.into_iter().flat_map(|kind| kind.parameters()).collect();
        for (name, _) in ALSO {
            let is_scalar = |one: &&&Parameter| one.count() == 1 && one.words().is_none();
            assert!(all.iter().filter(is_scalar).any(|one| one.name == name), "{name}");
        }
        for (name, _) in STRENGTHS.iter().chain(&COLOURS) {
            assert!(all.iter().any(|one| one.count() == 3 && one.name == *name), "{name}");
        }
    }

    #[test]
    fn hue_is_the_same_if_a_channel_reaches_its_range() {
        let mut free = [0.4, 0.2, 0.1];
        multiply(&mut free, [2.0; 3], (0.0, 1.0), &[true; 3]);
        assert_eq!(free, [1.0, 0.5, 0.25]);
        let mut locked = [0.4, 0.2, 0.1];
        multiply(&mut locked, [2.0; 3], (0.0, 1.0), &[false, true, true]);
        assert_eq!(locked, [0.4, 0.8, 0.4]);
    }
}
