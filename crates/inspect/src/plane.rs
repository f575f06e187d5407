//! Reflectance over a plane of incidence, the data of a polar plot.

use brood_eval::{direction_at, direction_pair, is_anisotropic};
use brood_program::Program;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::evaluate::evaluate;

/// Incident angles from the normal, in degrees.
const INCIDENT_DEG: [f64; 4] = [0.0, 30.0, 60.0, 80.0];
/// Outgoing angles are whole multiples of this up to [`OUTGOING_MAX_DEG`] on either side, in
/// degrees.
const OUTGOING_STEP_DEG: i32 = 2;
const OUTGOING_MAX_DEG: i32 = 88;

/// f with light, eye and normal in one plane, at texture position (1/2, 1/2).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct Plane {
    /// Azimuth of the plane from the direction of texture u, in degrees.
    pub azimuth_deg: f64,
    /// Outgoing angles from the normal in degrees, negative on the side of the light. The mirror
    /// direction has the light's angle with the opposite sign.
    pub theta_o_deg: Vec<f64>,
    /// One curve per incident angle.
    pub curves: Vec<Curve>,
}

/// f for one incident direction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct Curve {
    /// Incident angle from the normal, in degrees.
    pub theta_i_deg: f64,
    /// Red, green and blue, each with one value per outgoing angle.
    pub f: [Vec<f32>; 3],
}

/// Returns the planes along and across u, or one plane if the program is isotropic.
#[must_use]
pub fn planes(program: &Program) -> Vec<Plane> {
    let turns = is_anisotropic(program);
    let azimuths: &[f64] = if turns { &[0.0, 90.0] } else { &[0.0] };
    azimuths.iter().map(|azimuth_deg| plane(program, *azimuth_deg)).collect()
}

/// Returns the curves in the plane of that azimuth.
fn plane(program: &Program, azimuth_deg: f64) -> Plane {
    let steps = OUTGOING_MAX_DEG / OUTGOING_STEP_DEG;
    let theta_o_deg: Vec<f64> =
        (-steps..=steps).map(|step| f64::from(step * OUTGOING_STEP_DEG)).collect();
    // The light is on the side of negative angles.
    let direction = |theta_deg: f64| {
        let (sin, cos) = libm::sincos(theta_deg.to_radians());
        direction_at(sin, cos, azimuth_deg / 360.0)
    };
    let curve = |theta_i_deg: &f64| {
        let wi = direction(-theta_i_deg);
        let pairs: Vec<_> =
            theta_o_deg.iter().map(|theta| direction_pair(wi, direction(*theta))).collect();
        let f = evaluate(program, &pairs, DVec2::splat(0.5));
        let count = pairs.len();
        let channel = |channel: usize| f[channel * count..(channel + 1) * count].to_vec();
        Curve { theta_i_deg: *theta_i_deg, f: std::array::from_fn(channel) }
    };
    Plane { azimuth_deg, curves: INCIDENT_DEG.iter().map(curve).collect(), theta_o_deg }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn planes_of(code: &str) -> Vec<Plane> {
        let text = format!("brood 1\n.dialect paper smooth registers 7\n{code}\n");
        planes(&Program::lower(&text.parse().unwrap()))
    }

    #[test]
    fn plane_has_negative_angles_on_the_side_of_the_light() {
        // g = cos(phi_o - phi_i) sin_i sin_o: -1 times the sines opposite the light, +1 on its
        // side; f = g^2 + p1-free.
        let code = ".const C0 1 1 1 1\nADD R0, R0.y, C0";
        let [plane] = &planes_of(code)[..] else { panic!("one plane") };
        let curve = &plane.curves[2];
        let at = |theta: f64| {
            let index = plane.theta_o_deg.iter().position(|known| *known == theta);
            f64::from(curve.f[0][index.unwrap()])
        };
        let sin = |deg: f64| deg.to_radians().sin();
        let expected = |sign: f64| (1.0 + sign * sin(60.0) * sin(40.0)).powi(2);
        assert!((at(-40.0) - expected(1.0)).abs() < 1e-6);
        assert!((at(40.0) - expected(-1.0)).abs() < 1e-6);
    }

    #[test]
    fn planes_are_two_when_the_program_is_anisotropic() {
        assert_eq!(planes_of("MOV R0, R0.z").len(), 2);
        assert_eq!(planes_of("MOV R0, R1.z").len(), 1);
    }
}
