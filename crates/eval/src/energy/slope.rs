//! Quadrature of the directional albedo of a model over the slopes of the half vector.
//!
//! Half vectors are (s_x, s_y, 1), normalised. The directions wo above the horizon are a disc of
//! slopes, so the product rule ends exactly at the horizon. Its nodes are Gauss-Legendre nodes of
//! asinh(s / alpha) along each axis: evenly spread within a highlight of width alpha, and in equal
//! ratios beyond it. Each axis has the width of the highlight along it, so strongly anisotropic
//! highlights are resolved. Derivation: docs/maths/energy.md.

use std::sync::OnceLock;

use brood_brdf::{DirectionPair, gauss_legendre};
use brood_genome::{Model, ModelKind};
use glam::{DVec2, DVec3};

/// Largest slope of a half vector. Directions beyond it have a cosine below about 1e-3 of that of
/// the light's elevation and add less than 1e-6 to an albedo of 1.
const STEEPEST: f64 = 1e3;
/// Least width of a highlight: f is at most 65504^2, so less than 1e-5 is reflected within it.
const NARROWEST: f64 = 1e-8;
/// Numbers of nodes are multiples of this, so that few Gauss-Legendre rules are needed.
const NODE_STEP: usize = 4;
/// Largest number of nodes along an axis, in [`NODE_STEP`]s.
const LONGEST: usize = 64;

/// Nodes of asinh(s / alpha) for each number of nodes, created at first use.
static LINES: [OnceLock<Vec<(f64, f64)>>; LONGEST + 1] = [const { OnceLock::new() }; LONGEST + 1];

/// A product rule over the slopes of half vectors.
#[derive(Debug, Clone, Copy)]
pub(super) struct SlopeRule {
    /// Width of the highlight along x and along y.
    alpha: DVec2,
    /// Spacing of the nodes of asinh(s / alpha).
    spacing: f64,
}

/// Outgoing directions with their weights: the integral of f cos_o is the sum of f times weight.
#[derive(Debug, Default)]
pub(super) struct Nodes {
    pub(super) pairs: Vec<DirectionPair>,
    pub(super) weights: Vec<f64>,
}

impl SlopeRule {
    /// Creates a rule for highlights of that width and wider ones.
    pub(super) fn new(alpha: DVec2, spacing: f64) -> Self {
        Self { alpha: alpha.clamp(DVec2::splat(NARROWEST), DVec2::ONE), spacing }
    }

    /// Replaces `nodes` by those for light from `wi`.
    pub(super) fn fill(&self, wi: DVec3, nodes: &mut Nodes) {
        nodes.pairs.clear();
        nodes.weights.clear();
        let disc = Disc::of(wi);
        // The horizon may cross a highlight at a slant: rows must resolve its narrow side.
        for (y, step_y) in self.line(self.alpha.min_element(), disc.rows()) {
            for (x, step_x) in self.line(self.alpha.x, disc.row(y)) {
                let length2 = 1.0 + x * x + y * y;
                let length = length2.sqrt();
                let half = DVec3::new(x, y, 1.0) / length;
                let cos_d = wi.dot(half);
                let wo = 2.0 * cos_d * half - wi;
                if cos_d <= 0.0 || wo.z <= 0.0 {
                    continue;
                }
                let Ok(pair) = DirectionPair::new(wi, wo) else { continue };
                // d omega_o = 4 cos_d d omega_h, d omega_h = d s_x d s_y / (1 + s^2)^(3/2).
                let weight = 4.0 * cos_d * wo.z * step_x * step_y / (length2 * length);
                nodes.pairs.push(pair);
                nodes.weights.push(weight);
            }
        }
    }

    /// Returns nodes and weights between two slopes.
    fn line(
        &self,
        alpha: f64,
        (low, high): (f64, f64),
    ) -> impl Iterator<Item = (f64, f64)> + use<> {
        let (low, high) = (low.clamp(-STEEPEST, STEEPEST), high.clamp(-STEEPEST, STEEPEST));
        let (first, last) = (libm::asinh(low / alpha), libm::asinh(high / alpha));
        let length = (last - first).max(0.0);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a small positive number"
        )]
        let steps = (length / (self.spacing * NODE_STEP as f64)) as usize;
        let steps = (steps + 1).clamp(2, LONGEST);
        let rule = LINES[steps].get_or_init(|| gauss_legendre(steps * NODE_STEP));
        rule.iter().map(move |(share, weight)| {
            let t = first + length * share;
            let (up, down) = (libm::exp(t), libm::exp(-t));
            // s = alpha sinh t, ds = alpha cosh t dt.
            (0.5 * alpha * (up - down), 0.5 * alpha * (up + down) * length * weight)
        })
    }
}

/// Slopes of the half vectors of all wo above the horizon: a disc with the centre (wi_x, wi_y) /
/// wi_z and the radius 1 / wi_z. It contains the slope 0.
struct Disc {
    wi: DVec3,
}

impl Disc {
    fn of(wi: DVec3) -> Self {
        Self { wi }
    }

    /// Least and largest s_y.
    fn rows(&self) -> (f64, f64) {
        let Self { wi } = self;
        // (wi_y -+ 1) / wi_z without cancellation.
        let (below, above) = (gap(wi.y, wi.x, wi.z), gap(-wi.y, wi.x, wi.z));
        (-below / wi.z, above / wi.z)
    }

    /// Least and largest s_x at a height.
    fn row(&self, y: f64) -> (f64, f64) {
        let Self { wi } = self;
        let along = y * wi.z;
        // radius^2 - (s_y - centre_y)^2, times wi_z^2.
        let chord2 = (gap(wi.y, wi.x, wi.z) + along) * (gap(-wi.y, wi.x, wi.z) - along);
        let centre = wi.x / wi.z;
        let half = chord2.max(0.0).sqrt() / wi.z;
        // The product of both roots; the root of the same sign as the centre has no cancellation.
        let product = y * y - 2.0 * (wi.y / wi.z) * y - 1.0;
        if centre >= 0.0 {
            let far = centre + half;
            (if far > 0.0 { product / far } else { centre }, far)
        } else {
            let far = centre - half;
            (far, product / far)
        }
    }
}

/// 1 - a for the component a of a unit vector with the other components b and c, without
/// cancellation.
fn gap(a: f64, b: f64, c: f64) -> f64 {
    if a > 0.0 { (b * b + c * c) / (1.0 + a) } else { 1.0 - a }
}

/// Returns the width of the narrowest highlight of a model, along x and along y: the slope at which
/// its distribution has fallen noticeably.
pub(super) fn highlight_width(model: &Model) -> DVec2 {
    let value = |name: &str| {
        let values = model.get(name).unwrap_or_else(|| panic!("{} has {name}", model.kind()));
        values.iter().copied().fold(f64::INFINITY, f64::min)
    };
    let even = DVec2::splat;
    match model.kind() {
        ModelKind::Lambert | ModelKind::OrenNayar => DVec2::ONE,
        // The angle from the mirror direction is twice that of the half vector.
        ModelKind::Phong => even((0.5 / value("exponent")).sqrt()),
        ModelKind::BlinnPhong
        | ModelKind::ReflectedBlinnPhong
        | ModelKind::NormalisedBlinnPhong => even((2.0 / value("exponent")).sqrt()),
        ModelKind::CookTorrance | ModelKind::Conductor | ModelKind::Coated
            if is_stretched(model) =>
        {
            let half_stretch = libm::exp2(0.5 * value("stretch"));
            value("roughness") * DVec2::new(half_stretch, 1.0 / half_stretch)
        }
        ModelKind::CookTorrance
        | ModelKind::Conductor
        | ModelKind::Coated
        | ModelKind::RoughPlastic => even(value("roughness")),
        ModelKind::Principled => {
            let aspect = (1.0 - 0.9 * value("anisotropic")).sqrt();
            let alpha = value("roughness") * value("roughness");
            let body = DVec2::new(alpha / aspect, alpha * aspect).max(even(1e-3));
            let coat = 0.1 - 0.099 * value("clearcoat_gloss");
            if value("clearcoat") > 0.0 { body.min(even(coat)) } else { body }
        }
        ModelKind::Ward => DVec2::new(value("alpha_x"), value("alpha_y")),
        ModelKind::AshikhminShirley => {
            DVec2::new((2.0 / value("exponent_u")).sqrt(), (2.0 / value("exponent_v")).sqrt())
        }
        ModelKind::Abc => even((2.0 / value("b")).sqrt()),
        // A power of a = alpha + s^2 / alpha, so the least scale of s is alpha.
        ModelKind::Sgd => even(value("alpha")),
    }
}

/// True if the distribution of the facets of a microfacet model is anisotropic; the others have the
/// geometric mean of both widths, which is the roughness.
fn is_stretched(model: &Model) -> bool {
    let words = model.parameters().find(|(parameter, _)| parameter.name == "distribution");
    let word = words.and_then(|(parameter, values)| parameter.word(values));
    matches!(word, Some("ggx" | "beckmann"))
}
