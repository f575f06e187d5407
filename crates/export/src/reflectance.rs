//! f of a program in batches, bumps and textures included, and even places to evaluate it at.

use std::f64::consts::TAU;

use brood_brdf::DirectionPair;
use brood_eval::{CanonicalEvaluator, Evaluator, TurnedPair};
use brood_program::Program;
use brood_scene::SampleSet;
use glam::{DVec2, DVec3};

/// Returns f about the mesh's own normal for pairs at texture positions.
pub(crate) fn reflectance(program: &Program, pairs: &[DirectionPair], uvs: &[DVec2]) -> Vec<DVec3> {
    let turned: Vec<TurnedPair> =
        pairs.iter().zip(uvs).map(|(pair, uv)| TurnedPair::new(program, *pair, *uv)).collect();
    let directions: Vec<DirectionPair> = turned.iter().map(|turned| turned.pair).collect();
    let set = SampleSet::from_pairs(&directions, uvs);
    let mut f = Vec::new();
    CanonicalEvaluator::default()
        .eval(&[program], &set, &mut f)
        .expect("the canonical evaluator evaluates every BRDF");
    let count = pairs.len();
    let rgb = |k: usize| DVec3::from([0, 1, 2].map(|channel| f64::from(f[channel * count + k])));
    turned.iter().enumerate().map(|(k, turned)| rgb(k) * turned.factor).collect()
}

/// Place of a sample in the unit square: even, whatever part of the samples is taken.
///
/// Source: Roberts 2018, The unreasonable effectiveness of quasirandom sequences.
pub(crate) fn spread(k: usize) -> DVec2 {
    let part = |step: f64| (step * (k as f64 + 1.0)).fract();
    DVec2::new(part(0.754_877_666_246_692_7), part(0.569_840_290_998_053_2))
}

/// Direction with an inclination from the normal and an azimuth, in radians.
pub(crate) fn direction(inclination: f64, azimuth: f64) -> DVec3 {
    let (sin, cos) = (libm::sin(inclination), libm::cos(inclination));
    DVec3::new(sin * libm::cos(azimuth), sin * libm::sin(azimuth), cos)
}

/// Pairs of directions, both at least 0.6 degrees above the surface, uniform over the hemisphere;
/// those at odd places have the light near the mirror direction.
pub(crate) fn even_pairs(count: usize) -> Vec<DirectionPair> {
    // The four-dimensional sequence of the source above.
    const STEPS: [f64; 4] = [
        0.856_674_883_854_502_9,
        0.733_891_856_627_126,
        0.628_706_721_037_808_6,
        0.538_597_257_223_61,
    ];
    const LEAST_COSINE: f64 = 0.01;
    let uniform = |height: f64, turn: f64| {
        let cos = LEAST_COSINE + (1.0 - LEAST_COSINE) * height;
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        DVec3::new(sin * libm::cos(TAU * turn), sin * libm::sin(TAU * turn), cos)
    };
    let pair = |k: usize| {
        let [a, b, c, d] = STEPS.map(|step| (step * (k as f64 + 1.0)).fract());
        let (eye, light) = (uniform(a, b), uniform(c, d));
        let near = DVec3::new(-eye.x, -eye.y, eye.z) + 0.15 * (light - DVec3::Z);
        let near = near.normalize_or(DVec3::Z);
        let is_near = k % 2 == 1 && near.z > LEAST_COSINE;
        let light = if is_near { near } else { light };
        DirectionPair::new(light, eye).expect("the directions have length 1")
    };
    (0..count).map(pair).collect()
}
