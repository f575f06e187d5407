//! Children bred within the colours of a painting.

use std::collections::HashSet;

use super::super::Variation;
use crate::oklab::Oklab;
use crate::{
    BirthKey, Effect, EffectKind, EffectLock, Genome, Locks, PaintingPalette, PaintingRegion,
    Palette, Start, Stream,
};

fn key(seed: u64, slot: u32) -> BirthKey {
    BirthKey { seed, slot, attempt: 0 }
}

fn random_start() -> Variation<'static> {
    Variation::random(Start::Painted.dialect()).with_start(Start::Painted)
}

/// Painting of one to six regions of random hues, some grey, some of one lightness.
fn painting(seed: u64) -> PaintingPalette {
    let mut stream = Stream::new(key(seed, 0), crate::Operator::Shuffle);
    let count = 1 + stream.below(6);
    let regions = (0..count).map(|_| {
        let mut unit = || f64::from(stream.unit());
        let (hue, chroma) = (unit() * std::f64::consts::TAU, 0.2 * unit());
        let (low, high) = (0.9 * unit(), 0.9 * unit());
        let of = |share: f64| {
            let lightness = low.min(high) + (low - high).abs() * share;
            Oklab::of_hue(lightness, chroma * lightness, hue).codes()
        };
        let lightness = |codes: &[u8; 3]| Oklab::of_codes(*codes).lightness;
        let mut colors = [of(0.0), of(0.5), of(1.0)];
        colors.sort_by(|one, other| lightness(one).total_cmp(&lightness(other)));
        let [dark, middle, bright] = colors;
        PaintingRegion { dark, middle, bright, share: 0.01 + 0.99 * unit() }
    });
    PaintingPalette::new(regions.collect()).unwrap()
}

fn palette(genome: &Genome) -> &Palette {
    genome.effects()[0].palette().unwrap()
}

fn turn(one: Oklab, other: Oklab) -> f64 {
    (one.b * other.a - one.a * other.b).atan2(one.a * other.a + one.b * other.b).abs()
}

/// Values of the effects, except colours, with kind and name.
fn uncoloured(genome: &Genome) -> Vec<(EffectKind, &'static str, Vec<f64>)> {
    let values = |effect: &Effect| {
        let kind = effect.kind();
        let values = effect.values().iter().filter(|(parameter, _)| parameter.name != "color");
        let values = values.map(|(parameter, values)| (kind, parameter.name, values.to_vec()));
        values.collect::<Vec<_>>()
    };
    genome.effects().iter().flat_map(values).collect()
}

#[test]
fn children_have_hues_of_the_painting_and_show_their_shape() {
    for seed in 0..150 {
        let painting = painting(seed);
        let parent = random_start().birth(key(seed, 0));
        let from_parent = Variation::mutate(&parent, 0.3).with_painting(Some(&painting));
        let at_random = random_start().with_painting(Some(&painting));
        for (slot, variation) in (0..12).zip([from_parent, at_random].into_iter().cycle()) {
            let child = variation.birth(key(seed, slot));
            assert_eq!(child.to_string().parse::<Genome>().unwrap(), child);
            let colors: Vec<Oklab> =
                palette(&child).colors().iter().map(|codes| Oklab::of_codes(*codes)).collect();
            let lightness = colors.iter().map(|color| color.lightness);
            let (low, high) = lightness
                .fold((1.0_f64, 0.0_f64), |(low, high), one| (low.min(one), high.max(one)));
            assert!(high - low > 0.38, "seed {seed}: lightness {low} to {high}\n{child}");
            for color in colors.iter().filter(|color| color.chroma() > 0.04) {
                let mut keys = painting.regions().iter().flat_map(PaintingRegion::colors);
                let is_near = |codes| {
                    let key = Oklab::of_codes(codes);
                    turn(*color, key) < 0.15 && color.chroma() < key.chroma() + 0.02
                };
                assert!(keys.any(is_near), "seed {seed}: {color:?} in\n{child}of {painting:?}");
            }
        }
    }
}

#[test]
fn colours_that_show_the_shape_are_those_of_the_painting() {
    let region = |dark, middle, bright| PaintingRegion { dark, middle, bright, share: 0.5 };
    let one = region([0x10, 0x20, 0x50], [0x30, 0x50, 0xa0], [0xa0, 0xc0, 0xf0]);
    let other = region([0x50, 0x20, 0x08], [0xc0, 0x60, 0x20], [0xf8, 0xd8, 0x90]);
    let painting = PaintingPalette::new(vec![one, other]).unwrap();
    let parent: Genome =
        "brood 1\n.effect light\npalette #101010 #808080 #f0f0f0\n".parse().unwrap();
    let variation = Variation::mutate(&parent, 0.0).with_painting(Some(&painting));
    let mut known = Vec::new();
    for (first, second) in [(one, other), (other, one)] {
        known.push(first.colors());
        known.push([first.dark, first.middle, second.bright]);
        known.push([first.dark, second.middle, second.bright]);
    }
    let mut seen = vec![0; known.len()];
    for slot in 0..200 {
        let child = variation.birth(key(4, slot));
        let at = known.iter().position(|known| known[..] == *palette(&child).colors());
        seen[at.unwrap_or_else(|| panic!("colours of no regions\n{child}"))] += 1;
    }
    assert!(seen.iter().all(|count| *count > 10), "{seen:?}");
}

#[test]
fn all_but_colours_varies_as_without_a_painting() {
    for seed in 0..60 {
        let painting = painting(seed);
        let (parent, other) =
            (random_start().birth(key(seed, 0)), random_start().birth(key(seed, 1)));
        for variation in [
            random_start(),
            Variation::mutate(&parent, 0.3),
            Variation::crossover(&parent, &other, 0.5, 0.2),
        ] {
            let plain = variation.birth(key(seed, 7));
            let child = variation.with_painting(Some(&painting)).birth(key(seed, 7));
            assert_eq!(uncoloured(&child), uncoloured(&plain));
            assert_eq!(palette(&child).edges(), palette(&plain).edges());
            assert_eq!(child, variation.with_painting(Some(&painting)).birth(key(seed, 7)));
        }
    }
}

#[test]
fn locked_colours_stay() {
    let text = "brood 1\n.effect light\npalette #202020 #d0d0d0 #505050 #f0f0f0\n.effect silhouette\ncolor #123456\n";
    let parent: Genome = text.parse().unwrap();
    let painting = painting(3);
    let lock = |effect, name: &str| Locks {
        effect_parameters: vec![EffectLock { effect, name: name.to_owned() }],
        ..Locks::default()
    };
    let palette_locked = lock(EffectKind::Light, Palette::COLORS);
    let color_locked = lock(EffectKind::Silhouette, "color");
    for slot in 0..30 {
        let plain = Variation::mutate(&parent, 0.3).with_locks(Some(&palette_locked));
        let painted = plain.with_painting(Some(&painting));
        assert_eq!(painted.birth(key(1, slot)), plain.birth(key(1, slot)));
        let other = Variation::mutate(&parent, 0.3).with_locks(Some(&color_locked));
        let child = other.with_painting(Some(&painting)).birth(key(1, slot));
        let mut effects = child.effects().iter();
        let silhouette = effects.find(|effect| effect.kind() == EffectKind::Silhouette).unwrap();
        let codes = silhouette.color("color").map(|value| (value * 255.0).round());
        assert_eq!(codes, [18.0, 52.0, 86.0]);
        assert_ne!(palette(&child), palette(&parent));
        // The order of lightness is that of the parent, unless the number of colours changed.
        let lightness: Vec<f64> = palette(&child)
            .colors()
            .iter()
            .map(|codes| Oklab::of_codes(*codes).lightness)
            .collect();
        if lightness.len() == 4 {
            let is_banded = lightness[0] <= lightness[2] && lightness[2] <= lightness[1];
            assert!(is_banded && lightness[1] <= lightness[3], "{child}");
        }
    }
}

#[test]
fn painting_alone_makes_children_different() {
    let painting = (0..).map(painting).find(|one| one.regions().len() > 4).unwrap();
    let parent = random_start().birth(key(5, 0));
    let still = Variation::mutate(&parent, 0.0);
    assert!(still.is_deterministic() && still.birth(key(5, 1)) == parent);
    let painted = still.with_painting(Some(&painting));
    assert!(!painted.is_deterministic());
    let children: HashSet<String> =
        (0..20).map(|slot| painted.birth(key(5, slot)).to_string()).collect();
    assert!(children.len() > 9, "{} different children of 20", children.len());
    let locks = Locks { effects: vec![EffectKind::Light], ..Locks::default() };
    assert!(painted.with_locks(Some(&locks)).is_deterministic());
    let model: Genome = "brood 1\n.model lambert\n".parse().unwrap();
    let of_brdf = Variation::mutate(&model, 0.3);
    assert_eq!(of_brdf.with_painting(Some(&painting)).birth(key(1, 1)), of_brdf.birth(key(1, 1)));
}
