//! Tests of the normal equations against finite differences, and of the program against the fit.

use brood_brdf::{Brdf, Model, ModelKind};
use brood_genome::{BirthKey, Operator, Stream};
use brood_program::Program;
use brood_target::{Samples, draw_pairs, metric};

use super::super::block::points;
use super::super::seed::start;
use super::*;

fn conductor() -> Box<dyn Brdf> {
    Model::new(ModelKind::Conductor).brdf()
}

fn lobes(seed: u64, shape: &Shape) -> (Lobes, Batch, Samples) {
    let samples = Samples::of(&*conductor(), draw_pairs(700, seed));
    let points = points(&samples, shape);
    let mut stream = Stream::new(BirthKey { seed, slot: 0, attempt: 0 }, Operator::Lobes);
    let lobes = start(shape, &points, &mut stream);
    (lobes, Batch::new(points.iter()), samples)
}

#[test]
fn gradient_matches_differences_of_the_error() {
    for seed in 0..3 {
        let shape = Shape::new(3, 4, false);
        let (lobes, batch, _) = lobes(seed, &shape);
        let (normal, value) = normal_equations(&lobes, &batch);
        assert!((value - error(&lobes, &batch)).abs() <= 1e-12 * value);
        let largest = normal.gradient.iter().fold(0.0f64, |most, g| most.max(g.abs()));
        for (at, gradient) in normal.gradient.iter().enumerate() {
            let moved = |by: f64| {
                let mut lobes = lobes.clone();
                lobes.parameters[at] += by;
                error(&lobes, &batch) * batch.total
            };
            let slope = (moved(1e-3) - moved(-1e-3)) / 4e-3;
            let off = (slope - gradient).abs();
            assert!(off < 4e-3 * largest, "{seed} {at}: {slope} {gradient}, largest {largest}");
        }
    }
}

#[test]
fn matrix_matches_the_jacobian_by_differences() {
    let shape = Shape::new(2, 3, true);
    let (lobes, batch, samples) = lobes(7, &shape);
    let (normal, _) = normal_equations(&lobes, &batch);
    let count = normal.gradient.len();
    let residuals = |lobes: &Lobes| -> Vec<f64> {
        let weighted = values(lobes, &samples);
        let both = |value: &f64| {
            let relative = libm::log1p(f64::from(batch.gain) * value);
            [libm::log1p(*value), f64::from(batch.blocks[0].share.0[0]) * relative]
        };
        weighted.as_flattened().iter().flat_map(both).collect()
    };
    let columns: Vec<Vec<f64>> = (0..count)
        .map(|at| {
            let moved = |by: f64| {
                let mut lobes = lobes.clone();
                lobes.parameters[at] += by;
                residuals(&lobes)
            };
            let both = moved(1e-2).into_iter().zip(moved(-1e-2));
            both.map(|(up, down)| (up - down) / 2e-2).collect()
        })
        .collect();
    let largest = (0..count).map(|k| normal.matrix[k * count + k]).fold(0.0, f64::max);
    for a in 0..count {
        for b in 0..count {
            let expected: f64 = columns[a].iter().zip(&columns[b]).map(|(a, b)| a * b).sum();
            let off = (expected - normal.matrix[a * count + b]).abs();
            assert!(off < 5e-3 * largest, "{a} {b}: {expected} {}", normal.matrix[a * count + b]);
        }
    }
}

/// f cos_i of the program.
fn values(lobes: &Lobes, samples: &Samples) -> Vec<[f64; 3]> {
    let program = Program::lower(&lobes.genome().unwrap().with_limit(false));
    Samples::of_program(&program, samples.pairs().to_vec()).unwrap().weighted()
}

#[test]
fn program_has_the_error_that_was_fitted() {
    for (units, terms) in [(3, 4), (4, 5), (6, 7)] {
        let (lobes, batch, samples) = lobes(3, &Shape::new(units, terms, false));
        let found = metric::e_log(&samples.weighted(), &values(&lobes, &samples));
        let fitted = e_log(&lobes, &batch);
        assert!((found / fitted - 1.0).abs() < 1e-5, "{units} {terms}: {found} {fitted}");
    }
}
