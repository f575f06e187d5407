//! What models reflect of all light that comes from a direction, held below 1 where a fit passes it.
//!
//! One light shows a surface at few angles. What is fitted there may reflect hundreds of times the light from others, and the energy
//! limit divides all of a material by the most that it reflects.

use brood_brdf::{Block, DirectionPair};
use brood_eval::{Level, LobeRule, around};
use rayon::prelude::*;

use super::batch::LANES;
use crate::lobes::{ANGLES, IMPORTANCE};

/// Orders of the quadratures: of that of the steps, which may be off by a quarter where light comes from the horizon, and of that which
/// says how much it is in the end, off by 1 %.
const COARSE: usize = 8;
const FINE: usize = 32;
/// What the coarse one is content with is below all light.
const SURE: f64 = 0.7;
/// Between these it does not tell whether there is more than all light; of what is handed back everything above `LOOKED` is measured.
const UNSURE: (f64, f64) = (0.985, 1.02);
const LOOKED: f64 = 0.95;
/// Of a turn, where light comes from: half of the hemisphere is the mirror image of the other in either.
const TURNS: [f64; 2] = [0.0, 0.25];

/// Nodes of the quadratures of directional albedos.
#[derive(Debug)]
pub(super) struct Albedos {
    /// Light that comes along u from each angle, then along v; for steps, and for what is said of them.
    coarse: Vec<Vec<Nodes>>,
    fine: Vec<Vec<Nodes>>,
}

/// Where f is looked at, and what it counts there.
#[derive(Debug)]
pub(super) struct Nodes {
    pub(super) block: Block<LANES>,
    pub(super) counts: [f64; LANES],
}

impl Albedos {
    pub(super) fn new() -> Self {
        let from: Vec<(f64, f64)> =
            TURNS.iter().flat_map(|turn| ANGLES.map(|angle| (angle, *turn))).collect();
        let of = |order| {
            let rule = LobeRule::new(order);
            from.par_iter().map(|from| nodes(&rule, *from)).collect()
        };
        Self { coarse: of(COARSE), fine: of(FINE) }
    }

    /// Of models that are the same all around the normal unless they are turned.
    pub(super) fn coarse(&self, is_turned: bool) -> &[Vec<Nodes>] {
        if is_turned { &self.coarse } else { &self.coarse[..ANGLES.len()] }
    }

    /// The same, of more directions each.
    pub(super) fn fine(&self, is_turned: bool) -> &[Vec<Nodes>] {
        if is_turned { &self.fine } else { &self.fine[..ANGLES.len()] }
    }
}

/// Whether the coarse quadrature says enough.
pub(super) fn is_little(albedo: f64) -> bool {
    albedo <= SURE
}

/// How well an albedo is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Precision {
    /// Whether it is more than all light, and about how much.
    Near,
    /// To the bit wherever it may be more.
    Exact,
}

impl Precision {
    /// Whether the quadrature does not do.
    pub(super) fn asks(self, albedo: f64) -> bool {
        match self {
            Self::Near => albedo > UNSURE.0 && albedo < UNSURE.1,
            Self::Exact => albedo > LOOKED || albedo.is_nan(),
        }
    }
}

/// What an albedo above a level adds to the residuals of which the mean square of so many is minimised. By ratios, for models may be
/// off by any.
pub(super) fn residual(albedo: f64, level: f64, total: f64) -> f64 {
    let excess = if albedo > level { libm::log(albedo / level) } else { 0.0 };
    (IMPORTANCE * total).sqrt() * excess
}

fn nodes(rule: &LobeRule, (angle, turn): (f64, f64)) -> Vec<Nodes> {
    let (sin, cos) = libm::sincos(angle.to_radians());
    let wi = around(sin, cos, turn);
    let is_along_u = turn == TURNS[0];
    let is_half = |wo: glam::DVec3| if is_along_u { wo.y > 0.0 } else { wo.x > 0.0 };
    let half: Vec<(DirectionPair, f64)> =
        rule.nodes(wi).into_iter().filter(|(pair, _)| is_half(pair.wo())).collect();
    let level = Level::best();
    let of = |part: &[(DirectionPair, f64)]| {
        let pairs: Vec<DirectionPair> = part.iter().map(|(pair, _)| *pair).collect();
        let mut nodes = Nodes { block: Block::new(), counts: [0.0; LANES] };
        nodes.block.fill(level, &pairs);
        for (counts, (_, weight)) in nodes.counts.iter_mut().zip(part) {
            *counts = 2.0 * weight;
        }
        nodes
    };
    half.chunks(LANES).map(of).collect()
}
