//! Islands of a search over several workers: searches with different seeds, in a ring. Every
//! [`MIGRATION`] generations each takes the best programs of the one before.
//!
//! An island waits for the programs that the one before had at the same generation, so that the
//! results depend on the seed and the number of islands alone. An island that has ended sends no
//! more; the next one continues without.

/// Number of generations between migrations.
pub const MIGRATION: u32 = 32;

/// Returns the seed of an island. The first has that of the search.
#[must_use]
pub fn island_seed(seed: u64, island: u32) -> u64 {
    // The finalizer of SplitMix64 (Steele, Lea and Flood 2014), which maps different values to
    // different ones.
    let mut mixed = u64::from(island).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    seed ^ mixed ^ (mixed >> 31)
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use brood_brdf::{Model, ModelKind};
    use brood_target::{Samples, Strategy, draw_pairs};

    use super::*;
    use crate::{Options, Search};

    #[test]
    fn seeds_of_islands_differ() {
        assert_eq!(island_seed(7, 0), 7);
        let seeds: HashSet<u64> = (0..1000).map(|island| island_seed(7, island)).collect();
        assert_eq!(seeds.len(), 1000);
    }

    #[test]
    fn migrants_improve_the_next_island_and_its_checkpoint_has_them() {
        let brdf = Model::new(ModelKind::Lambert).brdf();
        let samples = Samples::of(&*brdf, draw_pairs(300, 1));
        let options = |island| Options {
            strategy: Strategy::Gp,
            seed: island_seed(3, island),
            ..Options::default()
        };
        let mut first = Search::new(&samples, &options(0));
        assert!(first.emigrants().is_empty());
        for _ in 0..8 {
            first.step();
        }
        let mut second = Search::new(&samples, &options(1));
        second.step();
        let before = second.progress();
        second.immigrate(&first.emigrants());
        let after = second.progress();
        assert_eq!(after.generation, before.generation);
        assert!(
            after.fitted <= before.fitted && after.fitted <= first.progress().fitted * 1.000_001
        );
        assert!(after.evaluations > before.evaluations);
        let mut resumed = Search::resume(&samples, &options(1), &second.checkpoint()).unwrap();
        second.step();
        resumed.step();
        assert_eq!(resumed.checkpoint(), second.checkpoint());
    }
}
