//! Frustum of a pixel, by which the BVH is traversed once for all rays of the pixel.

use glam::{DVec2, DVec3, Vec2, Vec3A};

use super::ray::Ray;
use super::tree::Bounds;

/// Distance that a point may be outside a side plane, in the unit frame: rays on the frustum's own
/// edge must not miss by rounding. The rounding of the f32 box test is covered by the boxes'
/// margin.
const MARGIN: f64 = 1e-6;

/// Intersection of four half-spaces.
#[derive(Debug)]
pub struct PixelFrustum {
    /// Outward normals.
    normals: [Vec3A; 4],
    offsets: [f32; 4],
}

impl PixelFrustum {
    /// Makes the frustum between the rays of four corners in circular order; directions need not be
    /// unit vectors.
    ///
    /// # Domain
    /// Rays of one camera. `None` if the corners are too close together or too far away to span
    /// planes.
    #[must_use]
    pub fn new(corners: [Ray; 4]) -> Option<Self> {
        let middle: DVec3 =
            corners.iter().map(|ray| ray.origin + ray.direction).sum::<DVec3>() / 4.0;
        let mut frustum = Self { normals: [Vec3A::ZERO; 4], offsets: [0.0; 4] };
        for k in 0..4 {
            let (ray, next) = (corners[k], corners[(k + 1) % 4]);
            // The plane through both rays: parallel rays differ in origin, others in direction.
            let between = (next.origin - ray.origin) + (next.direction - ray.direction);
            let normal = ray.direction.cross(between).try_normalize()?;
            let outwards = if normal.dot(middle - ray.origin) > 0.0 { -normal } else { normal };
            let offset = outwards.dot(ray.origin) + MARGIN;
            // Beyond this, rounding of the offset exceeds the margin.
            if offset.is_nan() || offset.abs() > 1e6 {
                return None;
            }
            frustum.normals[k] = outwards.as_vec3a();
            // Rounding of the normal moves a point of the unit sphere by up to 2e-7, rounding of
            // the products by as much.
            frustum.offsets[k] = offset as f32 + (offset.abs() as f32) * 1e-6 + 2e-6;
        }
        Some(frustum)
    }

    /// False only if the box is outside; may return true for boxes outside near an edge.
    #[inline]
    pub(super) fn may_intersect(&self, bounds: &Bounds) -> bool {
        self.normals.iter().zip(self.offsets).all(|(normal, offset)| {
            // The innermost corner of the box.
            let least = (*normal * bounds.low).min(*normal * bounds.high);
            least.x + least.y + least.z <= offset
        })
    }
}

/// Edge functions of a triangle projected into a pixel, in pixel coordinates: 0 to 1 from left to
/// right and from top to bottom. Conservative: a point where one is negative does not see the
/// triangle.
#[derive(Debug, Clone, Copy)]
pub(super) struct EdgeFunctions {
    across: [f32; 3],
    down: [f32; 3],
    offset: [f32; 3],
}

impl EdgeFunctions {
    /// Edge functions that are positive everywhere.
    const EVERYWHERE: Self = Self { across: [0.0; 3], down: [0.0; 3], offset: [1.0; 3] };

    /// Makes the edge functions of a triangle; `None` if it is outside the pixel. If `project`
    /// returns `None` for a corner (not in front of the eye), they are positive everywhere.
    pub fn new(corners: &[DVec3; 3], project: impl Fn(DVec3) -> Option<DVec2>) -> Option<Self> {
        let mut points = [DVec2::ZERO; 3];
        for (point, corner) in points.iter_mut().zip(corners) {
            let Some(projected) = project(*corner) else { return Some(Self::EVERYWHERE) };
            *point = projected;
        }
        let [a, b, c] = points;
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        // Far above all rounding errors of the projection.
        let reach = low.abs().max(high.abs()).max_element();
        let margin = 1e-3 + reach * 4e-7;
        if low.max_element() > 1.0 + margin || high.min_element() < -margin {
            return None;
        }
        let area = (b - a).perp_dot(c - a);
        let smallest = 1e-6 * (1.0 + reach);
        if area.abs() < smallest {
            // Seen edge-on, the triangle has no inner side.
            return Some(Self::EVERYWHERE);
        }
        let mut edges = Self::EVERYWHERE;
        for (k, (from, to)) in [(a, b), (b, c), (c, a)].into_iter().enumerate() {
            let along = to - from;
            let inwards = along.perp() * (area.signum() / along.length());
            edges.across[k] = inwards.x as f32;
            edges.down[k] = inwards.y as f32;
            edges.offset[k] = (margin - inwards.dot(from)) as f32;
        }
        Some(edges)
    }

    /// True if no edge function is negative at a point of the pixel.
    #[inline]
    pub fn contains(&self, point: Vec2) -> bool {
        let side = |k: usize| self.across[k] * point.x + self.down[k] * point.y + self.offset[k];
        side(0).min(side(1)).min(side(2)) >= 0.0
    }
}
