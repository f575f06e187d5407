//! Tests of the sampling table.

use std::f64::consts::PI;

use brood_eval::express;
use brood_genome::Genome;
use brood_genome::preset::Preset;

use super::*;

fn table(text: &str) -> SamplingTable {
    let genome: Genome = text.parse().expect("the text is a genome");
    SamplingTable::of(&express(&genome))
}

#[test]
fn samples_by_the_table_vary_much_less_than_by_the_cosine() {
    for (text, variance, ratio) in [
        ("brood 1\n.model cook-torrance\n", 0.1, 20.0),
        ("brood 1\n.model ward\nalpha_x 0.05\nalpha_y 0.4\n", 0.2, 20.0),
        ("brood 1\n.model ashikhmin-shirley\nexponent_u 100000\nexponent_v 30000\n", 0.2, 1e3),
    ] {
        let Variance { table, cosine } = table(text).variance;
        assert!(table < variance && cosine > ratio * table, "{text}{table} {cosine}");
    }
}

#[test]
fn diffuse_materials_are_sampled_by_the_cosine() {
    let lambert = table("brood 1\n.model lambert\n");
    assert_eq!(lambert.share, 0.0);
    assert!(lambert.variance.table < 1e-3);
}

#[test]
fn densities_integrate_to_1_for_any_eye() {
    let table = table("brood 1\n.model ward\nalpha_x 0.1\nalpha_y 0.3\n");
    for eye in [direction(0.2, 0.3), direction(0.9, 2.0), direction(1.4, 5.0)] {
        let slices = table.slices(eye);
        let count = 100_000;
        let sum: f64 = (0..count).map(|k| table.density(&slices, spread(k))).sum();
        assert!((sum / f64::from(count as u32) - 1.0).abs() < 2e-3, "{sum}");
    }
}

#[test]
fn black_materials_have_a_table_too() {
    let black = table("brood 1\n.dialect paper smooth registers 7\nSUB R0, R0, R0\n");
    assert!(black.values.iter().any(|value| value.to_f64() > 0.0));
}

#[test]
fn samples_have_the_density_of_the_table() {
    for name in ["gold", "brushed-metal", "model-golf-ball"] {
        let program = Program::lower(Preset::find(name).unwrap().genome());
        let table = SamplingTable::of(&program);
        for (inclination, azimuth) in [(0.1, 0.3), (0.7, 2.0), (1.2, 4.0), (1.0, -3.1)] {
            let eye = direction(inclination, azimuth);
            let count = 20_000;
            // The integral of the cosine over the hemisphere is pi, whatever chooses the samples.
            let estimate = |k: usize| {
                let place = spread(k);
                let choice = (0.569_840_290_998_053_2 * 7.3 * k as f64).fract();
                let light = table.sample(eye, [choice, place.x, place.y]);
                let pair = DirectionPair::new(light, eye).unwrap();
                if light.z > 0.0 { light.z / table.pdf(&pair) } else { 0.0 }
            };
            let mean = (0..count).map(estimate).sum::<f64>() / count as f64;
            assert!((mean / PI - 1.0).abs() < 0.05, "{name} {inclination} {azimuth}: {mean}");
        }
    }
}

#[test]
fn density_is_zero_below_the_surface() {
    let gold = Preset::find("gold").unwrap();
    let table = SamplingTable::of(&Program::lower(gold.genome()));
    let pair = |light: f64, eye: f64| DirectionPair::new(DVec3::Z * light, DVec3::Z * eye).unwrap();
    assert!(table.pdf(&pair(1.0, 1.0)) > 0.0);
    for below in [pair(-1.0, 1.0), pair(1.0, -1.0)] {
        assert!(table.pdf(&below) <= 0.0);
    }
}

#[test]
fn linear_densities_are_drawn_by_their_integral() {
    for (low, high) in [(0.0, 1.0), (1.0, 0.0), (0.3, 0.8), (2.0, 2.0)] {
        for random in [0.0, 0.1, 0.5, 0.99] {
            let at = draw_linear(low, high, random);
            let below = (low * at + 0.5 * (high - low) * at * at) / (0.5 * (low + high));
            assert!((below - random).abs() < 1e-12, "{low} {high} {random}: {below}");
        }
    }
    assert_eq!(draw_cell(3, 0.5, |cell| [1.0, 0.0, 1.0][cell]).0, 2);
    assert_eq!(draw_cell(2, 0.999, |cell| [1.0, 0.0][cell]).0, 0);
}
