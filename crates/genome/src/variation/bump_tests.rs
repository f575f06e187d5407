//! Tests of bumps: their formats, and how they are bred.

use super::*;
use crate::{Dialect, DialectConstraints, Effect, EffectKind, Locks, Variation};

const TEXT: &str = "brood 1\n.bump strength 0.5\n.bump const C0 31.4 0 0.25 0\n\
    .bump DP3 R1, R0, C0\n.bump SIN R0, R1.x\n.model lambert\n";

fn key(seed: u64) -> BirthKey {
    BirthKey { seed, slot: 0, attempt: 0 }
}

fn genome(text: &str) -> Genome {
    text.parse().unwrap()
}

#[test]
fn text_json_and_bytes_round_trip() {
    let flat = genome("brood 1\n.model lambert\n");
    let bumps = (0..40).map(|seed| random(key(seed)));
    for genome in bumps.map(|bump| flat.clone().with_bump(Some(bump))).chain([genome(TEXT)]) {
        assert_eq!(genome.to_string().parse::<Genome>().as_ref(), Ok(&genome));
        assert_eq!(Genome::from_json(genome.to_json()).as_ref(), Ok(&genome));
        let bytes = genome.canonical_bytes();
        assert_eq!(Genome::from_canonical_bytes(&bytes).as_ref(), Ok(&genome));
        for end in flat.canonical_bytes().len()..bytes.len() {
            assert!(Genome::from_canonical_bytes(&bytes[..end]).is_err());
        }
        assert_ne!(genome.hash(), flat.hash());
        assert_eq!(genome.with_bump(None), flat);
    }
}

#[test]
fn wrong_bumps_are_rejected_with_their_place() {
    let base = "brood 1\n.model lambert\n";
    for (lines, place, reason) in [
        (".bump strength 17\n.bump MOV R0, R0\n", (3, 16), "from -16 to 16, got `17`"),
        (".bump strength x\n", (3, 16), "expected a number"),
        (".bump strength 1\n.bump strength 2\n", (4, 7), "strength is given twice"),
        (".bump strength 1\n", (3, 1), "1 to 64 instructions, got 0"),
        (".bump FOO R0, R0\n", (3, 7), "unknown opcode"),
        (".bump MOV R8, R0\n", (3, 7), "R8 does not exist in a dialect of 8 registers"),
        (".bump const C128 0 0 0 0\n", (3, 13), "expected a constant register"),
        (".bump\n", (3, 6), "expected `strength`, `const` or an instruction"),
        (".bump .model lambert\n", (3, 7), "unknown opcode"),
        (".effect silhouette\n.bump MOV R0, R0\n", (3, 1), "light"),
    ] {
        let error = format!("{base}{lines}").parse::<Genome>().unwrap_err();
        assert_eq!((error.line, error.column), place, "{lines}: {error}");
        assert!(error.reason.contains(reason), "{lines}: {error}");
    }
    let long = format!("{base}{}", ".bump MOV R0, R0\n".repeat(65));
    let error = long.parse::<Genome>().unwrap_err();
    assert_eq!(error.line, 67, "{error}");
    assert!(error.reason.contains("got 65"), "{error}");
    let painted = "brood 1\n.bump MOV R0, R0\n.effect light\n";
    let error = painted.parse::<Genome>().unwrap_err();
    assert_eq!((error.line, error.column), (2, 1), "{error}");
    let surface = "brood 1\n.dialect surface smooth registers 8\nMOV R0, R1\n";
    assert!(surface.parse::<Genome>().is_err());
}

#[test]
fn json_errors_point_at_the_value() {
    let good = genome(TEXT).to_json();
    for (path, value, pointer) in [
        ("/bump/strength", serde_json::json!(20), "/bump/strength"),
        ("/bump/instructions", serde_json::json!([]), "/bump/instructions"),
        ("/bump/instructions/1/opcode", "FOO".into(), "/bump/instructions/1/opcode"),
        ("/bump/constants/C0/1", 1e9.into(), "/bump/constants/C0/1"),
    ] {
        let mut json = good.clone();
        *json.pointer_mut(path).unwrap() = value;
        assert_eq!(Genome::from_json(json).unwrap_err().pointer, pointer);
    }
}

#[test]
fn children_have_bumps_where_they_are_asked_for() {
    let flat = genome("brood 1\n.model lambert\n");
    let bumpy = genome(TEXT);
    let constraints = |bumps| DialectConstraints { bumps, ..DialectConstraints::default() };
    let of = |parent, bumps, mutation| {
        Variation::mutate(parent, mutation).with_constraints(constraints(bumps)).birth(key(3))
    };
    assert_eq!(of(&flat, None, 0.3).bump(), None);
    assert!(of(&flat, Some(true), 0.3).bump().is_some());
    assert_eq!(of(&flat, Some(true), 0.0), flat);
    assert_eq!(of(&bumpy, Some(false), 0.3).bump(), None);
    assert_eq!(of(&bumpy, None, 0.0), bumpy);
    for start in [Variation::random(Dialect::default()), Variation::random(*flat.dialect())] {
        assert_eq!(start.birth(key(1)).bump(), None);
        assert!(start.with_constraints(constraints(Some(true))).birth(key(1)).bump().is_some());
    }
    let painted = Genome::of_effects(vec![Effect::of(EffectKind::Light)]).unwrap();
    assert_eq!(of(&painted, Some(true), 0.3).bump(), None);
    let crossed = Variation::crossover(&bumpy, &painted, 0.5, 0.3).birth(key(2));
    assert!(crossed.is_painted() && crossed.bump().is_none());
}

#[test]
fn bumps_mutate_and_cross_and_can_be_locked() {
    let bumpy = genome(TEXT);
    let waves = bumpy.clone().with_bump(Some(random(key(9))));
    for parent in [&bumpy, &waves] {
        let born = |seed| Variation::mutate(parent, 0.4).birth(key(seed));
        let changed = (0..40).filter(|seed| born(*seed).bump() != parent.bump()).count();
        assert!(changed > 30, "{changed}");
        let locks = Locks { bump: true, ..Locks::default() };
        for seed in 0..20 {
            let locked = Variation::mutate(parent, 0.9).with_locks(Some(&locks)).birth(key(seed));
            assert_eq!(locked.bump(), parent.bump());
            assert_ne!(locked.layers(), parent.layers());
        }
    }
    let flat = genome("brood 1\n.model lambert\n");
    let crossed = |share, seed| Variation::crossover(&flat, &waves, share, 0.0).birth(key(seed));
    assert_eq!(crossed(0.0, 1).bump(), None);
    assert_eq!(crossed(1.0, 1).bump(), waves.bump());
    let half = (0..200).filter(|seed| crossed(0.5, *seed).bump().is_some()).count();
    assert!((70..130).contains(&half), "{half}");
}

#[test]
fn random_bumps_have_no_seam() {
    for seed in 0..200 {
        let bump = random(key(seed));
        let mut mutated = bump.clone();
        mutate(&mut mutated, 0.5, key(seed));
        for bump in [bump, mutated] {
            for wave in &bump.program().constants()[..4] {
                let turns = wave[0] / TAU;
                assert!((turns - turns.round()).abs() < 1e-4, "{turns}");
            }
        }
    }
}
