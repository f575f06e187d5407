//! Believable programs: drawn deterministically, bounded, and varied by their parameters.

use super::parameters::Parameters;
use super::*;
use crate::{
    BirthKey, Channel, Dialect, DialectConstraints, Genome, Locks, Start, Steer, Variation,
};

fn key(slot: u32) -> BirthKey {
    BirthKey { seed: 5, slot, attempt: 0 }
}

fn drawn(slot: u32) -> Genome {
    Variation::random(dialect()).with_start(Start::Believable).birth(key(slot))
}

fn mutant(parent: &Genome, mutation: f32, slot: u32) -> Genome {
    Variation::mutate(parent, mutation).with_start(Start::Believable).birth(key(slot))
}

fn parameters(genome: &Genome) -> Parameters {
    Parameters::of(genome.instructions(), genome.constants()).expect("it is believable")
}

fn structure(genome: &Genome) -> Structure {
    parameters(genome).structure()
}

/// First draw with a structure.
fn drawn_as(wanted: Structure, from: u32) -> Genome {
    let mut all = (from..from + 1000).map(drawn);
    all.find(|genome| structure(genome) == wanted).expect("every structure is drawn")
}

#[test]
fn draws_are_deterministic_limited_and_of_one_dialect() {
    assert_eq!(weights().len(), WEIGHTS);
    for slot in 0..200 {
        let genome = drawn(slot);
        assert_eq!(genome, drawn(slot));
        assert_eq!(genome.dialect(), &dialect());
        assert!(genome.is_limited());
        assert_ne!(genome.hash(), drawn(slot + 1).hash());
        let body = parameters(&genome).body_albedo();
        assert!(body.iter().all(|albedo| (0.0..10.0).contains(albedo)), "{slot}: {body:?}");
    }
}

#[test]
fn most_draws_are_plain_and_the_others_have_all_structures() {
    let all: Vec<Structure> = (0..2000).map(|slot| structure(&drawn(slot))).collect();
    let share = |one: Structure| all.iter().filter(|own| **own == one).count() as f64 / 2000.0;
    let [plain, brushed, patterned, both] = Structure::ALL.map(share);
    assert!((0.6..0.7).contains(&plain), "{plain}");
    assert!(brushed > 0.06 && patterned > 0.12 && both > 0.005, "{brushed} {patterned} {both}");
}

#[test]
fn plain_programs_have_no_further_instructions() {
    let live = |structure| {
        let genome = drawn_as(structure, 0);
        let idle = |one: &&crate::Instruction| one.opcode() != crate::Opcode::Mov;
        genome.instructions().iter().filter(idle).count()
    };
    assert_eq!(Structure::ALL.map(live), [18, 40, 40, 62]);
}

#[test]
fn switches_of_the_dialect_leave_modules_out() {
    let closed = Dialect { isotropic: true, homogeneous: true, ..dialect() };
    let plain = Variation::random(closed).with_start(Start::Believable);
    for slot in 0..100 {
        let (closed, open) = (plain.birth(key(slot)), drawn(slot));
        assert_eq!(structure(&closed), Structure::default());
        // The module, not the material, is left out.
        if structure(&open) == Structure::default() {
            assert_eq!(parameters(&closed), parameters(&open));
        }
        let constraints =
            DialectConstraints { isotropic: Some(true), homogeneous: Some(true), bumps: None };
        for amount in [0.3, 1.0] {
            let mutate = Variation::mutate(&closed, amount).with_start(Start::Believable);
            assert_eq!(structure(&mutate.birth(key(slot))), Structure::default());
            let child = mutant(&open, amount, slot);
            let mutate = Variation::mutate(&open, amount).with_start(Start::Believable);
            let constrained = mutate.with_constraints(constraints).birth(key(slot));
            assert!(constrained.dialect().isotropic && constrained.dialect().homogeneous);
            assert_eq!(constrained.instructions().len(), child.instructions().len());
        }
    }
}

#[test]
fn parameters_are_read_back_from_the_program() {
    for slot in 0..50 {
        let genome = drawn(slot);
        let read = parameters(&genome).genome();
        let both = genome.constants().as_flattened().iter().zip(read.constants().as_flattened());
        for (a, b) in both {
            assert!((a - b).abs() <= 1e-5 * a.abs(), "{a} {b}");
        }
    }
}

#[test]
fn mutants_stay_believable_for_generations() {
    let mut changed = 0;
    for slot in 0..60 {
        let mut genome = drawn(slot);
        for generation in 0..5 {
            let amount = [0.02, 0.3, 1.0][slot as usize % 3];
            let child = mutant(&genome, amount, 7 * slot + generation);
            let is_changed = structure(&child) != structure(&genome);
            assert!(amount > 0.02 || !is_changed, "slot {slot}");
            changed += u32::from(is_changed);
            assert_ne!(child.constants(), genome.constants());
            assert!(child.is_limited());
            genome = child;
        }
    }
    assert!(changed > 10, "{changed}");
}

#[test]
fn small_amounts_are_small_steps_of_every_module() {
    let both = drawn_as(Structure::ALL[3], 0);
    let old = parameters(&both);
    let apart = |amount: f32| {
        // A new shape may have another structure.
        let mutants = (0..50).map(|slot| mutant(&both, amount, slot));
        let same = mutants.filter(|one| structure(one) == structure(&both));
        let apart = same.map(|one| {
            let new = parameters(&one);
            let [old, new] = [old, new].map(|one| (one.stretch.unwrap(), one.pattern.unwrap()));
            let pairs = old.1.values.iter().zip(new.1.values).skip(16);
            let form: f64 = pairs.map(|(a, b)| (a - b).abs()).sum();
            ((old.0 - new.0).abs(), form)
        });
        apart.fold((0.0, 0.0), |sum, one| (sum.0 + one.0 / 50.0, sum.1 + one.1 / 50.0))
    };
    let [small, larger] = [0.02, 0.1].map(apart);
    assert!(0.0 < small.0 && small.0 < 0.5 * larger.0 && larger.0 < 0.2, "{small:?} {larger:?}");
    assert!(0.0 < small.1 && small.1 < 0.5 * larger.1, "{small:?} {larger:?}");
}

#[test]
fn children_of_a_plain_and_a_patterned_parent_have_either_structure() {
    let plain = drawn_as(Structure::ALL[0], 0);
    let closed = Variation::mutate(&plain, 0.0)
        .with_constraints(DialectConstraints {
            isotropic: Some(true),
            homogeneous: Some(true),
            bumps: None,
        })
        .birth(key(0));
    for other in Structure::ALL.into_iter().skip(1).map(|structure| drawn_as(structure, 30)) {
        for (first, second) in [(&plain, &other), (&other, &plain), (&closed, &other)] {
            let crossover = Variation::crossover(first, second, 0.5, 0.0);
            let mut counts = [0; 4];
            for slot in 0..60 {
                let child = crossover.with_start(Start::Believable).birth(key(slot));
                let own = structure(&child);
                counts[Structure::ALL.iter().position(|one| *one == own).unwrap()] += 1;
                let Dialect { isotropic, homogeneous, .. } = *child.dialect();
                assert!(!(own.is_brushed && isotropic || own.is_patterned && homogeneous));
                let stretch = parameters(&child).stretch;
                assert!(stretch.is_none() || stretch == parameters(&other).stretch);
            }
            let [none, ..] = counts;
            assert!((8..50).contains(&none), "{counts:?}");
        }
    }
}

#[test]
fn crossover_takes_parameters_of_both() {
    for slot in 0..30 {
        let (first, second) = (drawn(slot), drawn(slot + 1));
        let child = |share| {
            let crossover = Variation::crossover(&first, &second, share, 0.0);
            crossover.with_start(Start::Believable).birth(key(slot))
        };
        assert_eq!(child(0.0), first);
        let all = parameters(&child(1.0));
        let other = parameters(&second);
        assert_eq!(all.weights, other.weights);
        assert_eq!(all.structure(), other.structure());
        let colours = all.colours.iter().zip(&other.colours);
        for (a, b) in colours.flat_map(|(a, b)| a.iter().zip(b)) {
            assert!((a - b).abs() < 1e-5, "{a} {b}");
        }
        let half = parameters(&child(0.5));
        assert!(half != parameters(&first) && half != parameters(&second));
    }
}

#[test]
fn locked_constants_stay() {
    for parent in Structure::ALL.map(|structure| drawn_as(structure, 3)) {
        let locks = Locks { constants: vec![0, 4, 9], ..Locks::default() };
        for slot in 0..20 {
            let mutate = Variation::mutate(&parent, 0.8).with_start(Start::Believable);
            let child = mutate.with_locks(Some(&locks)).birth(key(slot));
            assert_eq!(child.instructions(), parent.instructions());
            for constant in [0, 4, 9] {
                assert_eq!(child.constants()[constant], parent.constants()[constant]);
            }
        }
    }
}

#[test]
fn locked_channels_stay_and_the_others_change_in_colour() {
    let locks = Locks { channels: vec![Channel::Red, Channel::Blue], ..Locks::default() };
    for (one, other) in Structure::ALL.into_iter().zip([3, 1, 2, 0]) {
        let (first, second) = (drawn_as(one, 3), drawn_as(Structure::ALL[other], 9));
        let old = parameters(&first);
        let mut changed = 0;
        for slot in 0..20 {
            for variation in
                [Variation::mutate(&first, 0.8), Variation::crossover(&first, &second, 0.5, 0.8)]
            {
                let variation = variation.with_start(Start::Believable).with_locks(Some(&locks));
                let child = variation.birth(key(slot));
                // The same function, bit for bit: every constant but those of green.
                let [new, own] = [&child, &first].map(|one| one.constants());
                assert_eq!(child.instructions(), first.instructions());
                let differ = |at: &usize| new[*at] != own[*at];
                for at in (0..crate::CONSTANTS).filter(differ) {
                    assert_eq!([new[at][0], new[at][2]], [own[at][0], own[at][2]], "{one:?}");
                }
                let new = parameters(&child);
                let (green, was) = (new.colours[0][1], old.colours[0][1]);
                changed += u32::from(green.to_bits() != was.to_bits());
            }
        }
        assert!(changed > 30, "{changed}");
    }
}

#[test]
fn child_is_a_twin_when_everything_is_locked() {
    let parent = drawn(3);
    let channels = vec![Channel::Red, Channel::Green, Channel::Blue];
    let locks = Locks { channels, ..Locks::default() };
    let mutate = Variation::mutate(&parent, 0.8).with_start(Start::Believable);
    assert_eq!(mutate.with_locks(Some(&locks)).birth(key(1)), parent);
}

#[test]
fn roles_are_assigned_once() {
    for slot in 0..20 {
        let own = parameters(&drawn(slot));
        let (mut weights, mut levels) = (own.weights, own.colours.map(|colours| colours[0]));
        assign_roles(&mut weights, &mut levels);
        let once = (weights, levels);
        assign_roles(&mut weights, &mut levels);
        assert_eq!((weights, levels), once);
        let mut all = weights.map(f64::to_bits);
        let mut before = own.weights.map(f64::to_bits);
        all.sort_unstable();
        before.sort_unstable();
        assert_eq!(all, before, "weights are only exchanged");
    }
}

#[test]
fn other_programs_vary_as_ever() {
    let wild = Variation::random(Start::Wild.dialect()).birth(key(0));
    let usual = Variation::mutate(&wild, 0.3).birth(key(1));
    assert_eq!(mutant(&wild, 0.3, 1), usual);
}

#[test]
fn steered_programs_keep_the_hue_of_each_term() {
    let mut changed = 0;
    for slot in 0..60 {
        let (first, second) = (drawn(slot), drawn(slot + 1));
        let mutate = Variation::mutate(&first, 0.5);
        let crossover = Variation::crossover(&first, &second, 0.5, 0.5);
        for word in [Steer::KeepColour, Steer::OnlyGloss] {
            for variation in [mutate, crossover] {
                let words = [word];
                let variation = variation.with_start(Start::Believable).with_steer(&words);
                let child = variation.birth(key(slot));
                changed += u32::from(child != first);
                let (old, new) = (parameters(&first), parameters(&child));
                // The colours where the pattern is 0 and where it is 1.
                let sets = |of: &Parameters| {
                    let second = of.pattern.map(|pattern| pattern.contrast);
                    [of.colours, second.unwrap_or_default()]
                };
                for (old, new) in sets(&old).as_flattened().iter().zip(sets(&new).as_flattened()) {
                    let hue = |of: &[f64; 3]| of.map(|one| one - of[0]);
                    let apart = hue(old).into_iter().zip(hue(new)).map(|(a, b)| (a - b).abs());
                    let most = apart.fold(0.0, f64::max);
                    assert!(most < 1e-4, "slot {slot}, {word:?}: {most}");
                }
                if word == Steer::OnlyGloss {
                    let body = |of: &Parameters| (of.weights[4..8].to_vec(), of.colours[0]);
                    assert_eq!(body(&old), body(&new), "slot {slot}");
                    assert_eq!(old.structure(), new.structure(), "slot {slot}");
                    let pattern = |of: &Parameters| of.pattern.map(|pattern| pattern.values);
                    assert_eq!(pattern(&old), pattern(&new), "slot {slot}");
                }
            }
        }
    }
    assert!(changed > 180, "{changed} of 240");
}
