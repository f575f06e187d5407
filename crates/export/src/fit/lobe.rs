//! Lobes of which fits are sums: those that Cycles evaluates for plain shader nodes.
//!
//! `cargo xtask accept --exports` compares the formulas with pixels of Cycles.
//!
//! Sources: Walter et al. 2007, Microfacet models for refraction through rough surfaces; Heitz
//! 2014, Understanding the masking-shadowing function, for shadowing correlated by height;
//! Ashikhmin, Premoze and Shirley 2000, A microfacet-based BRDF generator, for velvet.

use std::f64::consts::FRAC_1_PI;

use brood_brdf::DirectionPair;
use glam::DVec3;

/// Widths of upright lobes of GGX, alpha. Blender's roughness is the square root.
const ALPHAS: [f64; 13] =
    [0.01, 0.018, 0.03, 0.045, 0.065, 0.09, 0.13, 0.18, 0.25, 0.34, 0.46, 0.65, 0.9];
/// Widths of upright lobes of Beckmann, which end sooner.
const BECKMANN_ALPHAS: [f64; 9] = [0.02, 0.04, 0.07, 0.11, 0.17, 0.25, 0.35, 0.5, 0.7];
/// Widths of lobes about the normal of half the inclination of the eye: they peak at the normal.
const HALF_ALPHAS: [f64; 2] = [0.15, 0.4];
/// Widths of lobes about the direction to the eye: they return light to where it came from.
const EYE_ALPHAS: [f64; 3] = [0.06, 0.15, 0.35];
/// Widths of velvet, sigma.
const SIGMAS: [f64; 3] = [0.2, 0.45, 1.0];
/// Anisotropies of lobes of anisotropic materials; alpha is multiplied by 1 - a along the tangent
/// and divided by it across. Negative ones exchange the two.
const ANISOTROPIES: [f64; 4] = [-0.65, -0.35, 0.35, 0.65];
/// Widths of anisotropic lobes.
const ANISOTROPIC_ALPHAS: [f64; 4] = [0.07, 0.15, 0.3, 0.5];
/// Largest square of the cosine between normal and half vector at which velvet reflects.
const VELVET_UPRIGHT: f64 = 1.0 - 1e-5;

/// Normal about which a lobe of GGX is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Lean {
    /// The surface's normal.
    Upright,
    /// The unit vector between the normal and the direction to the eye.
    Half,
    /// The direction to the eye.
    Eye,
}

/// Distribution of the normals of facets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Facets {
    Ggx,
    Beckmann,
}

/// A lobe with weight 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Lobe {
    /// Lambert's.
    Diffuse,
    /// Facets without Fresnel term; `anisotropy` is 0 unless upright.
    Glossy { facets: Facets, alpha: f64, anisotropy: f64, lean: Lean },
    /// Ashikhmin's velvet.
    Velvet { sigma: f64 },
}

impl Lobe {
    /// Lobes that a fit may choose.
    pub(super) fn candidates(is_anisotropic: bool) -> Vec<Self> {
        let facets = Facets::Ggx;
        let ggx = |lean, anisotropy| move |alpha| Self::Glossy { facets, alpha, anisotropy, lean };
        let beckmann = |alpha| {
            let facets = Facets::Beckmann;
            Self::Glossy { facets, alpha, anisotropy: 0.0, lean: Lean::Upright }
        };
        let mut lobes = vec![Self::Diffuse];
        lobes.extend(ALPHAS.map(ggx(Lean::Upright, 0.0)));
        lobes.extend(BECKMANN_ALPHAS.map(beckmann));
        if is_anisotropic {
            let turned = |anisotropy| ANISOTROPIC_ALPHAS.map(ggx(Lean::Upright, anisotropy));
            lobes.extend(ANISOTROPIES.into_iter().flat_map(turned));
        }
        lobes.extend(HALF_ALPHAS.map(ggx(Lean::Half, 0.0)));
        lobes.extend(EYE_ALPHAS.map(ggx(Lean::Eye, 0.0)));
        lobes.extend(SIGMAS.map(|sigma| Self::Velvet { sigma }));
        lobes
    }

    /// f cos_i of a pair above the surface, in 1/sr.
    pub(super) fn value(self, pair: &DirectionPair) -> f64 {
        let (light, eye) = (pair.wi(), pair.wo());
        match self {
            Self::Diffuse => FRAC_1_PI * light.z,
            Self::Velvet { sigma } => velvet(light, eye, sigma),
            Self::Glossy { facets, alpha, anisotropy, lean } => {
                let normal = match lean {
                    Lean::Upright => return glossy(light, eye, facets, widths(alpha, anisotropy)),
                    Lean::Half => (eye + DVec3::Z).normalize(),
                    Lean::Eye => eye,
                };
                let (tangent, bitangent) = normal.any_orthonormal_pair();
                let local = |w: DVec3| DVec3::new(w.dot(tangent), w.dot(bitangent), w.dot(normal));
                glossy(local(light), local(eye), facets, [alpha; 2])
            }
        }
    }
}

/// Widths along the tangent and across, at most 1 as in Cycles.
pub(super) fn widths(alpha: f64, anisotropy: f64) -> [f64; 2] {
    let widths = match anisotropy < 0.0 {
        true => [alpha / (1.0 + anisotropy), alpha * (1.0 + anisotropy)],
        false => [alpha * (1.0 - anisotropy), alpha / (1.0 - anisotropy)],
    };
    widths.map(|width| width.min(1.0))
}

/// Facets with shadowing and masking correlated by height, times cos_i; the normal is z.
fn glossy(light: DVec3, eye: DVec3, facets: Facets, [along, across]: [f64; 2]) -> f64 {
    if light.z <= 0.0 || eye.z <= 0.0 {
        return 0.0;
    }
    let half = (light + eye).normalize();
    let tan2 = DVec3::new(half.x / along, half.y / across, 0.0).length_squared() / half.z.powi(2);
    let shape = match facets {
        Facets::Ggx => 1.0 / (1.0 + tan2).powi(2),
        Facets::Beckmann => libm::exp(-tan2),
    };
    let density = FRAC_1_PI * shape / (along * across * half.z.powi(4));
    let lambda = |w: DVec3| {
        let tan2 = DVec3::new(along * w.x, across * w.y, 0.0).length_squared() / (w.z * w.z);
        match facets {
            Facets::Ggx => 0.5 * ((1.0 + tan2).sqrt() - 1.0),
            Facets::Beckmann => beckmann_lambda(1.0 / tan2.sqrt()),
        }
    };
    density / (1.0 + lambda(light) + lambda(eye)) / (4.0 * eye.z)
}

/// Walter's rational approximation, which Cycles uses.
fn beckmann_lambda(a: f64) -> f64 {
    if a > 1.6 {
        return 0.0;
    }
    ((0.396 * a - 1.259) * a + 1.0) / ((2.181 * a + 3.535) * a)
}

/// Velvet, times cos_i.
fn velvet(light: DVec3, eye: DVec3, sigma: f64) -> f64 {
    let half = (light + eye).normalize();
    let cos2 = half.z * half.z;
    if cos2 > VELVET_UPRIGHT {
        return 0.0;
    }
    let sin2 = 1.0 - cos2;
    let inverse = 1.0 / (sigma * sigma);
    let density = libm::exp(-inverse * cos2 / sin2) * inverse * FRAC_1_PI / (sin2 * sin2);
    let ratio = 2.0 * half.z / half.dot(light);
    let shadow = (ratio * light.z).min(ratio * eye.z).min(1.0);
    0.25 * density * shadow / eye.z
}
