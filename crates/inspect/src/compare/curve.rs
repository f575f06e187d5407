//! Curves over the angle of incidence: directional albedo and brightness of the mirror direction.

use brood_eval::{Quadrature, channel_albedos, direction_at, direction_pair};
use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::Specimen;

/// Angles of incidence in degrees.
const THETA_DEG: [f64; 20] = [
    0.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0, 45.0, 50.0, 55.0, 60.0, 65.0, 70.0, 75.0,
    80.0, 83.0, 86.0, 88.0,
];
/// Order of the albedo quadrature.
const ORDER: usize = 64;
/// Luminance weights of linear red, green and blue (Rec. 709).
const LUMINANCE: DVec3 = DVec3::new(0.2126, 0.7152, 0.0722);

/// Values of both curves at one angle of incidence.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct CurvePoint {
    /// Angle of incidence, in degrees from the normal.
    pub theta_deg: f64,
    /// Directional albedo of red, green and blue: share of light from that direction that is
    /// reflected.
    pub albedo: [f64; 3],
    /// Luminance of the albedo.
    pub luminance: f64,
    /// f cos_i cos_o in the mirror direction relative to normal incidence; for microfacets F G
    /// relative to normal incidence. 0 if nothing is reflected at normal incidence.
    pub mirror: f64,
}

/// Returns both curves of a material, by increasing angle.
#[must_use]
pub fn curves(of: &Specimen<'_>) -> Vec<CurvePoint> {
    let pairs: Vec<_> = THETA_DEG
        .iter()
        .map(|theta| {
            let (sin, cos) = libm::sincos(theta.to_radians());
            direction_pair(direction_at(sin, cos, 0.0), direction_at(sin, cos, 0.5))
        })
        .collect();
    // f of a microfacet model is D G F / (4 cos_i cos_o), and D is the same in every mirror
    // direction.
    let bright: Vec<f64> = of
        .f(&pairs)
        .into_iter()
        .zip(&pairs)
        .map(|(f, pair)| luminance(f) * pair.cos_i() * pair.cos_o())
        .collect();
    let normal = bright[0];
    let over = |value: f64| if normal > 0.0 { value / normal } else { 0.0 };
    let point = |(theta_deg, bright): (&f64, f64)| {
        let albedo = albedo(of, *theta_deg);
        let luminance = luminance(albedo);
        CurvePoint { theta_deg: *theta_deg, albedo, luminance, mirror: over(bright) }
    };
    THETA_DEG.iter().zip(bright).map(point).collect()
}

/// Directional albedo of red, green and blue.
pub(super) fn albedo(of: &Specimen<'_>, theta_deg: f64) -> [f64; 3] {
    match of {
        Specimen::Bred(_, program) => channel_albedos(program, theta_deg, ORDER),
        Specimen::Measured(brdf) => {
            let (sin, cos) = libm::sincos(theta_deg.to_radians());
            let (wi, rule) = (direction_at(sin, cos, 0.0), Quadrature::new(ORDER));
            let f: Vec<DVec3> =
                rule.directions().iter().map(|wo| brdf.f(&direction_pair(wi, *wo))).collect();
            [0, 1, 2].map(|channel| rule.integrate(f.iter().map(|f| f[channel])))
        }
    }
}

/// Returns the luminance of linear RGB (Rec. 709).
#[must_use]
pub fn luminance(rgb: [f64; 3]) -> f64 {
    LUMINANCE.dot(DVec3::from(rgb))
}
