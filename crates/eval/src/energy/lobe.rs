//! Quadrature of directional albedos of models, whose lobes may be narrower than any uniform rule
//! resolves.
//!
//! The integral is split by a smooth weight of theta_h, the angle between half vector and normal.
//! Where it is large, the uniform rule of [`Quadrature`] is used. Where it is small, nodes are half
//! vectors spread over ln tan theta_h: in this coordinate a lobe of any width is a bump of about
//! the same shape.

use brood_brdf::DirectionPair;
use glam::DVec3;

use super::hemisphere::{Quadrature, direction_at, gauss_legendre};
use crate::layer::Layers;

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

    /// Returns the directional albedo of each channel. Sums are f64 in a fixed order.
    pub(super) fn albedo(&self, layers: &Layers, wi: DVec3) -> DVec3 {
        let mut sum = DVec3::ZERO;
        for (half, weight) in &self.nodes {
            let cos_d = wi.dot(*half);
            let wo = 2.0 * cos_d * *half - wi;
            if cos_d <= 0.0 || wo.z <= 0.0 {
                continue;
            }
            // d omega_o = 4 (wi . h) d omega_h.
            sum += f(layers, wi, wo) * (4.0 * cos_d * wo.z * weight);
        }
        let far: Vec<DVec3> = self
            .uniform
            .directions()
            .iter()
            .map(|wo| f(layers, wi, *wo) * (1.0 - near(tan2(wi, *wo))))
            .collect();
        let channel = |channel: usize| self.uniform.integrate(far.iter().map(|f| f[channel]));
        sum + DVec3::new(channel(0), channel(1), channel(2))
    }
}

/// tan^2 theta_h.
fn tan2(wi: DVec3, wo: DVec3) -> f64 {
    let half = wi + wo;
    (half.x * half.x + half.y * half.y) / (half.z * half.z)
}

/// Returns f of two directions; 0 if `wo` cannot be normalised.
fn f(layers: &Layers, wi: DVec3, wo: DVec3) -> DVec3 {
    DirectionPair::new(wi, wo.normalize_or_zero()).map_or(DVec3::ZERO, |pair| layers.f(&pair))
}

#[cfg(test)]
mod tests {
    use brood_genome::{Genome, Model, ModelKind};
    use brood_program::Program;

    use super::*;

    fn layers(model: Model) -> Layers {
        let genome = Genome::of_models(vec![model]).unwrap();
        Layers::of(&Program::lower(&genome)).unwrap()
    }

    #[test]
    fn lambert_reflects_its_albedo_at_every_angle() {
        let layers = layers(Model::new(ModelKind::Lambert));
        for theta in [0.0, 0.5, 1.2, 1.55] {
            let wi = direction_at(libm::sin(theta), libm::cos(theta), 0.1);
            let found = LobeRule::new(32).albedo(&layers, wi);
            assert!((found - DVec3::splat(0.5)).abs().max_element() < 2e-3, "{theta} {found}");
        }
    }

    fn metal(roughness: f64) -> Layers {
        let model = Model::new(ModelKind::CookTorrance)
            .with("f0", &[1.0; 3])
            .and_then(|model| model.with("roughness", &[roughness]))
            .unwrap();
        layers(model)
    }

    #[test]
    fn wide_lobes_agree_with_the_uniform_rule() {
        let uniform = Quadrature::new(300);
        for (roughness, theta) in [(0.1, 0.6), (0.1, 1.4), (0.3, 0.1), (0.6, 1.2), (1.0, 0.8)] {
            let (layers, wi) =
                (metal(roughness), direction_at(libm::sin(theta), libm::cos(theta), 0.3));
            let expected =
                uniform.integrate(uniform.directions().iter().map(|wo| f(&layers, wi, *wo).x));
            let found = LobeRule::new(32).albedo(&layers, wi).x;
            assert!(
                (found - expected).abs() < 2e-3 * expected,
                "{roughness} {theta}: {found} {expected}"
            );
        }
    }

    #[test]
    fn weighted_nodes_sum_to_the_albedo() {
        let (layers, rule) = (metal(0.2), LobeRule::new(16));
        for theta in [0.0, 0.9, 1.5] {
            let wi = direction_at(libm::sin(theta), libm::cos(theta), 0.2);
            let nodes = rule.nodes(wi);
            assert!(nodes.len() <= rule.len());
            let sum: DVec3 = nodes.iter().map(|(pair, weight)| layers.f(pair) * *weight).sum();
            assert!((sum - rule.albedo(&layers, wi)).length() < 1e-12, "{theta}");
        }
    }

    #[test]
    fn narrow_lobes_reflect_nearly_everything() {
        for roughness in [0.02, 1e-3, 1e-4] {
            let found = LobeRule::new(32).albedo(&metal(roughness), direction_at(0.6, 0.8, 0.0)).x;
            assert!((0.995..1.002).contains(&found), "{roughness}: {found}");
        }
    }
}
