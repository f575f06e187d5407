//! Tests of albedos against another quadrature, of their gradients against differences, and of fits
//! to a material that reflects more than it receives.

use brood_brdf::{Model, ModelKind};
use brood_eval::{channel_albedos, energy_limit};
use brood_genome::{BirthKey, Operator, Stream};
use brood_program::Program;
use brood_target::draw_pairs;

use super::super::Fit;
use super::super::seed::start;
use super::super::terms::Terms;
use super::*;
use crate::test_material::Shining;

fn lobes(shape: &Shape, seed: u64) -> Lobes {
    let brdf = Model::new(ModelKind::Conductor).brdf();
    let points = points(&Samples::of(&*brdf, draw_pairs(700, seed)), shape);
    start(shape, &points, &mut Stream::new(BirthKey { seed, slot: 0, attempt: 0 }, Operator::Lobes))
}

fn program(lobes: &Lobes) -> Program {
    Program::lower(&lobes.genome().unwrap().with_limit(false))
}

#[test]
fn albedos_match_those_of_the_program() {
    for is_mirrored in [true, false] {
        let shape = Shape::new(3, 4, is_mirrored);
        let albedos = Albedos::new(&shape);
        for seed in 0..4 {
            let lobes = lobes(&shape, seed);
            let program = program(&lobes);
            for (angle, found) in ANGLES.into_iter().zip(albedos.values(&lobes)) {
                let expected = channel_albedos(&program, angle, 256);
                for (found, expected) in found.into_iter().zip(expected) {
                    let off = (found - expected).abs() / expected;
                    assert!(off < 0.03, "{is_mirrored} {seed} {angle}: {found} {expected}");
                }
            }
        }
    }
}

#[test]
fn gradient_matches_differences_of_the_penalty() {
    let shape = Shape::new(2, 3, false);
    let albedos = Albedos::new(&shape);
    let mut lobes = lobes(&shape, 1);
    let most = albedos.values(&lobes).as_flattened().iter().fold(0.0f64, |a, b| a.max(*b));
    for channel in 0..3 {
        for term in 0..shape.terms {
            lobes.parameters[shape.colour(term, channel)] += 0.5 * libm::log2(3.0 / most);
        }
    }
    lobes.free[3] = false;
    let free: Vec<usize> = (0..lobes.parameters.len()).filter(|at| lobes.free[*at]).collect();
    let count = free.len();
    let mut normal = NormalEquations::zero(count);
    let cost = albedos.add(&lobes, &mut normal, 7.0);
    assert!(cost > 0.1 && (cost - albedos.cost(&lobes)).abs() < 1e-9 * cost, "{cost}");
    let largest = normal.gradient.iter().fold(0.0f64, |most, g| most.max(g.abs()));
    for (row, index) in free.into_iter().enumerate() {
        let moved = |by: f64| {
            let mut lobes = lobes.clone();
            lobes.parameters[index] += by;
            albedos.cost(&lobes)
        };
        let slope = 7.0 * (moved(1e-3) - moved(-1e-3)) / 4e-3;
        let off = (slope - normal.gradient[row]).abs();
        assert!(off < 4e-3 * largest, "{index}: {slope} {}", normal.gradient[row]);
    }
    for row in 0..count {
        for column in 0..row {
            let (a, b) = (normal.matrix[row * count + column], normal.matrix[column * count + row]);
            assert!((a - b).abs() <= 1e-9 * a.abs(), "{row} {column}");
        }
    }
}

#[test]
fn fit_conserves_energy_when_the_target_does_not() {
    let samples = Samples::of(&Shining, draw_pairs(1000, 1));
    let mut fit = Fit::new(&samples, vec![Shape::new(2, 3, true)], Terms::ALL, 1);
    fit.step();
    fit.step();
    for fitted in fit.refine(fit.front(), &mut || true).iter().take(5) {
        let limit = energy_limit(&program(&fitted.lobes));
        assert!(limit.albedo < 1.01 && limit.albedo > 0.9, "{limit:?}");
    }
}
