//! Microfacets as an expression: D G / (4 cos_i cos_o) for the pair `p`.

use brood_brdf::{DistributionConstants, FacetConstants, Shadowing};
use glam::DVec2;

use super::term::Terms;

/// The expression, with functions of `facet.glsl` and `facet.wgsl`.
pub(super) fn facets(facets: &FacetConstants, terms: Terms) -> String {
    format!("{} * {}", normals(&facets.distribution, terms), hidden(facets, terms))
}

/// Expression of D.
fn normals(distribution: &DistributionConstants, terms: Terms) -> String {
    match *distribution {
        DistributionConstants::Ggx { alpha, height } => {
            format!("brood_ggx(p, {}, {})", terms.pair(1.0 / alpha), terms.number(height))
        }
        DistributionConstants::Beckmann { alpha, height } => {
            let inverse = terms.pair(1.0 / alpha);
            format!("({} * brood_gaussian_over_cos4(p, {inverse}))", terms.number(height))
        }
        DistributionConstants::Gaussian { alpha, height } => {
            let inverse = terms.number(1.0 / alpha);
            format!("({} * brood_gaussian_angle(p, {inverse}))", terms.number(height))
        }
        DistributionConstants::Blinn { exponent, height, .. } => {
            format!("({} * brood_blinn(p, {}))", terms.number(height), terms.number(exponent))
        }
    }
}

/// Expression of G / (4 cos_i cos_o).
fn hidden(facets: &FacetConstants, terms: Terms) -> String {
    let (function, alpha) = match facets.distribution {
        DistributionConstants::Ggx { alpha, .. } => ("brood_ggx_unmasked", alpha),
        DistributionConstants::Beckmann { alpha, .. } => ("brood_beckmann_unmasked", alpha),
        DistributionConstants::Gaussian { alpha, .. }
        | DistributionConstants::Blinn { alpha, .. } => {
            ("brood_beckmann_unmasked", DVec2::splat(alpha))
        }
    };
    let alpha2 = terms.pair(alpha * alpha);
    let unmasked = |w: &str| format!("{function}(p.{w}, {alpha2})");
    match facets.shadowing {
        Shadowing::Groove => "brood_groove(p)".to_owned(),
        Shadowing::Separable => format!("brood_smith({}, {})", unmasked("wi"), unmasked("wo")),
        Shadowing::Correlated => {
            format!("brood_smith_correlated(p, {}, {})", unmasked("wi"), unmasked("wo"))
        }
    }
}
