//! Quadratures of the directional albedos of models, and the residual that keeps them below 1.
//!
//! A picture with one light shows the surface at few angles. A model fitted there may reflect
//! hundreds of times the light from other angles. The energy limit divides f by the largest albedo,
//! which makes such a fit too dark at all angles.

use brood_brdf::{Block, DirectionPair};
use brood_eval::{Level, LobeRule, direction_at};
use rayon::prelude::*;

use super::LANES;
use crate::lobes::{ANGLES, IMPORTANCE};

/// Quadrature orders ([`LobeRule`]): coarse for the steps (up to 25 % off for light from the
/// horizon), fine for the result (1 % off).
const COARSE_ORDER: usize = 8;
const FINE_ORDER: usize = 32;
/// Up to this albedo the coarse quadrature suffices.
const COARSE_SUFFICES: f64 = 0.7;
/// Between these albedos the fine quadrature cannot decide if the albedo is above 1. Of final
/// results, albedos above `EXACT_ABOVE` are computed as the energy limit computes them.
const NEAR_ONE: (f64, f64) = (0.985, 1.02);
const EXACT_ABOVE: f64 = 0.95;
/// Azimuths of the incident light, in turns: along u and along v. Models are their own mirror image
/// across both axes, so half of the outgoing hemisphere suffices.
const TURNS: [f64; 2] = [0.0, 0.25];

/// Nodes of the quadratures of directional albedos.
#[derive(Debug)]
pub(super) struct Albedos {
    /// Nodes per incident direction: along u from each angle, then along v. `coarse` is for the
    /// steps, `fine` for the result.
    coarse: Vec<Vec<Nodes>>,
    fine: Vec<Vec<Nodes>>,
}

/// A block of nodes and their quadrature weights.
#[derive(Debug)]
pub(super) struct Nodes {
    pub(super) block: Block<LANES>,
    pub(super) weights: [f64; LANES],
}

impl Albedos {
    pub(super) fn new() -> Self {
        let from: Vec<(f64, f64)> =
            TURNS.iter().flat_map(|turn| ANGLES.map(|angle| (angle, *turn))).collect();
        let of = |order| {
            let rule = LobeRule::new(order);
            from.par_iter().map(|from| nodes(&rule, *from)).collect()
        };
        Self { coarse: of(COARSE_ORDER), fine: of(FINE_ORDER) }
    }

    /// Coarse nodes. Isotropic models need the first azimuth only.
    pub(super) fn coarse(&self, is_anisotropic: bool) -> &[Vec<Nodes>] {
        if is_anisotropic { &self.coarse } else { &self.coarse[..ANGLES.len()] }
    }

    /// Fine nodes, likewise.
    pub(super) fn fine(&self, is_anisotropic: bool) -> &[Vec<Nodes>] {
        if is_anisotropic { &self.fine } else { &self.fine[..ANGLES.len()] }
    }
}

/// True if the coarse quadrature suffices.
pub(super) fn is_coarse_enough(albedo: f64) -> bool {
    albedo <= COARSE_SUFFICES
}

/// Required precision of an albedo.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Precision {
    /// Enough to decide if it is above 1, and by about how much.
    Near,
    /// Exact wherever it may be above 1.
    Exact,
}

impl Precision {
    /// True if the quadrature is not precise enough and the exact energy limit is needed.
    pub(super) fn needs_exact(self, albedo: f64) -> bool {
        match self {
            Self::Near => albedo > NEAR_ONE.0 && albedo < NEAR_ONE.1,
            Self::Exact => albedo > EXACT_ABOVE || albedo.is_nan(),
        }
    }
}

/// Residual of an albedo, 0 up to `level`; its square is divided by `total`, the number of
/// residuals of samples, like theirs. Uses the log of the ratio, because models may exceed the
/// level by any factor.
pub(super) fn residual(albedo: f64, level: f64, total: f64) -> f64 {
    let excess = if albedo > level { libm::log(albedo / level) } else { 0.0 };
    (IMPORTANCE * total).sqrt() * excess
}

/// Nodes in half of the hemisphere, with doubled weights, for light from this angle in degrees and
/// azimuth in turns.
fn nodes(rule: &LobeRule, (angle, turn): (f64, f64)) -> Vec<Nodes> {
    let (sin, cos) = libm::sincos(angle.to_radians());
    let wi = direction_at(sin, cos, turn);
    let is_along_u = turn == TURNS[0];
    let is_half = |wo: glam::DVec3| if is_along_u { wo.y > 0.0 } else { wo.x > 0.0 };
    let half: Vec<(DirectionPair, f64)> =
        rule.nodes(wi).into_iter().filter(|(pair, _)| is_half(pair.wo())).collect();
    let level = Level::best();
    let of = |part: &[(DirectionPair, f64)]| {
        let pairs: Vec<DirectionPair> = part.iter().map(|(pair, _)| *pair).collect();
        let mut nodes = Nodes { block: Block::new(), weights: [0.0; LANES] };
        nodes.block.fill(level, &pairs);
        for (weights, (_, weight)) in nodes.weights.iter_mut().zip(part) {
            *weights = 2.0 * weight;
        }
        nodes
    };
    half.chunks(LANES).map(of).collect()
}
