//! The beam of a pixel: what all its rays have in common, so that the tree is walked once for them.

use glam::{DVec2, DVec3, Vec2, Vec3A};

use super::Ray;
use super::tree::Bounds;

/// How far a place may be outside a side plane, in the unit frame: boxes are grown by more than the f32 test rounds, and
/// rays of the beam's own edge must not miss by rounding.
const MARGIN: f64 = 1e-6;

/// The space between four planes.
#[derive(Debug)]
pub(crate) struct Beam {
    /// Normals outwards.
    normals: [Vec3A; 4],
    offsets: [f32; 4],
}

impl Beam {
    /// The beam between the rays of four corners that follow one another around it; their directions need not be unit.
    ///
    /// # Domain
    /// Rays of one camera. `None` where the corners are so close or so far away that they span no planes.
    pub fn new(corners: [Ray; 4]) -> Option<Self> {
        let middle: DVec3 =
            corners.iter().map(|ray| ray.origin + ray.direction).sum::<DVec3>() / 4.0;
        let mut beam = Self { normals: [Vec3A::ZERO; 4], offsets: [0.0; 4] };
        for k in 0..4 {
            let (ray, next) = (corners[k], corners[(k + 1) % 4]);
            // Through both rays: parallel ones differ in origin, the others in direction.
            let aside = (next.origin - ray.origin) + (next.direction - ray.direction);
            let normal = ray.direction.cross(aside).try_normalize()?;
            let outwards = if normal.dot(middle - ray.origin) > 0.0 { -normal } else { normal };
            let offset = outwards.dot(ray.origin) + MARGIN;
            // Far eyes cost digits that the margin does not hold.
            if offset.is_nan() || offset.abs() > 1e6 {
                return None;
            }
            beam.normals[k] = outwards.as_vec3a();
            // The normal's rounding moves a place of the unit sphere by up to 2e-7, the products by as much.
            beam.offsets[k] = offset as f32 + (offset.abs() as f32) * 1e-6 + 2e-6;
        }
        Some(beam)
    }

    /// Whether a part of the box may be inside.
    pub(super) fn may_meet(&self, bounds: &Bounds) -> bool {
        self.normals.iter().zip(self.offsets).all(|(normal, offset)| {
            // The corner of the box that is farthest inwards.
            let least = (*normal * bounds.low).min(*normal * bounds.high);
            least.x + least.y + least.z <= offset
        })
    }
}

/// Where in a pixel a triangle may be seen, in coordinates from 0 to 1 from left to right and from top to bottom: on the
/// inner side of three lines.
#[derive(Debug, Clone, Copy)]
pub(super) struct Window {
    across: [f32; 3],
    down: [f32; 3],
    offset: [f32; 3],
}

impl Window {
    const WHOLE: Self = Self { across: [0.0; 3], down: [0.0; 3], offset: [1.0; 3] };

    /// The window of a triangle, `None` where it is outside the pixel. `project` has no answer for what is not in front
    /// of the eye: then everywhere.
    pub fn around(corners: &[DVec3; 3], project: impl Fn(DVec3) -> Option<DVec2>) -> Option<Self> {
        let mut places = [DVec2::ZERO; 3];
        for (place, corner) in places.iter_mut().zip(corners) {
            let Some(seen) = project(*corner) else { return Some(Self::WHOLE) };
            *place = seen;
        }
        let [a, b, c] = places;
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        // All that is rounded on the way is far below this.
        let reach = low.abs().max(high.abs()).max_element();
        let margin = 1e-3 + reach * 4e-7;
        if low.max_element() > 1.0 + margin || high.min_element() < -margin {
            return None;
        }
        let area = (b - a).perp_dot(c - a);
        let smallest = 1e-6 * (1.0 + reach);
        if area.abs() < smallest {
            // Seen from the side it is a line, which has no inner side.
            return Some(Self::WHOLE);
        }
        let mut window = Self::WHOLE;
        for (k, (from, to)) in [(a, b), (b, c), (c, a)].into_iter().enumerate() {
            let along = to - from;
            let inwards = along.perp() * (area.signum() / along.length());
            window.across[k] = inwards.x as f32;
            window.down[k] = inwards.y as f32;
            window.offset[k] = (margin - inwards.dot(from)) as f32;
        }
        Some(window)
    }

    /// Whether a place is in it.
    #[inline]
    pub fn holds(&self, place: Vec2) -> bool {
        let side = |k: usize| self.across[k] * place.x + self.down[k] * place.y + self.offset[k];
        side(0).min(side(1)).min(side(2)) >= 0.0
    }
}
