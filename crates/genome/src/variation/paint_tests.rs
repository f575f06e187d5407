//! Children of painted genomes are valid, keep what is locked, and differ more at larger amounts.

use super::super::Variation;
use crate::oklab::Oklab;
use crate::{
    BirthKey, Effect, EffectKind, EffectLock, Genome, Locks, PALETTE_MAX, PALETTE_MIN, Palette,
    Start,
};

fn key(seed: u64, slot: u32) -> BirthKey {
    BirthKey { seed, slot, attempt: 0 }
}

fn random(seed: u64) -> Genome {
    Variation::random(Start::Painted.dialect()).with_start(Start::Painted).birth(key(seed, 0))
}

fn palette(genome: &Genome) -> &Palette {
    genome.effects()[0].palette().unwrap()
}

fn lightness(genome: &Genome) -> Vec<f64> {
    palette(genome).colors().iter().map(|codes| Oklab::of_codes(*codes).lightness).collect()
}

fn range(genome: &Genome) -> (f64, f64) {
    let all = lightness(genome);
    all.iter().fold((1.0, 0.0), |(low, high), one| (one.min(low), one.max(high)))
}

/// Checks what constructors do not: they have already checked edges, thresholds and ranges.
fn check(genome: &Genome, parent: &str) {
    let text = genome.to_string();
    assert_eq!(text.parse::<Genome>().unwrap(), *genome, "{text}");
    assert!(genome.is_painted() && genome.layers().is_empty());
    let (low, high) = range(genome);
    assert!(high - low > 0.38, "range of lightness {low} to {high}\n{text}of\n{parent}");
    let colors = palette(genome).colors().len();
    assert!((PALETTE_MIN..=PALETTE_MAX).contains(&colors));
}

/// Difference of two genomes: of the colours of the palettes in Oklab, of numbers as shares of
/// their ranges, and 1 for each other difference.
fn difference(one: &Genome, other: &Genome) -> f64 {
    let find = |genome: &Genome, kind| {
        genome.effects().iter().find(|effect| effect.kind() == kind).cloned()
    };
    let color = |one: &[u8; 3], other: &[u8; 3]| {
        let (one, other) = (Oklab::of_codes(*one), Oklab::of_codes(*other));
        let parts = [one.lightness - other.lightness, one.a - other.a, one.b - other.b];
        parts.iter().map(|part| part * part).sum::<f64>().sqrt()
    };
    let (own, theirs) = (palette(one), palette(other));
    let mut sum = own.colors().iter().zip(theirs.colors()).map(|(a, b)| color(a, b)).sum::<f64>();
    sum += own.colors().len().abs_diff(theirs.colors().len()) as f64;
    for kind in EffectKind::ALL {
        sum += match (find(one, kind), find(other, kind)) {
            (Some(one), Some(other)) => {
                let values = one.values().values().iter().zip(other.values().values());
                values.map(|(a, b)| (a - b).abs().min(1.0)).sum()
            }
            (None, None) => 0.0,
            _ => 1.0,
        };
    }
    sum
}

#[test]
fn random_genomes_are_painted_varied_and_the_same_for_a_key() {
    let genomes: Vec<Genome> = (0..400).map(random).collect();
    for genome in &genomes {
        check(genome, "nothing");
        assert!(genome.dialect().length == 0 && genome.instructions().is_empty());
        assert!(lightness(genome).is_sorted(), "{genome}");
        assert!(palette(genome).colors().len() <= 4);
    }
    assert_eq!(random(7), genomes[7]);
    let count = |kind| {
        let has = |genome: &&Genome| genome.effects().iter().any(|effect| effect.kind() == kind);
        genomes.iter().filter(has).count()
    };
    assert!((250..310).contains(&count(EffectKind::Silhouette)));
    assert!((210..270).contains(&count(EffectKind::Highlight)));
    assert!((40..85).contains(&count(EffectKind::Distance)));
}

#[test]
fn mutants_are_valid_and_differ_at_any_amount() {
    for seed in 0..60 {
        let parent = random(seed);
        let text = parent.to_string();
        for mutation in [0.01, 0.1, 0.3, 0.5, 1.0] {
            for slot in 0..10 {
                let child = Variation::mutate(&parent, mutation).birth(key(seed, slot));
                check(&child, &text);
                assert_ne!(child, parent, "seed {seed}, mutation {mutation}\n{text}");
                let again = Variation::mutate(&parent, mutation).birth(key(seed, slot));
                assert_eq!(child, again);
            }
        }
    }
}

#[test]
fn difference_from_the_parent_grows_with_the_amount() {
    let mean = |mutation: f32| {
        let of_seed = |seed| {
            let parent = random(seed);
            let children = (0..10).map(|slot| {
                difference(&parent, &Variation::mutate(&parent, mutation).birth(key(seed, slot)))
            });
            children.sum::<f64>()
        };
        (0..60).map(of_seed).sum::<f64>() / 600.0
    };
    let means: Vec<f64> = [0.02, 0.1, 0.2, 0.3, 0.5, 0.75, 1.0].map(mean).to_vec();
    assert!(means.windows(2).all(|pair| pair[0] * 1.15 < pair[1]), "{means:?}");
    assert!(means[0] < 0.2, "{means:?}");
}

#[test]
fn lightness_does_not_drift_over_generations() {
    let middle = |genome: &Genome| {
        let (low, high) = range(genome);
        0.5 * (low + high)
    };
    let mut genomes: Vec<Genome> = (0..300).map(random).collect();
    let mean = |genomes: &[Genome]| genomes.iter().map(middle).sum::<f64>() / genomes.len() as f64;
    let start = mean(&genomes);
    let mut means = vec![start];
    for generation in 0..10 {
        for (genome, slot) in genomes.iter_mut().zip(0..) {
            *genome = Variation::mutate(genome, 0.3).birth(key(generation, slot));
        }
        means.push(mean(&genomes));
    }
    assert!(means.iter().all(|mean| (mean - start).abs() < 0.03), "{means:?}");
}

#[test]
fn palettes_keep_their_bands() {
    let text = "brood 1\n.effect light\npalette #202020 #d0d0d0 #505050 #f0f0f0\n";
    let parent: Genome = text.parse().unwrap();
    let mut kept = 0;
    for slot in 0..50 {
        let child = Variation::mutate(&parent, 0.3).birth(key(3, slot));
        check(&child, text);
        let own = lightness(&child);
        if own.len() == 4 {
            kept += 1;
            assert!(own[0] <= own[2] && own[2] <= own[1] && own[1] <= own[3], "{child}");
        }
    }
    assert!(kept > 25, "{kept}");
}

#[test]
fn crossover_takes_whole_parts_of_both_parents() {
    let mut mixed = 0;
    for seed in 0..100 {
        let (first, second) = (random(2 * seed), random(2 * seed + 1));
        let child =
            |share, slot| Variation::crossover(&first, &second, share, 0.0).birth(key(seed, slot));
        assert_eq!(child(0.0, 0), first);
        assert!(difference(&child(1.0, 0), &second) < 1e-12, "{first}\n{second}");
        for slot in 0..4 {
            let child = child(0.5, slot);
            check(&child, &first.to_string());
            let palettes = [palette(&first), palette(&second)];
            assert!(palettes.contains(&palette(&child)));
            for effect in child.effects() {
                let mut parents = first.effects().iter().chain(second.effects());
                let is_own = |other: &Effect| {
                    other.kind() == effect.kind() && other.values() == effect.values()
                };
                assert!(parents.any(is_own), "{child}");
            }
            mixed += u32::from(child != first && child != second);
        }
    }
    assert!(mixed > 390, "{mixed}");
}

#[test]
fn locked_parts_stay() {
    let part = |effect, name: &str| EffectLock { effect, name: name.to_owned() };
    let find = |genome: &Genome, kind| {
        genome.effects().iter().find(|effect| effect.kind() == kind).cloned()
    };
    for seed in 0..80 {
        let (first, second) = (random(seed), random(seed + 1000));
        let mut locks = Locks {
            effect_parameters: vec![
                part(EffectKind::Light, Palette::COLORS),
                part(EffectKind::Light, "to"),
            ],
            ..Locks::default()
        };
        for kind in [EffectKind::Silhouette, EffectKind::Highlight] {
            locks.effects.extend(find(&first, kind).map(|_| kind));
        }
        locks.validate_for(&first).unwrap();
        let mutate = Variation::mutate(&first, 1.0).with_locks(Some(&locks));
        let cross = Variation::crossover(&first, &second, 0.5, 0.5).with_locks(Some(&locks));
        for slot in 0..6 {
            for child in [mutate.birth(key(seed, slot)), cross.birth(key(seed, slot))] {
                assert_eq!(palette(&child).colors(), palette(&first).colors());
                let to = |genome: &Genome| genome.effects()[0].scalar("to");
                assert!((to(&child) - to(&first)).abs() < 1e-12);
                for kind in &locks.effects {
                    assert_eq!(find(&child, *kind), find(&first, *kind));
                }
            }
            assert_ne!(mutate.birth(key(seed, slot)), first, "{first}");
        }
    }
}

#[test]
fn locks_of_missing_effects_are_rejected_with_a_pointer() {
    let parent: Genome = "brood 1\n.effect light\n".parse().unwrap();
    let refused = |json: &str| {
        let locks: Locks = serde_json::from_str(json).unwrap();
        let error = locks.validate_for(&parent).unwrap_err();
        (error.pointer(), error.to_string())
    };
    let (pointer, words) = refused(r#"{"effects": ["light", "highlight"]}"#);
    assert_eq!(pointer, "/effects/1");
    assert_eq!(words, "the parent has no effect highlight");
    let (pointer, words) =
        refused(r#"{"effect_parameters": [{"effect": "light", "name": "width"}]}"#);
    assert_eq!(pointer, "/effect_parameters/0/name");
    assert_eq!(words, "the effect light has no parameter \"width\"");
    assert_eq!(refused(r#"{"channels": ["r"]}"#).0, "/channels");
}
