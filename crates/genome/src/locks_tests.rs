//! Locked parts stay the same in all children; locks of missing parts are rejected.

use proptest::prelude::*;

use super::*;
use crate::{BirthKey, Variation, interpret};

fn parent(seed: u64) -> Genome {
    Variation::random(Dialect::default()).birth(BirthKey { seed, slot: 0, attempt: 0 })
}

/// Result registers of red, green and blue for several inputs.
fn results(genome: &Genome) -> Vec<[u32; 3]> {
    let value =
        |at: usize, input: crate::Input| ((at * 31 + input.index() * 17) % 40) as f32 / 20.0 - 1.0;
    let g = |at: usize| interpret::<f32>(genome, |input| value(at, input));
    (0..16).map(|at| g(at).map(|g| g.abs().to_bits())).collect()
}

#[test]
fn locks_of_missing_parts_are_rejected_with_a_pointer() {
    let dialect = Dialect { length: 10, ..Dialect::default() };
    let locks = Locks { instructions: vec![9, 10], ..Locks::default() };
    let error = locks.validate(&dialect).unwrap_err();
    assert_eq!(error.pointer(), "/instructions/1");
    assert_eq!(
        error.to_string(),
        "there is no instruction 10: a genome of the dialect has 10, counted from 0"
    );
    let locks = Locks { constants: vec![128], ..Locks::default() };
    assert_eq!(locks.validate(&dialect).unwrap_err().pointer(), "/constants/0");
}

#[test]
fn mutation_changes_nothing_when_the_whole_parent_is_locked() {
    let parent = parent(3);
    let locks = Locks {
        instructions: (0..100).collect(),
        constants: (0..128).collect(),
        ..Locks::default()
    };
    let variation = Variation::mutate(&parent, 1.0).with_locks(Some(&locks));
    assert_eq!(variation.birth(BirthKey { seed: 1, slot: 0, attempt: 0 }), parent);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(120))]

    #[test]
    fn locked_parts_are_those_of_the_first_parent(
        seed in any::<u64>(), mutation in 0.0f32..=1.0, share in 0.0f32..=1.0,
        instructions in prop::collection::vec(0u16..100, 0..60),
        constants in prop::collection::vec(0u8..128, 0..60),
    ) {
        let (first, second) = (parent(seed), parent(seed ^ 1));
        let locks = Locks { instructions, constants, ..Locks::default() };
        let key = BirthKey { seed, slot: 3, attempt: 0 };
        for variation in [
            Variation::mutate(&first, mutation),
            Variation::crossover(&first, &second, share, mutation),
        ] {
            let child = variation.with_locks(Some(&locks)).birth(key);
            for index in &locks.instructions {
                let index = usize::from(*index);
                prop_assert_eq!(child.instructions()[index], first.instructions()[index]);
            }
            for index in &locks.constants {
                let index = usize::from(*index);
                prop_assert_eq!(child.constants()[index], first.constants()[index]);
            }
        }
    }

    #[test]
    fn locked_channel_stays_the_same_function(
        seed in any::<u64>(), mutation in 0.3f32..=1.0, share in 0.0f32..=1.0, channel in 0usize..3,
    ) {
        let (first, second) = (parent(seed), parent(seed ^ 1));
        let channels = vec![[Channel::Red, Channel::Green, Channel::Blue][channel]];
        let locks = Locks { channels, ..Locks::default() };
        let key = BirthKey { seed, slot: 3, attempt: 0 };
        for variation in [
            Variation::mutate(&first, mutation),
            Variation::crossover(&first, &second, share, mutation),
        ] {
            let child = variation.with_locks(Some(&locks)).birth(key);
            for (before, after) in results(&first).iter().zip(results(&child)) {
                prop_assert_eq!(before[channel], after[channel]);
            }
        }
    }
}
