//! Mutation of effects.

use super::palette::{self, Shift};
use super::{random, threshold, value};
use crate::effect;
use crate::locks::LockedEffects;
use crate::random::{Operator, Stream};
use crate::{BirthKey, Effect, EffectKind, Palette};

/// Probability at amount 1 that an overlay is added or removed.
const SWITCH_RATE: f64 = 0.35;
/// The same for the addition of a distance, which shows only in deep scenes.
const DISTANCE_RATE: f64 = 0.1;
/// Probability at amount 1 that two overlays change places.
const ORDER_RATE: f64 = 0.3;

/// Mutates the parts of effects that are not locked. With `force`, something changes at any amount
/// above 0 if the locks allow it.
pub(in super::super) fn mutate(
    effects: &mut Vec<Effect>,
    (amount, has_program): (f32, bool),
    (key, force): (BirthKey, bool),
    locked: &LockedEffects,
) {
    if effects.is_empty() || amount <= 0.0 {
        return;
    }
    let old = effects.clone();
    let amounts = (f64::from(amount), has_program);
    let mut stream = Stream::new(key, Operator::MutateEffects);
    let shift = Shift::draw(amounts.0, false, &mut stream);
    for effect in effects.iter_mut() {
        let mut values = effect.values().clone();
        let amounts = (amounts.0, has_brush(effect, has_program));
        value::mutate(&mut values, (effect.kind(), locked), amounts, &mut stream);
        *effect = with_values(effect, values);
        recolor(effect, (amounts.0, shift), locked, &mut stream);
    }
    switch(effects, amounts.0, locked, &mut stream);
    reorder(effects, amounts.0, locked, &mut stream);
    remove_glass(effects, amounts.0, locked, &mut stream);
    reshare_images(effects, amounts.0, locked, &mut stream);
    if force && *effects == old {
        let shift = Shift::draw(amounts.0, true, &mut stream);
        let light = &mut effects[0];
        recolor(light, (amounts.0, shift), locked, &mut stream);
        if *effects == old {
            mutate_one(effects, amounts, locked, &mut stream);
        }
    }
}

fn with_values(effect: &Effect, values: brood_brdf::ParameterValues) -> Effect {
    let made = effect.with_parts(values, effect.palette().cloned());
    made.expect("mutation keeps to the rules of effects")
}

/// True if something shifts the amount of light by the parameter `brush`.
fn has_brush(effect: &Effect, has_program: bool) -> bool {
    has_program || effect.image(effect::MAP).is_some()
}

/// Moves the shares of images.
fn reshare_images(
    effects: &mut [Effect],
    amount: f64,
    locked: &LockedEffects,
    stream: &mut Stream,
) {
    for effect in effects {
        let mut images = effect.images().to_vec();
        for image in &mut images {
            let share = threshold::reflected(image.share + value::step(amount, stream));
            if !locked.locks(effect.kind(), image.place) {
                image.share = share;
            }
        }
        let made = effect.clone().with_images(images);
        *effect = made.expect("shares are within the range");
    }
}

/// Mutates the palette or the colour of an effect.
fn recolor(
    effect: &mut Effect,
    (amount, shift): (f64, Shift),
    locked: &LockedEffects,
    stream: &mut Stream,
) {
    let kind = effect.kind();
    let Some(palette) = effect.palette() else {
        let code = |value: f64| (value * 255.0 + 0.5) as u8;
        let codes = effect.color(effect::COLOR).map(code);
        let color = shift.overlay(codes, amount, stream).map(|code| f64::from(code) / 255.0);
        if !locked.locks(kind, effect::COLOR) {
            let mut values = effect.values().clone();
            values.set(effect::COLOR, &color).expect("codes are display values");
            *effect = with_values(effect, values);
        }
        return;
    };
    let locks_colors = locked.locks(kind, Palette::COLORS);
    let locks_edges = locked.locks(kind, Palette::EDGES);
    let mut new = palette.clone();
    if !locks_colors {
        new = palette::mutate_colors(&new, (amount, shift), !locks_edges, stream);
    }
    if !locks_edges {
        new = palette::mutate_edges(&new, amount, stream);
    }
    let made = effect.with_parts(effect.values().clone(), Some(new));
    *effect = made.expect("mutation keeps to the rules of effects");
}

/// Adds and removes overlays. Glass is never added: most scenes show nothing through it.
fn switch(effects: &mut Vec<Effect>, amount: f64, locked: &LockedEffects, stream: &mut Stream) {
    let is_switched = |kind: &EffectKind| !matches!(kind, EffectKind::Light | EffectKind::Glass);
    for kind in EffectKind::ALL.into_iter().filter(is_switched) {
        let present = effects.iter().position(|effect| effect.kind() == kind);
        let is_rare = kind == EffectKind::Distance && present.is_none();
        let rate = if is_rare { DISTANCE_RATE } else { SWITCH_RATE };
        if f64::from(stream.unit()) >= rate * amount {
            continue;
        }
        match present {
            Some(at) if !locked.locks_any_of(kind) => drop(effects.remove(at)),
            Some(_) => {}
            None => {
                let palette = effects[0].palette().expect("the first effect is light").clone();
                let overlay = random::overlay(kind, &palette, stream);
                let at = 1 + stream.below(effects.len() as u32) as usize;
                effects.insert(at, overlay);
            }
        }
    }
}

/// Removes a glass effect as often as other overlays.
fn remove_glass(
    effects: &mut Vec<Effect>,
    amount: f64,
    locked: &LockedEffects,
    stream: &mut Stream,
) {
    let glass = effects.iter().position(|effect| effect.kind() == EffectKind::Glass);
    let Some(at) = glass.filter(|_| !locked.locks_any_of(EffectKind::Glass)) else { return };
    if f64::from(stream.unit()) < SWITCH_RATE * amount {
        effects.remove(at);
    }
}

/// Exchanges two neighbouring overlays.
fn reorder(effects: &mut [Effect], amount: f64, locked: &LockedEffects, stream: &mut Stream) {
    if effects.len() < 3 || f64::from(stream.unit()) >= ORDER_RATE * amount {
        return;
    }
    let at = 1 + stream.below(effects.len() as u32 - 2) as usize;
    let pair = [at, at + 1];
    if !pair.iter().any(|at| locked.locks_any_of(effects[*at].kind())) {
        effects.swap(at, at + 1);
    }
}

/// Mutates one number of one effect, if any may change.
fn mutate_one(
    effects: &mut [Effect],
    amounts: (f64, bool),
    locked: &LockedEffects,
    stream: &mut Stream,
) {
    let first = stream.below(effects.len() as u32) as usize;
    for at in (first..effects.len()).chain(0..first) {
        let effect = &effects[at];
        let mut values = effect.values().clone();
        let amounts = (amounts.0, has_brush(effect, amounts.1));
        if value::mutate_one(&mut values, (effect.kind(), locked), amounts, stream) {
            effects[at] = with_values(effect, values);
            return;
        }
    }
}
