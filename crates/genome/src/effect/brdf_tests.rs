//! Genomes whose light effect is `by brdf`.

use super::*;
use crate::{
    BirthKey, Dialect, Genome, GenomeError, Locks, OpcodeSet, Output, ParameterLock, Variation,
};

const EFFECTS: &str = "\
.effect light
palette #2b1e46 #a0405a #f2a65a
by brdf
from 0.1
to 0.7
.effect silhouette
color #1a1020
";

fn key(seed: u64) -> BirthKey {
    BirthKey { seed, slot: 0, attempt: 0 }
}

fn effects() -> Vec<Effect> {
    let text = format!("brood 1\n.model lambert\n{EFFECTS}");
    text.parse::<Genome>().unwrap().effects().to_vec()
}

/// Random program with models, an output stage, an energy limit and effects.
fn genome(seed: u64) -> Genome {
    let dialect = Dialect { length: 20, ..Dialect::default() };
    let program = Variation::random(dialect).birth(key(seed));
    let models = "brood 1\n.model lambert\n.model conductor\nroughness 0.3\n";
    let layers = models.parse::<Genome>().unwrap().layers().to_vec();
    let (instructions, constants) = (program.instructions().to_vec(), *program.constants());
    let output = Output::saturation(0.5).unwrap();
    let brdf = Genome::layered(dialect, instructions, Box::new(constants), output, layers).unwrap();
    brdf.with_limit(true).with_effects(effects()).unwrap()
}

#[test]
fn text_json_and_bytes_round_trip() {
    for seed in 0..20 {
        let own = genome(seed);
        assert!(own.is_painted() && own.is_by_brdf() && own.has_brdf() && own.is_limited());
        let grey = own.clone().with_output(Output::saturation(0.0).unwrap()).with_limit(false);
        let program = Variation::random(Dialect::default()).birth(key(seed));
        let alone = program.with_effects(effects()).unwrap();
        for genome in [own, grey, alone] {
            let bytes = genome.canonical_bytes();
            let again: [Genome; 3] = [
                genome.to_string().parse().unwrap(),
                Genome::from_json(genome.to_json()).unwrap(),
                Genome::from_canonical_bytes(&bytes).unwrap(),
            ];
            for again in again {
                assert_eq!(again.canonical_bytes(), bytes);
                assert_eq!(again, genome);
            }
        }
    }
}

#[test]
fn parts_are_read_in_any_order() {
    let before: Genome = format!("brood 1\n.model lambert\n{EFFECTS}").parse().unwrap();
    let after: Genome = format!("brood 1\n{EFFECTS}.limit on\n.model lambert\n").parse().unwrap();
    assert_eq!(after, before.with_limit(true));
}

#[test]
fn texts_without_a_brdf_are_refused() {
    let error = |text: &str| text.parse::<Genome>().expect_err(text).to_string();
    let cases = [
        (".effect light\nfeather 0.2\nby brdf", "line 4, column 4: `by brdf` needs a BRDF"),
        (
            ".effect light\nby facing\n.model lambert",
            "line 4, column 1: a genome with effects has no .model line, unless `by brdf`",
        ),
        (
            ".limit on\n.effect light\nby light",
            "line 3, column 1: a genome with a .limit line has no effects, unless `by brdf`",
        ),
        (
            ".dialect directed smooth registers 12\n.effect light\nby brdf\nMOV R0, R10",
            "line 5, column 1: the opcode set `directed` is for genomes with effects that are not",
        ),
    ];
    for (text, expected) in cases {
        let found = error(&format!("brood 1\n{text}\n"));
        assert!(found.starts_with(expected), "{text}: {found}");
    }
}

#[test]
fn json_without_a_brdf_is_refused_at_the_value() {
    let pointer = |parts: &str| {
        let light = r#"{"kind": "light", "parameters": {"by": "brdf"}}"#;
        let text = format!(r#"{{"brood": 1, {parts}, "effects": [{light}]}}"#);
        Genome::from_json(serde_json::from_str(&text).unwrap()).map_err(|error| error.pointer)
    };
    let models = r#""dialect": {"length": 0}, "limit": true, "layers": [{"model": "lambert"}]"#;
    assert!(pointer(models).unwrap().is_by_brdf());
    let none = pointer(r#""dialect": {"length": 0}"#);
    assert_eq!(none.unwrap_err(), "/effects/0/parameters/by");
    let directed = r#""dialect": {"length": 0, "opcodes": "directed", "registers": 12}"#;
    assert_eq!(pointer(directed).unwrap_err(), "/dialect");
}

#[test]
fn parts_that_do_not_belong_together_are_refused() {
    let lambert: Genome = "brood 1\n.model lambert\n".parse().unwrap();
    let toon: Genome = "brood 1\n.effect light\n".parse().unwrap();
    let refused = |genome: Genome, effects: Vec<Effect>| genome.with_effects(effects).unwrap_err();
    let by_light = refused(lambert.clone(), toon.effects().to_vec());
    assert_eq!(by_light, GenomeError::Effects(EffectsError::NotByBrdf));
    let twice = [effects(), effects()].concat();
    let light = GenomeError::Effects(EffectsError::Twice(EffectKind::Light));
    assert_eq!(refused(lambert, twice), light);
    assert_eq!(refused(toon, effects()), GenomeError::Effects(EffectsError::NoBrdf));
    let directed = Dialect { opcodes: OpcodeSet::Directed, registers: 12, ..Dialect::default() };
    let painted = Genome::painted(directed, Vec::new(), Box::new([[0.0; 4]; 128]), effects());
    assert!(matches!(painted, Err(GenomeError::Dialect(_))), "{painted:?}");
}

#[test]
fn bytes_of_a_brdf_need_its_effects_by_brdf() {
    let genome = genome(1);
    let bytes = genome.canonical_bytes();
    // The choice `by` is the third value of the light effect.
    let brdf = 2f64.to_bits().to_le_bytes();
    let places = (0..bytes.len() - 8).filter(|at| bytes[*at..*at + 8] == brdf);
    let results: Vec<_> = places
        .map(|at| {
            let mut bytes = bytes.clone();
            bytes[at..at + 8].copy_from_slice(&1f64.to_bits().to_le_bytes());
            Genome::from_canonical_bytes(&bytes)
        })
        .collect();
    let refused = GenomeError::from(EffectsError::NotByBrdf).into();
    assert!(results.contains(&Err(refused)), "{results:?}");
}

#[test]
fn children_keep_a_brdf_and_change_both_halves() {
    let program = |genome: &Genome| (genome.instructions().to_vec(), *genome.constants());
    let (mut strong, mut changed) = (0, [0; 3]);
    for seed in 0..300 {
        let (first, second) = (genome(seed), genome(seed + 1000));
        let mutation = (seed % 10) as f32 / 10.0;
        let mutant = Variation::mutate(&first, mutation).birth(key(seed));
        let crossed = Variation::crossover(&first, &second, 0.5, mutation).birth(key(seed));
        for child in [&mutant, &crossed] {
            assert!(child.is_by_brdf() && child.is_limited(), "{seed}");
            assert_eq!(child.output(), first.output(), "{seed}");
            let bytes = child.canonical_bytes();
            assert_eq!(Genome::from_canonical_bytes(&bytes).as_ref(), Ok(child), "{seed}");
        }
        if mutation >= 0.5 {
            strong += 1;
            changed[0] += u32::from(mutant.effects() != first.effects());
            changed[1] += u32::from(program(&mutant) != program(&first));
            changed[2] += u32::from(mutant.layers() != first.layers());
        }
        let taken = |one: &Genome, other: &Genome| one.instructions() != other.instructions();
        assert!(taken(&crossed, &first) && taken(&crossed, &second), "{seed}");
    }
    assert_eq!(strong, 150);
    assert!(changed.iter().all(|count| *count > 140), "{changed:?}");
}

#[test]
fn children_mutate_as_those_of_the_brdf_alone() {
    for seed in 0..20 {
        let painted = genome(seed);
        let brdf = Genome::layered(
            *painted.dialect(),
            painted.instructions().to_vec(),
            Box::new(*painted.constants()),
            *painted.output(),
            painted.layers().to_vec(),
        );
        let (brdf, amount) = (brdf.unwrap().with_limit(true), 0.3);
        let child = Variation::mutate(&brdf, amount).birth(key(seed));
        let effects = Variation::mutate(&painted, amount).birth(key(seed)).effects().to_vec();
        let expected = child.with_effects(effects).unwrap();
        assert_eq!(Variation::mutate(&painted, amount).birth(key(seed)), expected, "{seed}");
    }
}

#[test]
fn parents_by_other_sources_cross_effects_alone() {
    let by_brdf = genome(3);
    let light = Genome::of_effects(vec![Effect::of(EffectKind::Light)]).unwrap();
    for seed in 0..100 {
        let child = Variation::crossover(&by_brdf, &light, 0.5, 0.0).birth(key(seed));
        assert!(child.is_by_brdf());
        assert_eq!(child.instructions(), by_brdf.instructions());
        assert_eq!(child.layers(), by_brdf.layers());
        let child = Variation::crossover(&light, &by_brdf, 0.5, 0.3).birth(key(seed));
        assert!(child.is_painted() && !child.has_brdf());
        assert!(child.instructions().is_empty() && child.layers().is_empty());
    }
}

#[test]
fn mutation_does_not_change_to_or_from_a_brdf() {
    let light = Genome::of_effects(vec![Effect::of(EffectKind::Light)]).unwrap();
    let mut facing = 0;
    for seed in 0..400 {
        assert!(Variation::mutate(&genome(3), 1.0).birth(key(seed)).is_by_brdf());
        let child = Variation::mutate(&light, 1.0).birth(key(seed));
        assert!(!child.is_by_brdf());
        facing += usize::from(child.effects()[0].word(BY) == "facing");
    }
    assert!((20..70).contains(&facing), "{facing}");
}

#[test]
fn locks_act_on_both_halves() {
    let parent = genome(5);
    let locks = Locks {
        instructions: (0..20).collect(),
        layers: vec![0],
        parameters: vec![ParameterLock { layer: 1, name: "roughness".to_owned() }],
        effects: vec![EffectKind::Light],
        channels: Vec::new(),
        ..Locks::default()
    };
    locks.validate_for(&parent).unwrap();
    for seed in 0..100 {
        let child = Variation::mutate(&parent, 0.8).with_locks(Some(&locks)).birth(key(seed));
        assert_eq!(child.instructions(), parent.instructions());
        assert_eq!(child.layers()[0], parent.layers()[0]);
        assert_eq!(child.layers()[1].get("roughness"), parent.layers()[1].get("roughness"));
        assert_eq!(child.effects()[0], parent.effects()[0]);
    }
    let channels = Locks { channels: vec![crate::Channel::Red], ..Locks::default() };
    channels.validate_for(&parent).unwrap();
    let child = Variation::mutate(&parent, 0.8).with_locks(Some(&channels)).birth(key(1));
    assert!(child.is_by_brdf());
}

#[test]
fn a_brdf_and_a_painted_parent_make_toon_shapes() {
    let dialect = Dialect { length: 20, ..Dialect::default() };
    let painted = "brood 1\n.effect light\npalette #203040 #c0d0a0\nfrom -0.4\nto 0.9\n\
                   .effect silhouette\ncolor #102030\n";
    let painted: Genome = painted.parse().unwrap();
    let mut changed = 0;
    for seed in 0..50 {
        let brdf = Variation::random(dialect).birth(key(seed)).with_limit(true);
        for (first, second) in [(&brdf, &painted), (&painted, &brdf)] {
            let still = Variation::crossover(first, second, 0.5, 0.0);
            assert!(still.is_deterministic());
            let toon = still.birth(key(seed));
            assert!(toon.is_by_brdf() && toon.is_limited());
            assert_eq!(toon.instructions(), brdf.instructions());
            assert_eq!(toon.effects()[0].palette(), painted.effects()[0].palette());
            assert_eq!(toon.effects()[1], painted.effects()[1]);
            let child = Variation::crossover(first, second, 0.5, 0.4).birth(key(seed));
            assert!(child.is_by_brdf());
            assert_eq!(child, Variation::mutate(&toon, 0.4).birth(key(seed)));
        }
        let locks = Locks { effects: vec![EffectKind::Light], ..Locks::default() };
        let locked = Variation::crossover(&painted, &brdf, 0.5, 0.8).with_locks(Some(&locks));
        let child = locked.birth(key(seed));
        assert_eq!(child.effects()[0].palette(), painted.effects()[0].palette());
        changed += u32::from(child.instructions() != brdf.instructions());
        let locks = Locks { instructions: (0..20).collect(), ..Locks::default() };
        let locked = Variation::crossover(&brdf, &painted, 0.5, 0.8).with_locks(Some(&locks));
        assert_eq!(locked.birth(key(seed)).instructions(), brdf.instructions());
        // A parent that paints a BRDF of its own is crossed with the other, painted alike.
        let toon = genome(seed + 1000);
        let crossed = Variation::crossover(&brdf, &toon, 0.5, 0.2);
        assert!(!crossed.is_deterministic());
        let child = crossed.birth(key(seed));
        assert!(child.is_by_brdf() && child.instructions() != brdf.instructions());
    }
    assert!(changed > 40, "{changed}");
}
