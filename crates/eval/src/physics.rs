//! Physical checks of one program: sign, finiteness, reciprocity, directional albedo.
//!
//! It refuses to know genomes. Figures are those of the canonical evaluator.

use anyhow::Result;
use brood_brdf::{DirectionPair, Input};
use brood_program::Program;
use brood_protocol::Backend;
use brood_scene::SampleSet;
use brood_worker::Renderer;
use glam::{DVec2, DVec3};
use serde::Serialize;

/// Incident directions: rings of theta times azimuths.
const RINGS_I: usize = 16;
const AZIMUTHS_I: usize = 12;
/// Outgoing directions: rings of equal projected solid angle times azimuths.
const RINGS_O: usize = 32;
const AZIMUTHS_O: usize = 64;
/// Texture positions along a side of [0, 1]^2, where the program reads any.
const UV_SIDE: usize = 4;

/// What was found.
#[derive(Debug, Clone, Serialize)]
pub struct Physics {
    /// Reflectances looked at, three a sample.
    pub samples: usize,
    /// Smallest f.
    pub min_f: f32,
    /// Largest f.
    pub max_f: f32,
    /// Values that are NaN or infinite.
    pub non_finite: usize,
    /// Pairs evaluated both ways round.
    pub swapped_pairs: usize,
    /// Of these, those whose bits differ.
    pub not_reciprocal: usize,
    /// Largest integral of f cos_o over the hemisphere, over incident directions, texture positions and channels.
    pub max_albedo: f64,
    /// Where it is largest: theta_i in degrees.
    pub max_albedo_theta_deg: f64,
    /// Samples of each integral.
    pub samples_per_integral: usize,
    /// How many integrals were taken.
    pub integrals: usize,
}

/// Runs all checks.
pub fn check(renderer: &Renderer, program: &Program) -> Result<Physics> {
    let incident = incident();
    let outgoing = outgoing(RINGS_O, AZIMUTHS_O);
    let reads_uv = program.inputs().contains(Input::U) || program.inputs().contains(Input::V);
    let mut physics = Physics {
        samples: 0,
        min_f: f32::INFINITY,
        max_f: 0.0,
        non_finite: 0,
        swapped_pairs: 0,
        not_reciprocal: 0,
        max_albedo: 0.0,
        max_albedo_theta_deg: 0.0,
        samples_per_integral: outgoing.len(),
        integrals: 0,
    };
    let pairs: Vec<DirectionPair> =
        incident.iter().flat_map(|wi| outgoing.iter().map(|wo| pair(*wi, *wo))).collect();
    for uv in texture_positions(reads_uv) {
        let f = evaluate(renderer, program, &pairs, uv)?;
        physics.look_at(&f);
        for (wi, start) in incident.iter().zip((0..pairs.len()).step_by(outgoing.len())) {
            for channel in 0..3 {
                let start = channel * pairs.len() + start;
                physics.integrate(wi, &f[start..start + outgoing.len()]);
            }
        }
    }
    physics.swap(renderer, program, &pairs)?;
    Ok(physics)
}

impl Physics {
    fn look_at(&mut self, f: &[f32]) {
        self.samples += f.len();
        self.non_finite += f.iter().filter(|value| !value.is_finite()).count();
        self.min_f = f.iter().copied().fold(self.min_f, f32::min);
        self.max_f = f.iter().copied().fold(self.max_f, f32::max);
    }

    /// One directional albedo: the rings have equal projected solid angle, so the integral is pi times the mean.
    fn integrate(&mut self, wi: &DVec3, f: &[f32]) {
        let mean = f.iter().copied().map(f64::from).sum::<f64>() / f.len() as f64;
        let albedo = std::f64::consts::PI * mean;
        self.integrals += 1;
        if albedo > self.max_albedo {
            self.max_albedo = albedo;
            self.max_albedo_theta_deg = libm::acos(wi.z).to_degrees();
        }
    }

    fn swap(
        &mut self,
        renderer: &Renderer,
        program: &Program,
        pairs: &[DirectionPair],
    ) -> Result<()> {
        let pairs: Vec<_> = pairs.iter().copied().step_by(7).collect();
        let swapped: Vec<_> = pairs.iter().map(DirectionPair::swapped).collect();
        let uv = DVec2::new(0.3, 0.7);
        let here = evaluate(renderer, program, &pairs, uv)?;
        let there = evaluate(renderer, program, &swapped, uv)?;
        let bits = here.iter().zip(&there);
        self.swapped_pairs = pairs.len();
        self.not_reciprocal = bits.filter(|(a, b)| a.to_bits() != b.to_bits()).count();
        Ok(())
    }
}

/// Canonical f of one program on pairs at one texture position: red, green, blue, each the pairs in order.
pub fn evaluate(
    renderer: &Renderer,
    program: &Program,
    pairs: &[DirectionPair],
    uv: DVec2,
) -> Result<Vec<f32>> {
    let set = SampleSet::from_pairs(pairs, &vec![uv; pairs.len()]);
    Ok(renderer.reflectance(Backend::Cpu, &[program], &set)?)
}

/// A grid over [0, 1]^2, or one position where the program reads none.
pub fn texture_positions(reads_uv: bool) -> Vec<DVec2> {
    if !reads_uv {
        return vec![DVec2::ZERO];
    }
    let side = |index: usize| index as f64 / (UV_SIDE - 1) as f64;
    let place = |index: usize| DVec2::new(side(index % UV_SIDE), side(index / UV_SIDE));
    (0..UV_SIDE * UV_SIDE).map(place).collect()
}

/// Incident directions from the normal to 89 degrees.
pub fn incident() -> Vec<DVec3> {
    let theta = |ring: usize| (89.0 * ring as f64 / (RINGS_I - 1) as f64).to_radians();
    let rings = (0..RINGS_I).flat_map(|ring| (0..AZIMUTHS_I).map(move |step| (ring, step)));
    rings
        .map(|(ring, step)| {
            let (sin, cos) = libm::sincos(theta(ring));
            around(sin, cos, step as f64 / AZIMUTHS_I as f64)
        })
        .collect()
}

/// Midpoints of cells of equal projected solid angle: the integral of f cos is pi times the mean over them.
pub fn outgoing(rings: usize, azimuths: usize) -> Vec<DVec3> {
    let cells = (0..rings).flat_map(|ring| (0..azimuths).map(move |step| (ring, step)));
    cells
        .map(|(ring, step)| {
            let radius_squared = (ring as f64 + 0.5) / rings as f64;
            let turn = (step as f64 + 0.5) / azimuths as f64;
            around(radius_squared.sqrt(), (1.0 - radius_squared).sqrt(), turn)
        })
        .collect()
}

/// The direction with that sine and cosine from the normal, at that share of a turn from x.
pub fn around(sin_theta: f64, cos_theta: f64, turn: f64) -> DVec3 {
    let (sin, cos) = libm::sincos(turn * std::f64::consts::TAU);
    DVec3::new(sin_theta * cos, sin_theta * sin, cos_theta)
}

/// A pair of directions built from sines and cosines.
pub fn pair(wi: DVec3, wo: DVec3) -> DirectionPair {
    DirectionPair::new(wi, wo).expect("built from sines and cosines")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn physics(code: &str) -> Physics {
        let text = format!("brood 1\n.dialect paper smooth registers 7\n{code}\n");
        let program = Program::lower(&text.parse().unwrap());
        check(&Renderer::new(Backend::Cpu), &program).unwrap()
    }

    #[test]
    fn albedo_of_a_constant_is_pi_times_it() {
        let found = physics(".const C0 0.5 0.25 0 0\nMOV R0, C0");
        assert_eq!((found.min_f, found.max_f, found.non_finite), (0.0, 0.25, 0));
        assert!((found.max_albedo - 0.25 * std::f64::consts::PI).abs() < 1e-9, "{found:?}");
        assert_eq!(found.not_reciprocal, 0);
        assert_eq!(found.integrals, 3 * RINGS_I * AZIMUTHS_I);
    }

    #[test]
    fn texture_positions_are_looked_at_when_they_are_read() {
        let found = physics("MOV R0, R1.z");
        assert_eq!(found.max_f, 1.0, "u up to 1");
        assert_eq!(found.samples, 16 * physics("MOV R0, R1.x").samples);
    }
}
