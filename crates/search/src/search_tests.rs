//! Tests that a resumed search continues with the same bits.

use brood_brdf::{Model, ModelKind};
use brood_target::{MeasuredTarget, draw_pairs};

use super::*;
use crate::Found;
use crate::test_material::Shining;

fn samples() -> Samples {
    Samples::of(&*Model::new(ModelKind::Conductor).brdf(), draw_pairs(600, 1))
}

fn options(strategy: Strategy) -> Options {
    Options { strategy, seed: 5, is_mirrored: true, ..Options::default() }
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

/// The kept result is part of the state: the next one does not replace it if it is worse.
#[test]
fn resume_keeps_the_best_reported_result() {
    let held_out = Samples::of(&*Model::new(ModelKind::Conductor).brdf(), draw_pairs(500, 2));
    for strategy in [Strategy::Lobes, Strategy::Gp, Strategy::Hybrid] {
        let options = options(strategy);
        let new = || Search::new(&samples(), &options).reporting(&held_out);
        let (mut whole, mut broken) = (new(), new());
        for _ in 0..4 {
            let state = broken.checkpoint();
            broken = Search::resume(&samples(), &options, &state).unwrap().reporting(&held_out);
            assert_eq!(broken.checkpoint(), state, "{strategy}");
            assert_eq!(broken.step(), whole.step(), "{strategy}");
        }
        assert_eq!(broken.checkpoint(), whole.checkpoint(), "{strategy}");
        assert_eq!(broken.finish(), whole.finish(), "{strategy}");
    }
}

#[test]
fn reported_error_of_the_kept_result_never_rises() {
    let brdf = Model::new(ModelKind::CookTorrance).brdf();
    let target = MeasuredTarget {
        fitted: Samples::of(&*brdf, draw_pairs(150, 1)),
        held: Samples::of(&*brdf, draw_pairs(500, 2)),
        measured: None,
        reflected: None,
    };
    for strategy in [Strategy::Lobes, Strategy::Gp] {
        let mut search = Search::new(&target.fitted, &options(strategy)).reporting(&target.held);
        let (mut least, mut has_risen) = (f64::INFINITY, false);
        for _ in 0..12 {
            search.step();
            let result = Found::of(&search.method.result().unwrap(), &target).unwrap();
            has_risen |= result.e_log > least * 1.0001;
            let kept = search.kept.as_ref().unwrap();
            assert!(kept.error <= least, "{strategy}");
            least = kept.error;
            let outcome = search.finish().unwrap();
            let front = Found::all(&outcome.front, &target).unwrap();
            let best = &front[Found::best(&front, &outcome)];
            // The exact energy limit differs a little from the approximate one of the search.
            assert!(best.e_log <= 1.01 * least, "{strategy}: {} {least}", best.e_log);
        }
        // Otherwise there was nothing to keep.
        assert!(has_risen, "{strategy}");
    }
}

#[test]
fn probable_models_are_not_replaced_by_kept_ones() {
    let mut search = Search::new(&samples(), &options(Strategy::Analytic)).reporting(&samples());
    search.step();
    assert!(search.kept.is_none() && search.finish().unwrap().is_settled);
}

#[test]
fn fits_of_e_log_alone_have_less_of_it() {
    // A dark body below a bright highlight, where the objectives differ.
    let model = Model::new(ModelKind::CookTorrance).with("diffuse", &[0.002; 3]).unwrap();
    let samples = Samples::of(&*model.brdf(), draw_pairs(600, 1));
    let fitted = |objective| {
        let options = Options { objective, ..options(Strategy::Lobes) };
        let mut search = Search::new(&samples, &options);
        (0..3).map(|_| search.step()).last().unwrap().fitted
    };
    let [seen, e_log] = [Objective::Seen, Objective::ELog].map(fitted);
    assert!(e_log < seen, "{e_log} {seen}");
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
        let mut other = state.clone();
        other[0] += 1;
        assert_eq!(refused(&other), SearchError::Later);
        other[0] -= 2;
        assert_eq!(refused(&other), SearchError::Version);
    }
}
