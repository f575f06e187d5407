//! The half vector of a pair, by expressions that swapping the directions does not change in any bit.

use glam::DVec3;

use crate::DirectionPair;

/// What models read of a pair whose directions are both above the surface.
#[derive(Debug, Clone, Copy)]
pub(super) struct Half {
    pub(super) cos_i: f64,
    pub(super) cos_o: f64,
    /// The half vector h = (wi + wo) / |wi + wo|.
    pub(super) h: DVec3,
    /// h . wi = h . wo.
    pub(super) cos_d: f64,
    /// wi . wo
    pub(super) cos_io: f64,
}

impl Half {
    /// None where a direction is not above the surface: nothing is reflected there.
    ///
    /// Sums and products of the components commute, so the pair and the swapped one have the same bits but for `cos_i` and
    /// `cos_o` themselves. |wi + wo| / 2 is sqrt((1 + wi . wo) / 2) without the cancellation of nearly opposite directions.
    pub(super) fn of(pair: &DirectionPair) -> Option<Self> {
        let (wi, wo) = (pair.wi(), pair.wo());
        if !(wi.z > 0.0 && wo.z > 0.0) {
            return None;
        }
        let sum = wi + wo;
        let length = sum.length();
        if length < f64::MIN_POSITIVE {
            return None;
        }
        let cos_d = (0.5 * length).min(1.0);
        Some(Self { cos_i: wi.z, cos_o: wo.z, h: sum / length, cos_d, cos_io: wi.dot(wo) })
    }

    /// tan^2 of the angle between h and the normal.
    pub(super) fn tan2(&self) -> f64 {
        (self.h.x * self.h.x + self.h.y * self.h.y) / (self.h.z * self.h.z)
    }
}
