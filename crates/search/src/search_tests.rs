//! Tests that a resumed search continues with the same bits.

use brood_brdf::{Model, ModelKind};
use brood_target::draw_pairs;

use super::*;
use crate::test_material::Shining;

fn samples() -> Samples {
    Samples::of(&*Model::new(ModelKind::Conductor).brdf(), draw_pairs(600, 1))
}

fn options(strategy: Strategy) -> Options {
    Options { strategy, seed: 5, is_mirrored: true, start: Vec::new() }
}

#[test]
fn resume_changes_no_bit() {
    for strategy in Strategy::ALL {
        breaks(&samples(), strategy, 10);
    }
    // A material that reflects more than it receives adds state to a search of lobes.
    breaks(&Samples::of(&Shining, draw_pairs(600, 1)), Strategy::Lobes, 5);
}

fn breaks(samples: &Samples, strategy: Strategy, generations: u32) {
    let options = options(strategy);
    let mut whole = Search::new(samples, &options);
    let mut broken = Search::new(samples, &options);
    for _ in 0..generations {
        let state = broken.checkpoint();
        broken = Search::resume(samples, &options, &state).unwrap();
        assert_eq!(broken.checkpoint(), state, "{strategy}");
        assert_eq!(broken.step(), whole.step(), "{strategy}");
        assert_eq!(broken.probe(), whole.probe(), "{strategy}");
    }
    assert_eq!(broken.checkpoint(), whole.checkpoint(), "{strategy}");
    assert_eq!(broken.best(), whole.best(), "{strategy}");
    let ends = [broken, whole].map(|search| search.finish());
    assert_eq!(ends[0], ends[1], "{strategy}");
}

#[test]
fn hybrid_announces_the_long_generation() {
    let mut search = Search::new(&samples(), &options(Strategy::Hybrid));
    let is_long = (0..9).map(|_| {
        search.step();
        search.next_step_cost() > 1.0
    });
    assert_eq!(is_long.collect::<Vec<_>>(), (1..=9).map(|done| done == 7).collect::<Vec<_>>());
}

#[test]
fn resume_rejects_bad_checkpoints() {
    let samples = samples();
    for strategy in Strategy::ALL {
        let options = options(strategy);
        let mut search = Search::new(&samples, &options);
        search.step();
        let state = search.checkpoint();
        let refused = |bytes: &[u8]| Search::resume(&samples, &options, bytes).err().unwrap();
        assert_eq!(refused(&[]), SearchError::Damaged);
        assert_eq!(refused(&state[..state.len() / 2]), SearchError::Damaged);
        let mut newer = state.clone();
        newer[0] += 1;
        assert_eq!(refused(&newer), SearchError::Version);
    }
}
