//! Tests that genetic searches reduce the error, do not depend on thread count, and keep the
//! genomes they start from.

use brood_brdf::{Model, ModelKind};
use brood_eval::limited;
use brood_genome::BirthKey;
use brood_program::Program;
use brood_target::{LowerBound, draw_pairs};

use super::super::evaluate::sum_of;
use super::*;

fn samples() -> Samples {
    Samples::of(&*Model::new(ModelKind::Conductor).brdf(), draw_pairs(700, 1))
}

fn search(generations: u32, start: &[Genome], seed: u64) -> Gp {
    let mut gp = Gp::new(&samples(), start, seed, false);
    for _ in 0..generations {
        gp.step();
    }
    gp
}

fn e_log(genome: &Genome, samples: &Samples) -> f64 {
    e_log_of(&limited(Program::lower(genome)), samples)
}

fn e_log_of(program: &Program, samples: &Samples) -> f64 {
    let found = Samples::of_program(program, samples.pairs().to_vec()).unwrap();
    metric::e_log(&samples.weighted(), &found.weighted())
}

#[test]
fn gp_approximates_a_model() {
    let gp = search(12, &[], 1);
    let samples = samples();
    let nothing = metric::e_log(&samples.weighted(), &vec![[0.0; 3]; samples.len()]);
    let best = Method::best(&gp).unwrap();
    let off = e_log(&best.genome, &samples);
    assert!(off < 0.45 * nothing, "{off} of {nothing}");
    let progress = gp.progress();
    let own = both_errors(progress.fitted, progress.held);
    // The search approximates the energy limit.
    let off = e_log_of(&gp.cases.limited_program(&best.genome), &samples);
    assert!((own - off).abs() < 0.01 * off, "{progress:?}, {off}");
}

/// E_log on training and validation samples together; one in seven is a validation sample.
fn both_errors(fitted: f64, held: f64) -> f64 {
    ((6.0 * fitted * fitted + held * held) / 7.0).sqrt()
}

#[test]
fn lower_bounds_count_where_f_is_below_them() {
    let grey = Model::new(ModelKind::Lambert).with("albedo", &[0.5; 3]).unwrap();
    let pairs = draw_pairs(100, 1);
    let f = 0.5 * std::f64::consts::FRAC_1_PI;
    let bound = |f: [f64; 3], is_known| LowerBound { pair: pairs[0], f, is_known };
    let sum = |bounds: Vec<LowerBound>| {
        let samples = Samples::of(&*grey.brdf(), pairs.clone()).with_lower_bounds(bounds);
        let genome = Genome::of_models(vec![grey.clone()]).unwrap();
        sum_of(&genome, &Cases::new(&samples, 1))
    };
    assert!(sum(Vec::new()) < 1e-9);
    assert!(sum(vec![bound([0.5 * f; 3], [false; 3])]) < 1e-9);
    let cos_i = pairs[0].cos_i();
    let off = libm::log2((1.0 + 3.0 * f * cos_i) / (1.0 + f * cos_i)).powi(2);
    let found = sum(vec![bound([3.0 * f; 3], [false; 3])]);
    assert!((found - 3.0 * off).abs() < 1e-5, "{found} {off}");
    // A channel that is not clipped has a value.
    let found = sum(vec![bound([0.0, 3.0 * f, f], [true, false, true])]);
    let below = libm::log2(1.0 + f * cos_i).powi(2);
    assert!((found - below - off).abs() < 1e-5, "{found} {off} {below}");
}

#[test]
fn front_and_best_are_ranked_under_the_energy_limit() {
    // Reflects more light than it receives, as some measurements do.
    let lambert = Model::new(ModelKind::Lambert).with("albedo", &[0.9; 3]).unwrap();
    let samples = Samples::of(&*lambert.brdf(), draw_pairs(700, 1));
    let bright = samples.values().iter().map(|f| f.map(|f| 1.6 * f)).collect();
    let samples = Samples::new(samples.pairs().to_vec(), bright);
    let mut gp = Gp::new(&samples, &[], 1, false);
    (0..4).for_each(|_| {
        gp.step();
    });
    let Outcome { front, best, .. } = Method::finish(&gp, &mut || true).unwrap();
    for found in &front {
        let own = both_errors(found.fitted, found.held);
        let off = e_log_of(&gp.cases.limited_program(&found.genome), &samples);
        assert!((own - off).abs() < 0.01 * off, "{own} {off}");
        // The exact limit also allows for peaks that it may have missed.
        let exact = e_log(&found.genome, &samples);
        assert!((own - exact).abs() < 0.2 * exact, "{own} {exact}");
    }
    let progress = gp.progress();
    assert_eq!((front[best].fitted, front[best].held), (progress.fitted, progress.held));
    // A Lambertian surface that reflects all light is off by ln(1 + 1.44 x) - ln(1 + x).
    assert!(both_errors(progress.fitted, progress.held) > 0.05);
}

#[test]
fn front_is_ordered_by_length() {
    let front = Method::finish(&search(6, &[], 2), &mut || true).unwrap().front;
    assert!(front.len() > 4, "{}", front.len());
    let operations: Vec<usize> =
        front.iter().map(|found| Program::lower(&found.genome).operations()).collect();
    assert!(operations.windows(2).all(|pair| pair[1] <= pair[0]), "{operations:?}");
    assert!(front.iter().all(|found| found.genome.is_limited()));
}

#[test]
fn generations_do_not_depend_on_thread_count() {
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| search(5, &[], 3).save())
    };
    let one = on(1);
    assert_eq!(one, on(3));
    assert_ne!(one, search(5, &[], 4).save());
}

#[test]
fn search_is_no_worse_than_its_start() {
    let samples = samples();
    let found = Method::best(&search(6, &[], 1)).unwrap().genome;
    let start_mutant = search(2, std::slice::from_ref(&found), 9);
    let best = Method::best(&start_mutant).unwrap().genome;
    assert!(e_log(&best, &samples) <= 1.02 * e_log(&found, &samples));
    assert_eq!(best.dialect(), found.dialect());
    // Start genomes may have different dialects; two that cannot be crossed are mutated instead.
    let paper = random(Dialect::default(), BirthKey { seed: 1, slot: 0, attempt: 0 });
    let both = search(3, &[paper, found], 9);
    assert!(both.islands.iter().all(|island| !island.members.is_empty()));
}

#[test]
fn members_stay_below_the_ceiling_where_samples_are_few() {
    let gp = search(4, &[], 5);
    for member in gp.islands.iter().flat_map(|island| &island.members) {
        let pairs = gp.cases.narrow.pairs(0..gp.cases.narrow.len()).to_vec();
        let program = gp.cases.limited_program(&member.genome);
        let found = Samples::of_program(&program, pairs).unwrap();
        assert!(found.largest() <= gp.cases.ceiling);
    }
}
