//! Guarantees of the operators: determinism, closure, shares of the parents, effect growing with
//! the amount.

use super::*;
use crate::{CONSTANTS, OpcodeSet};

fn key(slot: u32) -> BirthKey {
    BirthKey { seed: 11, slot, attempt: 0 }
}

fn parent(slot: u32) -> Genome {
    Variation::random(Dialect::default()).birth(key(slot))
}

fn differing(a: &Genome, b: &Genome) -> usize {
    a.instructions().iter().zip(b.instructions()).filter(|(a, b)| a != b).count()
}

#[test]
fn birth_gives_the_same_child_when_the_key_is_the_same() {
    let (a, b) = (parent(0), parent(1));
    let variation = Variation::crossover(&a, &b, 0.5, 0.3);
    assert_eq!(variation.birth(key(3)), variation.birth(key(3)));
    assert_ne!(variation.birth(key(3)), variation.birth(key(4)));
}

#[test]
fn children_are_equal_when_nothing_is_random() {
    let (a, b) = (parent(0), parent(1));
    let models = Dialect { length: 0, ..Dialect::default() };
    let models: Vec<_> = (0..40).map(|slot| Variation::random(models).birth(key(slot))).collect();
    let model = &models[0];
    let kind = model.layers()[0].kind();
    let of_kind = |same: bool| {
        models[1..].iter().find(|other| (other.layers()[0].kind() == kind) == same).unwrap()
    };
    let cross = Variation::crossover;
    for (variation, settled) in [
        (Variation::random(Dialect::default()), false),
        (Variation::mutate(&a, 0.0), true),
        (Variation::mutate(&a, 0.3), false),
        (cross(&a, &b, 0.0, 0.0), true),
        (cross(&a, &b, 1.0, 0.0), true),
        (cross(&a, &b, 0.5, 0.0), false),
        (cross(&a, &b, 0.0, 0.3), false),
        (cross(&a, &b, 1.0, 0.3), false),
        (cross(&a, &a, 0.5, 0.0), true),
        (cross(model, of_kind(false), 0.0, 0.0), true),
        (cross(model, of_kind(false), 1.0, 0.0), false),
        (cross(model, of_kind(true), 1.0, 0.0), true),
        (cross(model, &a, 1.0, 0.0), false),
        (cross(&a, model, 1.0, 0.0), true),
    ] {
        assert_eq!(variation.is_deterministic(), settled, "{variation:?}");
        let first = variation.birth(key(0));
        let all_one = (1..60).all(|slot| variation.birth(key(slot)) == first);
        assert_eq!(all_one, settled, "{variation:?}");
    }
}

#[test]
fn mutation_changes_more_when_the_amount_grows() {
    let parent = parent(0);
    let mean = |amount: f32| {
        let mutants = (0..200).map(|slot| Variation::mutate(&parent, amount).birth(key(slot)));
        mutants.map(|mutant| differing(&parent, &mutant)).sum::<usize>() as f64 / 200.0
    };
    let means: Vec<f64> = [0.05, 0.3, 0.6, 1.0].into_iter().map(mean).collect();
    assert!(means.is_sorted(), "{means:?}");
    assert!((0.4..2.5).contains(&means[1]) && (15.0..55.0).contains(&means[3]), "{means:?}");
}

#[test]
fn live_code_mutates_four_times_as_often_as_dead_code() {
    let (mut instructions, mut constants) = ([[0.0; 2]; 2], [[0.0; 2]; 2]);
    for slot in 0..400 {
        let parent = parent(slot);
        let live = crate::live_instructions(&parent);
        let mut read = [false; CONSTANTS];
        for (instruction, live) in parent.instructions().iter().zip(&live) {
            if let Some(constant) = instruction.constant().filter(|_| *live) {
                read[usize::from(constant)] = true;
            }
        }
        let mutant = Variation::mutate(&parent, 0.9).birth(key(slot + 1));
        let pairs = parent.instructions().iter().zip(mutant.instructions());
        for ((a, b), live) in pairs.zip(&live) {
            let [all, changed] = &mut instructions[usize::from(*live)];
            (*all, *changed) = (*all + 1.0, *changed + f64::from(u8::from(a != b)));
        }
        let pairs = parent.constants().iter().zip(mutant.constants());
        for ((a, b), read) in pairs.zip(read) {
            let [all, changed] = &mut constants[usize::from(read)];
            (*all, *changed) = (*all + 1.0, *changed + f64::from(u8::from(a != b)));
        }
    }
    for [dead, live] in [instructions, constants] {
        let favour = (live[1] / live[0]) / (dead[1] / dead[0]);
        assert!((3.6..4.4).contains(&favour), "{favour}: {live:?} {dead:?}");
    }
}

#[test]
fn mutation_always_changes_something_when_the_amount_is_above_zero() {
    let parent = parent(0);
    for slot in 0..200 {
        assert_ne!(Variation::mutate(&parent, 0.001).birth(key(slot)).hash(), parent.hash());
    }
    assert_eq!(Variation::mutate(&parent, 0.0).birth(key(0)), parent);
}

#[test]
fn recombination_takes_each_instruction_from_a_parent_at_its_own_position() {
    let (first, second) = (parent(0), parent(1));
    let mut taken = 0;
    for slot in 0..200 {
        let child = Variation::crossover(&first, &second, 0.25, 0.0).birth(key(slot));
        for (position, instruction) in child.instructions().iter().enumerate() {
            let (a, b) = (first.instructions()[position], second.instructions()[position]);
            assert!(*instruction == a || *instruction == b);
            taken += usize::from(*instruction == b && a != b);
        }
        assert_ne!(child.hash(), first.hash());
        assert_ne!(child.hash(), second.hash());
    }
    assert!((4000..6000).contains(&taken), "{taken} of 20000 from the second parent");
}

#[test]
fn constraints_and_output_are_carried_by_the_child() {
    let parent = parent(0);
    let grey = Output::saturation(0.0).unwrap();
    let child = Variation::mutate(&parent, 0.3)
        .with_constraints(DialectConstraints {
            isotropic: Some(true),
            homogeneous: None,
            bumps: None,
        })
        .with_output(Some(grey))
        .with_limit(Some(true))
        .birth(key(0));
    assert!(child.dialect().isotropic && !child.dialect().homogeneous);
    assert_eq!(child.output(), &grey);
    let grandchild = Variation::mutate(&child, 0.3).birth(key(1));
    assert!(grandchild.dialect().isotropic);
    assert_eq!(grandchild.output(), &grey);
    assert!(grandchild.is_limited());
    assert!(!Variation::mutate(&child, 0.3).with_limit(Some(false)).birth(key(1)).is_limited());
}

#[test]
fn random_genomes_use_the_whole_instruction_set() {
    let dialect =
        Dialect { opcodes: OpcodeSet::Extended, registers: 12, length: 1024, ..Dialect::default() };
    let genome = Variation::random(dialect).birth(key(0));
    for opcode in crate::Opcode::ALL {
        assert!(genome.instructions().iter().any(|i| i.opcode() == opcode), "{}", opcode.name());
    }
    assert!((0..12).all(|r| genome.instructions().iter().any(|i| i.dst() == r)));
}
