//! Tests that searches of pictures by lobes are guided by models, and resumed with the same bits.

use brood_brdf::{Model, ModelKind};
use brood_target::{MeasuredTarget, Objective, Strategy, draw_pairs, metric, pair_of_half};

use super::*;
use crate::{Options, Search};

fn plastic() -> Model {
    let model = Model::new(ModelKind::CookTorrance).with("diffuse", &[0.2, 0.1, 0.05]).unwrap();
    model.with("roughness", &[0.3]).unwrap()
}

/// Samples as pictures show them: theta_h of all sizes at two of theta_d.
fn seen() -> Samples {
    let angles = (0..900).map(|k| f64::from(k % 450) / 450.0);
    let pairs = angles.enumerate().filter_map(|(k, share)| {
        let theta_d = if k < 450 { 0.35 } else { 0.45 };
        pair_of_half(1.2 * share, theta_d)
    });
    let samples = Samples::of(&*plastic().brdf(), pairs.collect());
    MeasuredTarget::of_pixels(&samples).unwrap().fitted
}

fn options(strategy: Strategy) -> Options {
    Options { strategy, objective: Objective::ELog, is_mirrored: true, ..Options::default() }
}

/// E_log at pairs of all directions after this many generations.
fn elsewhere(samples: &Samples, generations: u32) -> f64 {
    let mut search = Search::new(samples, &options(Strategy::Lobes));
    (0..generations).for_each(|_| _ = search.step());
    let program = Program::lower(&search.best().unwrap().genome);
    let wanted = Samples::of(&*plastic().brdf(), draw_pairs(500, 3));
    let found = Samples::of_program(&program, wanted.pairs().to_vec()).unwrap();
    metric::e_log(&wanted.weighted(), &found.weighted())
}

#[test]
fn lobes_match_directions_that_pictures_do_not_show() {
    let samples = seen();
    let unguided = Samples::new(samples.pairs().to_vec(), samples.values().to_vec());
    let (guided, unguided) = (elsewhere(&samples, GENERATIONS + 4), elsewhere(&unguided, 4));
    assert!(guided < 0.02 && unguided > 5.0 * guided, "{guided} {unguided}");
}

#[test]
fn resumed_search_has_the_same_bits_in_both_stages() {
    let (samples, options) = (seen(), options(Strategy::Lobes));
    for before in [2, GENERATIONS + 1] {
        let mut search = Search::new(&samples, &options);
        (0..before).for_each(|_| _ = search.step());
        let mut resumed = Search::resume(&samples, &options, &search.checkpoint()).unwrap();
        assert_eq!(search.step(), resumed.step());
        assert!(search.checkpoint() == resumed.checkpoint(), "after {before} generations");
        assert_eq!(search.progress().generation, before + 1);
    }
}
