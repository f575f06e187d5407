//! The energy limit: by how much f has to be divided so that no direction reflects more than it receives.
//!
//! The largest directional albedo is found by quadrature over the hemisphere on a grid of incident directions and texture
//! positions, then by a pattern search around the best of them; the error bound is what doubling the quadrature and
//! the last step of the search still changed.

use anyhow::Result;
use brood_brdf::Input;
use brood_program::Program;
use brood_worker::Renderer;
use glam::{DVec2, DVec3};
use serde::Serialize;

use crate::physics::{around, evaluate, incident, outgoing, pair, texture_positions};

/// Starting points of the search.
const STARTS: usize = 4;
/// Halvings of the search's steps.
const HALVINGS: u32 = 7;
/// Rings of the search's quadrature; there are twice as many azimuths.
const RINGS: usize = 32;
/// Rings of the quadrature whose result is reported.
pub const FINAL_RINGS: usize = 4 * RINGS;
/// The search stays this far below grazing incidence, where the integral loses its meaning.
const THETA_MAX: f64 = 89.5;

/// What was found.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct EnergyLimit {
    /// The largest directional albedo of any channel.
    pub albedo: f64,
    /// Relative error bound of it, estimated.
    pub error_bound: f64,
    /// max(1, albedo (1 + error bound)): what f is divided by.
    pub divisor: f64,
    /// Where it is largest.
    pub theta_deg: f64,
}

/// An incident direction and a texture position.
#[derive(Debug, Clone, Copy)]
pub struct Place {
    theta_deg: f64,
    turn: f64,
    /// Texture position.
    pub uv: DVec2,
}

impl Place {
    /// The incident direction.
    pub fn direction(&self) -> DVec3 {
        let (sin, cos) = libm::sincos(self.theta_deg.to_radians());
        around(sin, cos, self.turn)
    }
}

/// The limit of one program, its output stage included.
pub fn limit(renderer: &Renderer, program: &Program) -> Result<EnergyLimit> {
    Ok(search(renderer, program)?.0)
}

/// The largest albedo of the channels at a place, by a quadrature of that many rings.
pub fn albedo(renderer: &Renderer, program: &Program, place: &Place, rings: usize) -> Result<f64> {
    Ok(best(&measure(renderer, program, vec![*place], rings)?).1)
}

/// The limit, and the place where the albedo is largest.
pub fn search(renderer: &Renderer, program: &Program) -> Result<(EnergyLimit, Place)> {
    let reads_uv = program.inputs().contains(Input::U) || program.inputs().contains(Input::V);
    let mut places = Vec::new();
    for uv in texture_positions(reads_uv) {
        places.extend(incident().into_iter().map(|wi| Place {
            theta_deg: libm::acos(wi.z.clamp(-1.0, 1.0)).to_degrees(),
            turn: libm::atan2(wi.y, wi.x) / std::f64::consts::TAU,
            uv,
        }));
    }
    let mut ranked = measure(renderer, program, places, RINGS)?;
    ranked.sort_by(|a, b| b.1.total_cmp(&a.1));
    ranked.truncate(STARTS);
    let mut last_gain = 0.0;
    let mut step = Place { theta_deg: 3.0, turn: 1.0 / 24.0, uv: DVec2::splat(1.0 / 6.0) };
    for _ in 0..HALVINGS {
        let before = best(&ranked).1;
        for (place, albedo) in &mut ranked {
            let around = neighbours(place, &step, reads_uv);
            let found = measure(renderer, program, around, RINGS)?;
            let (better, value) = best(&found);
            if value > *albedo {
                (*place, *albedo) = (better, value);
            }
        }
        last_gain = best(&ranked).1 - before;
        step.theta_deg *= 0.5;
        step.turn *= 0.5;
        step.uv *= 0.5;
    }
    let (place, _) = best(&ranked);
    let at = |rings| albedo(renderer, program, &place, rings);
    let (coarser, coarse, albedo) = (at(FINAL_RINGS / 4)?, at(FINAL_RINGS / 2)?, at(FINAL_RINGS)?);
    // Where clamps put kinks into f, errors do not fall evenly, and one small change proves little.
    let change = (albedo - coarse).abs().max(0.5 * (coarse - coarser).abs()) + last_gain;
    let error_bound = if albedo > 0.0 { change / albedo } else { 0.0 };
    let divisor = (albedo * (1.0 + error_bound)).max(1.0);
    let limit = EnergyLimit { albedo, error_bound, divisor, theta_deg: place.theta_deg };
    Ok((limit, place))
}

fn neighbours(place: &Place, step: &Place, reads_uv: bool) -> Vec<Place> {
    let mut all = Vec::new();
    for sign in [-1.0, 1.0] {
        let theta_deg = (place.theta_deg + sign * step.theta_deg).clamp(0.0, THETA_MAX);
        all.push(Place { theta_deg, ..*place });
        all.push(Place { turn: place.turn + sign * step.turn, ..*place });
        if reads_uv {
            for axis in [DVec2::X, DVec2::Y] {
                let uv = (place.uv + axis * step.uv * sign).clamp(DVec2::ZERO, DVec2::ONE);
                all.push(Place { uv, ..*place });
            }
        }
    }
    all
}

/// The largest albedo of the channels at each place.
fn measure(
    renderer: &Renderer,
    program: &Program,
    places: Vec<Place>,
    rings: usize,
) -> Result<Vec<(Place, f64)>> {
    let directions = outgoing(rings, 2 * rings);
    let mut found = Vec::with_capacity(places.len());
    for place in places {
        let wi = place.direction();
        let pairs: Vec<_> = directions.iter().map(|wo| pair(wi, *wo)).collect();
        let f = evaluate(renderer, program, &pairs, place.uv)?;
        let albedo = f
            .chunks(pairs.len())
            .map(|f| f.iter().copied().map(f64::from).sum::<f64>() / f.len() as f64)
            .fold(0.0, f64::max);
        found.push((place, std::f64::consts::PI * albedo));
    }
    Ok(found)
}

fn best(found: &[(Place, f64)]) -> (Place, f64) {
    let best = found.iter().max_by(|a, b| a.1.total_cmp(&b.1));
    *best.expect("there is always a place to look at")
}

#[cfg(test)]
mod tests {
    use brood_protocol::Backend;

    use super::*;

    fn limit_of(code: &str) -> EnergyLimit {
        let text = format!("brood 1\n.dialect paper smooth registers 7\n{code}\n");
        let program = Program::lower(&text.parse().unwrap());
        limit(&Renderer::new(Backend::Cpu), &program).unwrap()
    }

    #[test]
    fn constant_is_divided_by_pi_times_it() {
        let found = limit_of(".const C0 2 1 0 0\nMOV R0, C0");
        assert!((found.divisor - 4.0 * std::f64::consts::PI).abs() < 1e-6, "{found:?}");
        assert!(limit_of(".const C0 0.5 0.5 0 0\nMOV R0, C0").divisor <= 1.0);
    }

    #[test]
    fn maximum_at_normal_incidence_is_found() {
        // g = cos_i + cos_o: the albedo is pi (c^2 + 4 c / 3 + 1 / 2), largest at c = 1.
        let found = limit_of("MOV R0, R0.x");
        let expected = std::f64::consts::PI * (1.0 + 4.0 / 3.0 + 0.5);
        assert!((found.albedo - expected).abs() < 1e-3 * expected, "{found:?} {expected}");
        assert!(found.divisor >= expected, "{found:?}");
        assert!(found.theta_deg < 1.0, "{found:?}");
    }

    #[test]
    fn texture_positions_are_searched_when_they_are_read() {
        let found = limit_of("MOV R0, R1.z");
        assert!((found.albedo - std::f64::consts::PI).abs() < 1e-6, "u = 1: {found:?}");
    }
}
