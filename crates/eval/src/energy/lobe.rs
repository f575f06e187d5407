//! Quadrature of directional albedos with highlights that may be narrower than any uniform rule
//! resolves, for functions whose width is not known: searches and evolved programs.
//!
//! The integral is split by a smooth weight of theta_h, the angle between half vector and normal.
//! Where it is large, the uniform rule of [`Quadrature`] is used. Where it is small, nodes are half
//! vectors spread over ln tan theta_h: in this coordinate a lobe of any width is a bump of about
//! the same shape.

use brood_brdf::{DirectionPair, gauss_legendre};
use glam::DVec3;

use super::hemisphere::{Quadrature, direction_at};

/// Range of ln tan theta_h: from the narrowest lobe considered to where the uniform rule has almost
/// all of the weight.
const SPAN: (f64, f64) = (-14.0, 1.0);
/// tan theta_h where each rule has half of the weight.
const BORDER: f64 = 0.25;

/// A rule for integrals of f cos_o over wo.
#[derive(Debug, Clone)]
pub struct LobeRule {
    uniform: Quadrature,
    /// Half vectors near the normal, each with its solid angle times the weight of this part of the
    /// integral.
    nodes: Vec<(DVec3, f64)>,
}

/// Returns the weight of the part near the normal, by tan^2 theta_h; the other part has the rest.
fn near(tan2: f64) -> f64 {
    let ratio = tan2 / (BORDER * BORDER);
    1.0 / (1.0 + ratio * ratio)
}

impl LobeRule {
    /// Creates the uniform rule of that order, and half vectors at twice `order` angles and
    /// azimuths.
    #[must_use]
    pub fn new(order: usize) -> Self {
        let turns = 2 * order;
        let (low, high) = SPAN;
        let mut nodes = Vec::with_capacity(turns * turns);
        for (share, weight) in gauss_legendre(turns) {
            let tan = libm::exp(low + (high - low) * share);
            let cos = 1.0 / (1.0 + tan * tan).sqrt();
            let sin = tan * cos;
            // d omega = sin theta d theta d phi, and d theta = sin theta cos theta d ln tan theta.
            let ring = sin * sin * cos * weight * (high - low) * near(tan * tan);
            let step = std::f64::consts::TAU / turns as f64;
            let node = |turn: usize| {
                (direction_at(sin, cos, (turn as f64 + 0.5) / turns as f64), ring * step)
            };
            nodes.extend((0..turns).map(node));
        }
        Self { uniform: Quadrature::new(order), nodes }
    }

    /// Number of values per albedo.
    pub(super) fn len(&self) -> usize {
        self.nodes.len() + self.uniform.directions().len()
    }

    /// Returns the direction pairs above the horizon and their weights: the integral of f cos_o is
    /// the sum of f times weight.
    #[must_use]
    pub fn nodes(&self, wi: DVec3) -> Vec<(DirectionPair, f64)> {
        let around_half = self.nodes.iter().filter_map(|(half, weight)| {
            let cos_d = wi.dot(*half);
            let wo = 2.0 * cos_d * *half - wi;
            (cos_d > 0.0 && wo.z > 0.0).then_some((wo.normalize(), 4.0 * cos_d * wo.z * weight))
        });
        let uniform =
            self.uniform.weighted().map(|(wo, weight)| (wo, weight * (1.0 - near(tan2(wi, wo)))));
        let pair = |(wo, weight)| DirectionPair::new(wi, wo).ok().map(|pair| (pair, weight));
        around_half.chain(uniform).filter_map(pair).collect()
    }
}

/// tan^2 theta_h.
fn tan2(wi: DVec3, wo: DVec3) -> f64 {
    let half = wi + wo;
    (half.x * half.x + half.y * half.y) / (half.z * half.z)
}

#[cfg(test)]
mod tests {
    use brood_brdf::Brdf;
    use brood_genome::{Model, ModelKind};

    use super::*;

    fn albedo(rule: &LobeRule, model: &Model, wi: DVec3) -> DVec3 {
        let brdf = model.prepare();
        rule.nodes(wi).into_iter().map(|(pair, weight)| brdf.f(&pair) * weight).sum()
    }

    fn metal(roughness: f64) -> Model {
        Model::new(ModelKind::CookTorrance)
            .with("f0", &[1.0; 3])
            .and_then(|model| model.with("roughness", &[roughness]))
            .unwrap()
    }

    #[test]
    fn lambert_reflects_its_albedo_at_every_angle() {
        let model = Model::new(ModelKind::Lambert);
        for theta in [0.0, 0.5, 1.2, 1.55] {
            let wi = direction_at(libm::sin(theta), libm::cos(theta), 0.1);
            let found = albedo(&LobeRule::new(32), &model, wi);
            assert!((found - DVec3::splat(0.5)).abs().max_element() < 2e-3, "{theta} {found}");
        }
    }

    #[test]
    fn wide_lobes_agree_with_the_uniform_rule() {
        let uniform = Quadrature::new(300);
        for (roughness, theta) in [(0.1, 0.6), (0.1, 1.4), (0.3, 0.1), (0.6, 1.2), (1.0, 0.8)] {
            let (model, wi) =
                (metal(roughness), direction_at(libm::sin(theta), libm::cos(theta), 0.3));
            let brdf = model.prepare();
            let f = |wo: &DVec3| brdf.f(&DirectionPair::new(wi, *wo).unwrap()).x;
            let expected = uniform.integrate(uniform.directions().iter().map(f));
            let found = albedo(&LobeRule::new(32), &model, wi).x;
            assert!(
                (found - expected).abs() < 2e-3 * expected,
                "{roughness} {theta}: {found} {expected}"
            );
        }
    }

    #[test]
    fn narrow_lobes_reflect_nearly_everything() {
        for roughness in [0.02, 1e-3, 1e-4] {
            let wi = direction_at(0.6, 0.8, 0.0);
            let found = albedo(&LobeRule::new(32), &metal(roughness), wi).x;
            assert!((0.995..1.002).contains(&found), "{roughness}: {found}");
        }
    }
}
