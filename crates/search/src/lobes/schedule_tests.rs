//! Tests of fits of a model, and that they do not depend on thread count.

use brood_brdf::{Brdf, Model, ModelKind};
use brood_program::Program;
use brood_target::{draw_pairs, metric, narrow_pairs};

use super::*;
use crate::test_material::Shining;

fn shapes() -> Vec<Shape> {
    vec![Shape::new(2, 3, true), Shape::new(3, 3, true)]
}

fn metal() -> Box<dyn Brdf> {
    Model::new(ModelKind::Conductor).brdf()
}

fn fit(generations: u32, seed: u64) -> Fit {
    let samples = Samples::of(&*metal(), draw_pairs(1000, 1));
    let mut fit = Fit::new(&samples, shapes(), Terms::ALL, seed);
    for _ in 0..generations {
        fit.step();
    }
    fit
}

/// Fit of a material that reflects more than it receives, on that many threads.
fn shining(threads: usize) -> Lobes {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| {
        let samples = Samples::of(&Shining, draw_pairs(600, 1));
        let mut fit = Fit::new(&samples, shapes(), Terms::ALL, 3);
        for _ in 0..3 {
            fit.step();
        }
        assert!(fit.has_albedo_penalty);
        fit.refine(fit.front(), &mut || true).remove(0).lobes
    })
}

/// The fit of the front with the least error on the validation samples, refined.
fn best(fit: &Fit) -> Lobes {
    let best = fit.front().min_by(|a, b| a.held.total_cmp(&b.held));
    fit.refine(best.into_iter(), &mut || true).remove(0).lobes
}

fn e_log(lobes: &Lobes, samples: &Samples) -> f64 {
    let program = Program::lower(&lobes.genome().unwrap().with_limit(false));
    let found = Samples::of_program(&program, samples.pairs().to_vec()).unwrap();
    metric::e_log(&samples.weighted(), &found.weighted())
}

#[test]
fn fit_generalises_to_other_samples() {
    let lobes = best(&fit(4, 1));
    let test = Samples::of(&*metal(), draw_pairs(4000, 2));
    let nothing = metric::e_log(&test.weighted(), &vec![[0.0; 3]; test.len()]);
    let off = e_log(&lobes, &test);
    assert!(off < 0.15 * nothing, "{off} of {nothing}");
}

#[test]
fn front_trades_error_for_length() {
    let fit = fit(3, 2);
    let front = fit.refine(fit.front(), &mut || true);
    assert!(front.len() > 5, "{}", front.len());
    let lengths: Vec<usize> = front.iter().map(|fitted| fitted.lobes.free()).collect();
    assert!(lengths.windows(2).all(|pair| pair[1] < pair[0]), "{lengths:?}");
    let last = front.last().unwrap();
    assert!(last.fitted > front[0].fitted && last.lobes.genome().is_ok());
    let operations = |lobes: &Lobes| Program::lower(&lobes.genome().unwrap()).steps().len();
    assert!(3 * operations(&last.lobes) < 2 * operations(&front[0].lobes));
}

#[test]
fn generations_do_not_depend_on_thread_count() {
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let fit = fit(4, 3);
            (
                fit.best().unwrap().clone(),
                fit.refine(fit.front(), &mut || true).pop().unwrap().lobes,
            )
        })
    };
    let (one, three) = (on(1), on(3));
    assert_eq!(one, three);
    assert!(shining(3) == shining(1));
    assert_ne!(fit(4, 4).best().unwrap(), &one.0);
}

#[test]
fn front_is_empty_before_the_first_generation() {
    let fit = fit(0, 1);
    assert!(fit.best().is_none() && fit.front().next().is_none());
    assert!(fit.refine(fit.front(), &mut || true).is_empty());
}

#[test]
fn fit_has_no_spikes_between_samples() {
    let lobes = best(&fit(4, 1));
    let pairs = narrow_pairs(20_000, 5);
    let own = Samples::of(&*metal(), pairs.clone()).largest();
    let program = Program::lower(&lobes.genome().unwrap());
    let found = Samples::of_program(&program, pairs).unwrap().largest();
    assert!(found < 2.0 * own, "{found} of {own}");
}

#[test]
fn front_stays_below_the_ceiling_where_samples_are_few() {
    let pairs = || narrow_pairs(1 << 16, 99);
    let most = 2.0 * Samples::of(&*metal(), pairs()).largest();
    let fit = fit(3, 2);
    for fitted in fit.refine(fit.front(), &mut || true) {
        let program = Program::lower(&fitted.lobes.genome().unwrap().with_limit(false));
        let largest = Samples::of_program(&program, pairs()).unwrap().largest();
        assert!(largest <= most, "{largest} of {most}");
    }
}
