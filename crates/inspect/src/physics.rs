//! Physical checks of a program: sign, finiteness, reciprocity.

use brood_brdf::{DirectionPair, Input};
use brood_eval::{Quadrature, direction_at, direction_pair};
use brood_program::Program;
use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

use crate::evaluate::evaluate;

/// Rings of incident directions, from the normal to 89 degrees.
const RINGS: usize = 16;
/// Azimuths of incident directions.
const AZIMUTHS: usize = 12;
/// Rings of outgoing directions, each with twice that number of azimuths.
const ORDER: usize = 12;
/// Texture positions along a side of [0, 1]^2, if the program reads them.
const UV_SIDE: usize = 4;
/// One of this number of pairs is also evaluated with swapped directions.
const SWAP_STEP: usize = 7;

/// Results of the checks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct Physics {
    /// Number of reflectances checked, three per sample.
    pub samples: usize,
    /// Smallest f.
    pub min_f: f32,
    /// Largest f.
    pub max_f: f32,
    /// Number of NaN or infinite values.
    pub non_finite: usize,
    /// Number of pairs also evaluated with swapped directions.
    pub swapped_pairs: usize,
    /// Number of swapped pairs whose bits differ.
    pub not_reciprocal: usize,
}

impl Physics {
    /// Runs all checks on a grid of directions and texture positions.
    pub(crate) fn of(program: &Program) -> Self {
        let rule = Quadrature::new(ORDER);
        let pairs: Vec<DirectionPair> = incident()
            .flat_map(|wi| rule.directions().iter().map(move |wo| direction_pair(wi, *wo)))
            .collect();
        let mut physics = Self {
            samples: 0,
            min_f: f32::INFINITY,
            max_f: 0.0,
            non_finite: 0,
            swapped_pairs: 0,
            not_reciprocal: 0,
        };
        let inputs = program.inputs();
        for uv in texture_positions(inputs.contains(Input::U), inputs.contains(Input::V)) {
            physics.add(&evaluate(program, &pairs, uv));
        }
        physics.check_swapped(program, &pairs);
        physics
    }

    /// Adds reflectances to the counts and extremes.
    fn add(&mut self, f: &[f32]) {
        self.samples += f.len();
        self.non_finite += f.iter().filter(|value| !value.is_finite()).count();
        self.min_f = f.iter().copied().fold(self.min_f, f32::min);
        self.max_f = f.iter().copied().fold(self.max_f, f32::max);
    }

    /// Compares some pairs with the swapped ones at one texture position.
    fn check_swapped(&mut self, program: &Program, pairs: &[DirectionPair]) {
        let pairs: Vec<_> = pairs.iter().copied().step_by(SWAP_STEP).collect();
        let swapped: Vec<_> = pairs.iter().map(DirectionPair::swapped).collect();
        let uv = DVec2::new(0.3, 0.7);
        let forward = evaluate(program, &pairs, uv);
        let backward = evaluate(program, &swapped, uv);
        let bits = forward.iter().zip(&backward);
        self.swapped_pairs = pairs.len();
        self.not_reciprocal = bits.filter(|(a, b)| a.to_bits() != b.to_bits()).count();
    }
}

/// Grid over [0, 1]^2 in the coordinates the program reads.
fn texture_positions(reads_u: bool, reads_v: bool) -> impl Iterator<Item = DVec2> {
    let side = |index: usize| index as f64 / (UV_SIDE - 1) as f64;
    let count = |reads: bool| if reads { UV_SIDE } else { 1 };
    let rows = 0..count(reads_v);
    rows.flat_map(move |v| (0..count(reads_u)).map(move |u| DVec2::new(side(u), side(v))))
}

/// Incident directions, ring by ring from the normal.
fn incident() -> impl Iterator<Item = DVec3> {
    let rings = (0..RINGS).flat_map(|ring| (0..AZIMUTHS).map(move |step| (ring, step)));
    rings.map(|(ring, step)| {
        let theta: f64 = 89.0 * ring as f64 / (RINGS - 1) as f64;
        let (sin, cos) = libm::sincos(theta.to_radians());
        direction_at(sin, cos, step as f64 / AZIMUTHS as f64)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn physics(code: &str) -> Physics {
        let text = format!("brood 1\n.dialect paper smooth registers 7\n{code}\n");
        Physics::of(&Program::lower(&text.parse().unwrap()))
    }

    #[test]
    fn extremes_equal_the_constant_when_f_is_constant() {
        let found = physics(".const C0 0.5 0.25 0 0\nMOV R0, C0");
        assert_eq!((found.min_f, found.max_f, found.non_finite), (0.0, 0.25, 0));
        assert!(found.swapped_pairs > 1000);
        assert_eq!(found.not_reciprocal, 0);
    }

    #[test]
    fn texture_positions_are_sampled_when_the_program_reads_them() {
        let found = physics("MOV R0, R1.z");
        assert_eq!(found.max_f, 1.0, "u up to 1");
        let both = physics("MUL R0, R1.z, R1.w");
        assert_eq!(both.samples, 4 * found.samples);
        assert_eq!(found.samples, 4 * physics("MOV R0, R1.x").samples);
    }
}
