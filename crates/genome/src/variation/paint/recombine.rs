//! Crossover of effects.

use crate::effect;
use crate::locks::LockedEffects;
use crate::random::{Operator, Stream};
use crate::{BirthKey, Effect, EffectImage, EffectKind, IMAGES_MAX, Palette};

/// Part of a painted genome that a child has from one of its parents.
#[derive(Clone, Copy, PartialEq)]
enum Part {
    /// Colours and edges, and the images in place of colours.
    Palette,
    /// An effect, without the palette.
    Effect(EffectKind),
}

impl Part {
    const ALL: [Self; 6] = [
        Self::Palette,
        Self::Effect(EffectKind::Light),
        Self::Effect(EffectKind::Silhouette),
        Self::Effect(EffectKind::Highlight),
        Self::Effect(EffectKind::Distance),
        Self::Effect(EffectKind::Glass),
    ];
    /// Number of parts whose draws come before that of the exchanged part.
    const DRAWN_FIRST: usize = 5;

    /// True if the parents differ in the part, and it may come from the second.
    fn can_change(self, first: &[Effect], second: &[Effect], locked: &LockedEffects) -> bool {
        match self {
            Self::Palette => {
                let is_locked = |name| locked.locks(EffectKind::Light, name);
                let is_locked = is_locked(Palette::COLORS)
                    || is_locked(Palette::EDGES)
                    || EffectKind::Light
                        .image_places()
                        .iter()
                        .any(|place| effect::is_of_palette(place.name) && is_locked(place.name));
                let is_same = palette(first) == palette(second)
                    && light_images(first, true).eq(light_images(second, true));
                !is_locked && !is_same
            }
            Self::Effect(kind) => {
                let values = |effects| find(effects, kind).map(Effect::values);
                let (is_locked, has_same_images) = match kind {
                    // The palette is another part.
                    EffectKind::Light => (
                        locked.locks_values_of(kind),
                        light_images(first, false).eq(light_images(second, false)),
                    ),
                    EffectKind::Silhouette
                    | EffectKind::Highlight
                    | EffectKind::Distance
                    | EffectKind::Glass => {
                        let images = |effects| find(effects, kind).map(Effect::images);
                        (locked.locks_any_of(kind), images(first) == images(second))
                    }
                };
                let is_same = has_same_images && values(first) == values(second);
                !is_locked && !is_same
            }
        }
    }
}

/// Takes each part from the second parent with probability `share`, in the first's order of
/// painting. If `share` is between 0 and 1 and the parents differ in two parts or more, the child
/// has a part of each.
pub(in super::super) fn recombine(
    (first, second): (&[Effect], &[Effect]),
    share: f32,
    key: BirthKey,
    locked: &LockedEffects,
) -> Vec<Effect> {
    let mut stream = Stream::new(key, Operator::RecombineEffects);
    let mut taken = [false; Part::ALL.len()];
    for taken in &mut taken[..Part::DRAWN_FIRST] {
        *taken = stream.chance(share);
    }
    let different: Vec<usize> = (0..Part::ALL.len())
        .filter(|at| Part::ALL[*at].can_change(first, second, locked))
        .collect();
    let exchanged = stream.below(different.len().max(1) as u32) as usize;
    for taken in &mut taken[Part::DRAWN_FIRST..] {
        *taken = stream.chance(share);
    }
    let is_mixed = different.windows(2).any(|pair| taken[pair[0]] != taken[pair[1]]);
    if !is_mixed && different.len() > 1 && share > 0.0 && share < 1.0 {
        let part = different[exchanged];
        taken[part] = !taken[part];
    }
    let takes = |part: Part| {
        let at = Part::ALL.iter().position(|one| *one == part).expect("all parts are listed");
        taken[at] && different.contains(&at)
    };
    let mut child: Vec<Effect> = first
        .iter()
        .filter_map(|own| match takes(Part::Effect(own.kind())) {
            true => find(second, own.kind()).cloned(),
            false => Some(own.clone()),
        })
        .collect();
    let more = second.iter().filter(|theirs| find(first, theirs.kind()).is_none());
    child.extend(more.filter(|theirs| takes(Part::Effect(theirs.kind()))).cloned());
    let source = if takes(Part::Palette) { second } else { first };
    let mut values = child[0].values().clone();
    if effect::are_by_brdf(first) != effect::are_by_brdf(second) {
        // Only the first's source fits the child, which has its program and layers.
        values.choose(effect::BY, first[0].word(effect::BY)).expect("it is a word of the choice");
    }
    let images = light_images(source, true).chain(light_images(&child, false));
    let images = images.copied().collect();
    let light = Effect::new(EffectKind::Light, values, palette(source).cloned());
    let light = light.and_then(|light| light.with_images(images));
    child[0] = light.expect("both parts are valid");
    keep_first_images(&mut child);
    child
}

/// Images of a light effect: those of its palette, or the others.
fn light_images(effects: &[Effect], of_palette: bool) -> impl Iterator<Item = &EffectImage> {
    let images = effects.first().map_or(&[][..], Effect::images);
    images.iter().filter(move |image| effect::is_of_palette(image.place) == of_palette)
}

/// Removes images after as many different ones as a genome can have. Two parents may have more.
fn keep_first_images(effects: &mut [Effect]) {
    let kept = effect::images_of(effects.iter());
    if kept.len() <= IMAGES_MAX {
        return;
    }
    for effect in effects {
        let mut images = effect.images().to_vec();
        images.retain(|image| kept[..IMAGES_MAX].contains(&image.image));
        let made = effect.clone().with_images(images);
        *effect = made.expect("the places are those of the effect");
    }
}

fn find(effects: &[Effect], kind: EffectKind) -> Option<&Effect> {
    effects.iter().find(|effect| effect.kind() == kind)
}

fn palette(effects: &[Effect]) -> Option<&Palette> {
    effects.first().and_then(Effect::palette)
}
