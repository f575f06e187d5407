//! Microfacets as an expression: D G / (4 cos_i cos_o) for the pair `p`.

use brood_brdf::{DistributionConstants, FacetConstants, Shadowing};
use glam::DVec2;

use super::term::{number, pair};

/// The expression, with functions of `facet.wgsl`.
pub(super) fn facets(facets: &FacetConstants) -> String {
    format!("{} * {}", normals(&facets.distribution), hidden(facets))
}

/// Expression of D.
fn normals(distribution: &DistributionConstants) -> String {
    match *distribution {
        DistributionConstants::Ggx { alpha, height } => {
            format!("brood_ggx(p, {}, {})", pair(1.0 / alpha), number(height))
        }
        DistributionConstants::Beckmann { alpha, height } => {
            let inverse = pair(1.0 / alpha);
            format!("({} * brood_gaussian_over_cos4(p, {inverse}))", number(height))
        }
        DistributionConstants::Gaussian { alpha, height } => {
            let inverse = number(1.0 / alpha);
            format!("({} * brood_gaussian_angle(p, {inverse}))", number(height))
        }
        DistributionConstants::Blinn { exponent, height, .. } => {
            format!("({} * brood_blinn(p, {}))", number(height), number(exponent))
        }
    }
}

/// Expression of G / (4 cos_i cos_o).
fn hidden(facets: &FacetConstants) -> String {
    let (function, alpha) = match facets.distribution {
        DistributionConstants::Ggx { alpha, .. } => ("brood_ggx_unmasked", alpha),
        DistributionConstants::Beckmann { alpha, .. } => ("brood_beckmann_unmasked", alpha),
        DistributionConstants::Gaussian { alpha, .. }
        | DistributionConstants::Blinn { alpha, .. } => {
            ("brood_beckmann_unmasked", DVec2::splat(alpha))
        }
    };
    let alpha2 = pair(alpha * alpha);
    let unmasked = |w: &str| format!("{function}(p.{w}, {alpha2})");
    match facets.shadowing {
        Shadowing::Groove => "brood_groove(p)".to_owned(),
        Shadowing::Separable => format!("brood_smith({}, {})", unmasked("wi"), unmasked("wo")),
        Shadowing::Correlated => {
            format!("brood_smith_correlated(p, {}, {})", unmasked("wi"), unmasked("wo"))
        }
    }
}
