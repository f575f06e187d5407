//! Believable programs: drawn deterministically, bounded, and varied by their parameters.

use super::parameters::Parameters;
use super::*;
use crate::{BirthKey, Channel, Genome, Locks, Start, Steer, Variation};

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

#[test]
fn draws_are_deterministic_limited_and_of_one_dialect() {
    assert_eq!(weights().len(), WEIGHTS);
    for slot in 0..200 {
        let genome = drawn(slot);
        assert_eq!(genome, drawn(slot));
        assert_eq!(genome.dialect(), &dialect());
        assert!(genome.is_limited());
        assert_eq!(genome.instructions(), drawn(0).instructions());
        assert_ne!(genome.hash(), drawn(slot + 1).hash());
        let body = parameters(&genome).body_albedo();
        assert!(body.iter().all(|albedo| (0.0..10.0).contains(albedo)), "{slot}: {body:?}");
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
fn mutation_changes_only_constants_for_generations() {
    for slot in 0..30 {
        let mut genome = drawn(slot);
        for generation in 0..5 {
            let child = mutant(&genome, [0.02, 0.3, 1.0][slot as usize % 3], 7 * slot + generation);
            assert_eq!(child.instructions(), genome.instructions());
            assert_ne!(child.constants(), genome.constants());
            assert!(child.is_limited());
            genome = child;
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
    let parent = drawn(3);
    let locks = Locks { constants: vec![0, 4, 9], ..Locks::default() };
    for slot in 0..20 {
        let mutate = Variation::mutate(&parent, 0.8).with_start(Start::Believable);
        let child = mutate.with_locks(Some(&locks)).birth(key(slot));
        for constant in [0, 4, 9] {
            assert_eq!(child.constants()[constant], parent.constants()[constant]);
        }
    }
}

#[test]
fn locked_channels_stay_and_the_others_change_in_colour() {
    let (first, second) = (drawn(3), drawn(9));
    let locks = Locks { channels: vec![Channel::Red, Channel::Blue], ..Locks::default() };
    let old = parameters(&first);
    let mut changed = 0;
    for slot in 0..20 {
        for variation in
            [Variation::mutate(&first, 0.8), Variation::crossover(&first, &second, 0.5, 0.8)]
        {
            let child =
                variation.with_start(Start::Believable).with_locks(Some(&locks)).birth(key(slot));
            let new = parameters(&child);
            assert_eq!(new.weights, old.weights);
            for (new, old) in new.colours.iter().zip(&old.colours) {
                assert_eq!([new[0], new[2]], [old[0], old[2]]);
                changed += u32::from(new[1].to_bits() != old[1].to_bits());
            }
        }
    }
    assert!(changed > 40, "{changed}");
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
    for slot in 0..40 {
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
                for term in 0..TERMS {
                    let hue =
                        |of: &Parameters| of.colours[term].map(|one| one - of.colours[term][0]);
                    let apart = hue(&old).into_iter().zip(hue(&new)).map(|(a, b)| (a - b).abs());
                    let most = apart.fold(0.0, f64::max);
                    assert!(most < 1e-4, "slot {slot}, {word:?}, term {term}: {most}");
                }
                let body = |of: &Parameters| (of.weights[4..8].to_vec(), of.colours[0]);
                assert!(word == Steer::KeepColour || body(&old) == body(&new), "slot {slot}");
            }
        }
    }
    assert!(changed > 120, "{changed} of 160");
}
