//! Curves over the angle of incidence: how much is reflected in all, and how bright the mirror direction is.

use brood_eval::{Quadrature, around, channel_albedos, pair};
use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::Specimen;

/// Degrees of incidence.
const THETA_DEG: [f64; 20] = [
    0.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0, 45.0, 50.0, 55.0, 60.0, 65.0, 70.0, 75.0,
    80.0, 83.0, 86.0, 88.0,
];
/// Order of the quadratures.
const ORDER: usize = 64;
/// What the eye makes of linear red, green and blue (Rec. 709).
const LUMINANCE: DVec3 = DVec3::new(0.2126, 0.7152, 0.0722);

/// Both curves at one angle of incidence.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct CurvePoint {
    /// The angle, degrees from the normal.
    pub theta_deg: f64,
    /// Directional albedo of red, green and blue: the share of light from that direction that is sent back in all.
    pub albedo: [f64; 3],
    /// What the eye makes of the three.
    pub luminance: f64,
    /// f towards the mirror direction times cos_i cos_o, over the same at normal incidence: for facets of one shape F G over
    /// that of the normal. 0 where nothing is reflected at the normal.
    pub mirror: f64,
}

/// Both curves of a material, by rising angle.
#[must_use]
pub fn curves(of: &Specimen<'_>) -> Vec<CurvePoint> {
    let pairs: Vec<_> = THETA_DEG
        .iter()
        .map(|theta| {
            let (sin, cos) = libm::sincos(theta.to_radians());
            pair(around(sin, cos, 0.0), around(sin, cos, 0.5))
        })
        .collect();
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

/// Directional albedo of the channels.
pub(super) fn albedo(of: &Specimen<'_>, theta_deg: f64) -> [f64; 3] {
    match of {
        Specimen::Bred(_, program) => channel_albedos(program, theta_deg, ORDER),
        Specimen::Measured(brdf) => {
            let (sin, cos) = libm::sincos(theta_deg.to_radians());
            let (wi, rule) = (around(sin, cos, 0.0), Quadrature::new(ORDER));
            let f: Vec<DVec3> = rule.directions().iter().map(|wo| brdf.f(&pair(wi, *wo))).collect();
            [0, 1, 2].map(|channel| rule.integrate(f.iter().map(|f| f[channel])))
        }
    }
}

/// Luminance of a colour.
#[must_use]
pub fn luminance(rgb: [f64; 3]) -> f64 {
    LUMINANCE.dot(DVec3::from(rgb))
}
