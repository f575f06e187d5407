//! The local frame of a hit (z = n, x = u, y = n x u) and directions in it.

use glam::{DVec2, DVec3};

use crate::Normals;
use crate::mesh::{MeshParts, fixed_tangent};
use crate::trace::Hit;

/// The cosine that wo is given where the interpolated normal turns away from the eye.
const SILHOUETTE_COS: f64 = 1e-4;
/// Interpolated normals and tangents shorter than this have cancelled.
const CANCELLED: f64 = 1e-9;

/// A hit, ready to be shaded.
#[derive(Debug, Clone, Copy)]
pub(super) struct ShadedPoint {
    /// Where it is, relative to the mesh's own origin.
    pub place: DVec3,
    /// Texture position.
    pub uv: DVec2,
    /// To the eye, in the local frame.
    pub wo: DVec3,
    u: DVec3,
    b: DVec3,
    /// The normal, on the side that the eye sees.
    pub n: DVec3,
    side: Side,
    /// Whether the normal turns away from the eye.
    averted: bool,
}

/// The side of a triangle that the eye sees.
#[derive(Debug, Clone, Copy)]
struct Side {
    /// Normal of the triangle itself; not finite where it is a sliver beyond all measure.
    face: DVec3,
    /// 1 where the given normals are on this side, else -1.
    sign: f64,
}

impl ShadedPoint {
    /// The frame of a hit, turned towards `eye`, the unit direction to the eye.
    ///
    /// # Domain
    /// Any hit of a valid mesh. The frame is orthonormal and cos_o positive, also where normals or tangents of the
    /// corners oppose each other.
    pub fn new(parts: &MeshParts, hit: &Hit, eye: DVec3) -> Self {
        let corners = parts.triangles[hit.triangle].map(|corner| corner as usize);
        let weighted = |values: &[DVec3]| -> DVec3 {
            corners.iter().zip(hit.weights).map(|(corner, weight)| values[*corner] * weight).sum()
        };
        let (n, side) = surface_normal(parts, corners, weighted(&parts.normals), eye);
        let u = weighted(&parts.tangents);
        let u = u - n * u.dot(n);
        let u = if u.length() > CANCELLED { u.normalize() } else { fixed_tangent(n) };
        let b = n.cross(u);
        let uv = corners.iter().zip(hit.weights).map(|(corner, w)| parts.uvs[*corner] * w).sum();
        let (place, wo) = (weighted(&parts.positions), DVec3::Z);
        let mut point = Self { place, uv, wo, u, b, n, side, averted: false };
        let wo = point.local(eye);
        point.averted = wo.z <= 0.0;
        point.wo = above_horizon(wo);
        point
    }

    /// Whether anything of what arrives here is reflected to the eye.
    pub fn reflects(&self, normals: Normals) -> bool {
        normals == Normals::Curved || !self.averted
    }

    /// Where rays to the lights start, relative to the mesh's own origin: on the flat triangle, or above it on the curved
    /// surface that its normals tell of, so that a convex surface never shades itself where its normals see the light.
    ///
    /// # Source
    /// Hanika 2021, *Hacking the Shadow Terminator*, in Ray Tracing Gems II: the place, projected onto the tangent plane of
    /// each corner where that is above it, and interpolated as the corners are.
    pub fn shadow_start(&self, normals: Normals, parts: &MeshParts, hit: &Hit) -> DVec3 {
        if normals == Normals::Plain {
            return self.place;
        }
        let corners = parts.triangles[hit.triangle].map(|corner| corner as usize);
        let lift = |(corner, weight): (usize, f64)| {
            let n = parts.normals[corner] * self.side.sign;
            let below = (parts.positions[corner] - self.place).dot(n);
            // A normal that leaves its triangle tells of no curved surface.
            let tells = below > 0.0 && n.dot(self.side.face) > 0.5;
            if tells { n * (below * weight) } else { DVec3::ZERO }
        };
        self.place + corners.into_iter().zip(hit.weights).map(lift).sum::<DVec3>()
    }

    /// The normal of the triangle itself, on the side that the eye sees.
    pub fn face(&self) -> DVec3 {
        if self.side.face.is_finite() { self.side.face } else { self.n }
    }

    /// A local direction in the frame of the mesh.
    pub fn global(&self, w: DVec3) -> DVec3 {
        self.u * w.x + self.b * w.y + self.n * w.z
    }

    /// A place whose normal is that, for tests.
    #[cfg(test)]
    pub fn facing(n: DVec3) -> Self {
        let u = fixed_tangent(n);
        let side = Side { face: n, sign: 1.0 };
        let (place, uv, wo) = (DVec3::ZERO, DVec2::ZERO, DVec3::Z);
        Self { place, uv, wo, u, b: n.cross(u), n, side, averted: false }
    }

    /// A direction in the local frame.
    pub fn local(&self, w: DVec3) -> DVec3 {
        DVec3::new(w.dot(self.u), w.dot(self.b), w.dot(self.n)).normalize()
    }
}

/// The interpolated normal, on the side of the surface that the eye sees.
fn surface_normal(parts: &MeshParts, corners: [usize; 3], n: DVec3, eye: DVec3) -> (DVec3, Side) {
    let [a, b, c] = corners.map(|corner| parts.positions[corner]);
    let face = (b - a).cross(c - a);
    let face = face / face.length();
    // Outside is where the given normals point, whichever way the corners go round.
    let given: DVec3 = corners.iter().map(|corner| parts.normals[*corner]).sum();
    let outwards = if face.dot(given) < 0.0 { -face } else { face };
    let n = if n.length() > CANCELLED { n.normalize() } else { outwards };
    if outwards.dot(eye) < 0.0 {
        return (-n, Side { face: -outwards, sign: -1.0 });
    }
    (n, Side { face: outwards, sign: 1.0 })
}

/// The direction itself where its cosine is positive, else the one of its azimuth just above the horizon.
fn above_horizon(w: DVec3) -> DVec3 {
    if w.z > 0.0 {
        return w;
    }
    let level = w.truncate();
    // Straight from below there is no azimuth to keep.
    let level = if level.length() > CANCELLED { level.normalize() } else { DVec2::X };
    (level * (1.0 - SILHOUETTE_COS * SILHOUETTE_COS).sqrt()).extend(SILHOUETTE_COS)
}
