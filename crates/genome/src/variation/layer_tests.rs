//! Layers in every form of a genome, and their mutation and crossover.

use proptest::prelude::*;

use crate::{
    BirthKey, Channel, Dialect, DialectConstraints, Genome, LAYERS_MAX, Locks, Model, ModelKind,
    Output, ParameterLock, Variation,
};

fn key(seed: u64) -> BirthKey {
    BirthKey { seed, slot: 3, attempt: 0 }
}

fn models() -> Dialect {
    Dialect { length: 0, ..Dialect::default() }
}

fn random(seed: u64) -> Genome {
    Variation::random(models()).birth(key(seed))
}

fn kinds(genome: &Genome) -> Vec<ModelKind> {
    genome.layers().iter().map(Model::kind).collect()
}

/// A program with two layers and the energy limit.
fn layered(seed: u64) -> Genome {
    let dialect = Dialect { length: 12, isotropic: true, ..Dialect::default() };
    let program = Variation::random(dialect).birth(key(seed));
    let layers = [seed, seed + 1].map(|seed| random(seed).layers()[0].clone());
    let output = Output::new([[0.5; 3]; 3], [0.25, 1.0, 2.0], [0.0; 3]).unwrap();
    let (instructions, constants) = (program.instructions().to_vec(), *program.constants());
    Genome::layered(dialect, instructions, Box::new(constants), output, layers.to_vec())
        .unwrap()
        .with_limit(true)
}

#[test]
fn mutants_differ_when_the_kind_of_their_model_changes() {
    for seed in 0..4000 {
        let parent = random(seed);
        let child = Variation::mutate(&parent, 1.0).birth(key(seed + 1));
        assert_ne!(child.hash(), parent.hash(), "{seed}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn every_form_round_trips(seed in 0..u64::MAX - 1) {
        for genome in [random(seed), layered(seed)] {
            prop_assert_eq!(genome.to_string().parse(), Ok(genome.clone()));
            let text = genome.to_json().to_string();
            prop_assert_eq!(Genome::from_json(serde_json::from_str(&text).unwrap()), Ok(genome.clone()));
            let bytes = genome.canonical_bytes();
            for end in 0..bytes.len() {
                prop_assert!(Genome::from_canonical_bytes(&bytes[..end]).is_err());
            }
            prop_assert_eq!(Genome::from_canonical_bytes(&bytes), Ok(genome));
        }
    }

    #[test]
    fn mutants_differ_and_stay_in_range(seed: u64, amount in 0.01f32..1.0) {
        let parent = random(seed);
        let child = Variation::mutate(&parent, amount).birth(key(seed ^ 1));
        // The validating constructor has checked the ranges.
        prop_assert_ne!(child.hash(), parent.hash());
        prop_assert_eq!(child.layers().len(), 1);
        prop_assert!(child.instructions().is_empty() && child.dialect().length == 0);
        let still = Variation::mutate(&parent, 0.0).birth(key(seed ^ 1));
        prop_assert_eq!(still.hash(), parent.hash());
    }

    #[test]
    fn crossover_takes_kinds_and_values_from_both_parents(seed in 0..u64::MAX - 9, share in 0.0f32..=1.0) {
        for (first, second) in [
            (random(seed), random(seed + 5)),
            (random(seed), layered(seed + 5)),
            (layered(seed), random(seed + 5)),
            (layered(seed), layered(seed + 5)),
        ] {
            let child = Variation::crossover(&first, &second, share, 0.0).birth(key(seed));
            let parents = [kinds(&first), kinds(&second)].concat();
            prop_assert!(kinds(&child).iter().all(|kind| parents.contains(kind)));
            prop_assert!(child.layers().len() <= LAYERS_MAX);
            for (parameter, found) in child.layers().iter().flat_map(Model::parameters) {
                let values = |genome: &Genome| -> Vec<f64> {
                    genome.layers().iter().filter_map(|model| model.get(parameter.name)).flatten().copied().collect()
                };
                let (low, high) = parameter.range;
                let mut known = [values(&first), values(&second)].concat();
                known.extend(parameter.default());
                known = known.into_iter().map(|value| value.clamp(low, high)).collect();
                prop_assert!(found.iter().all(|value| known.contains(value)), "{}", parameter.name);
            }
        }
    }
}

#[test]
fn crossover_with_share_zero_takes_nothing() {
    for seed in 0..50 {
        let (first, second) = (layered(seed), random(seed + 70));
        let child = Variation::crossover(&first, &second, 0.0, 0.0).birth(key(seed));
        assert_eq!(child.layers(), first.layers());
        let child = Variation::crossover(&second, &first, 0.0, 0.0).birth(key(seed));
        assert_eq!(child, second);
    }
}

#[test]
fn crossover_combines_programs_and_models() {
    let (first, second) = (random(1), layered(2));
    let children: Vec<Genome> = (0..60)
        .map(|seed| Variation::crossover(&first, &second, 0.5, 0.1).birth(key(seed)))
        .collect();
    let with_program = children.iter().filter(|child| !child.instructions().is_empty()).count();
    assert!((15..45).contains(&with_program), "{with_program}");
    let more = children.iter().filter(|child| child.layers().len() > 1).count();
    assert!((15..45).contains(&more), "{more}");
    assert!(children.iter().all(|child| !child.layers().is_empty()));
}

#[test]
fn locked_layers_and_parameters_stay() {
    let (parent, other) = (layered(4), layered(8));
    let name = parent.layers()[1].kind().parameters()[0].name;
    let lock = ParameterLock { layer: 1, name: name.to_owned() };
    let locks = Locks { layers: vec![0], parameters: vec![lock], ..Locks::default() };
    let channel = Locks { channels: vec![Channel::Green], ..Locks::default() };
    for seed in 0..200 {
        let child = |locks| {
            Variation::crossover(&parent, &other, 0.5, 1.0).with_locks(Some(locks)).birth(key(seed))
        };
        let locked = child(&locks);
        assert_eq!(locked.layers()[0], parent.layers()[0]);
        assert_eq!(locked.layers()[1].get(name), parent.layers()[1].get(name));
        let locked = child(&channel);
        assert_eq!(kinds(&locked), kinds(&parent));
        for (model, own) in locked.layers().iter().zip(parent.layers()) {
            for ((_, values), (_, own)) in model.parameters().zip(own.parameters()) {
                match values.len() {
                    3 => assert!(values[1].to_bits() == own[1].to_bits()),
                    _ => assert_eq!(values, own),
                }
            }
        }
    }
    let beyond = Locks { layers: vec![2], ..Locks::default() };
    assert_eq!(beyond.validate_for(&parent).unwrap_err().pointer(), "/layers/0");
    let lock = ParameterLock { layer: 0, name: "shine".to_owned() };
    let unknown = Locks { parameters: vec![lock], ..Locks::default() };
    let error = unknown.validate_for(&parent).unwrap_err();
    assert_eq!(error.pointer(), "/parameters/0/name");
    assert_eq!(error.to_string(), "the model of layer 0 has no parameter \"shine\"");
}

#[test]
fn constraints_leave_the_values_and_set_the_switch() {
    let parent = random(3);
    let constraints = DialectConstraints { isotropic: Some(true), homogeneous: None, bumps: None };
    let child = Variation::mutate(&parent, 0.0).with_constraints(constraints).birth(key(1));
    assert!(child.dialect().isotropic);
    assert_eq!(child.layers(), parent.layers());
    assert_eq!(child.to_string().parse(), Ok(child.clone()), "{child}");
}

#[test]
fn random_models_include_every_kind() {
    let mut seen: Vec<ModelKind> = (0..300).flat_map(|seed| kinds(&random(seed))).collect();
    seen.sort();
    seen.dedup();
    assert_eq!(seen, ModelKind::ALL);
}

#[test]
fn invalid_texts_are_rejected_with_the_position() {
    let error = |text: &str| text.parse::<Genome>().unwrap_err().to_string();
    assert_eq!(
        error("brood 1\n\n.model gold").split(';').next(),
        Some("line 3, column 8: unknown model `gold`")
    );
    let head = "brood 1\n.model ward # shiny\n";
    assert!(error(&format!("{head}shine 1")).starts_with(
        "line 3, column 1: ward has no parameter `shine`; it has diffuse, specular, alpha_x"
    ));
    assert_eq!(
        error(&format!("{head}\n alpha_x 3")),
        "line 4, column 10: alpha_x must be between 0.001 and 1, got 3"
    );
    assert_eq!(
        error(&format!("{head}alpha_x 0.1\nalpha_x 0.2")),
        "line 4, column 1: alpha_x is given twice"
    );
    assert_eq!(error(&format!("{head}form")), "line 3, column 1: form takes one word, not 0");
    let five = ".model lambert\n".repeat(5);
    assert_eq!(
        error(&format!("brood 1\n{five}")),
        "line 6, column 1: a genome can have at most 4 models"
    );
    assert!(error(&format!("{head}ADD R0, R1, R2")).contains("`.dialect ...` must come before"));
    let long = format!("{head}alpha_x {}", "x".repeat(2000));
    assert!(error(&long).len() < 300);
    let json = serde_json::json!({
        "brood": 1, "dialect": {"length": 0},
        "layers": [{"model": "ward", "parameters": {"alpha_x": 3}}],
    });
    let error = Genome::from_json(json).unwrap_err();
    assert_eq!(error.pointer, "/layers/0/parameters/alpha_x");
}
