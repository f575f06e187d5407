//! Local shading frame of a hit (z = n, x = u, y = n x u), and directions in it.

use brood_mesh::trace::Hit;
use brood_mesh::{LocalFrame, MeshParts, fixed_tangent};
use glam::{DVec2, DVec3};

use crate::description::{Normals, Tangents};

/// Cosine to which wo is clamped if the interpolated normal faces away from the eye.
const SILHOUETTE_COS: f64 = 1e-4;
/// Length below which interpolated normals and tangents are treated as zero.
const MIN_LENGTH: f64 = 1e-9;

/// Hit with its shading frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct ShadedPoint {
    /// Position in the mesh's own coordinates.
    pub position: DVec3,
    /// Texture position.
    pub uv: DVec2,
    /// Direction to the eye, in the local frame.
    pub wo: DVec3,
    /// Shading frame, its normal on the side that faces the eye.
    pub frame: LocalFrame,
    side: Side,
    /// Normal of the mesh, on the side of the eye, if a normal map or bumps have replaced it.
    replaced: Option<DVec3>,
    /// True if the shading normal faces away from the eye although the triangle does not.
    faces_away: bool,
}

/// Side of a triangle that faces the eye.
#[derive(Debug, Clone, Copy)]
struct Side {
    /// Geometric normal of the triangle; not finite if the triangle is degenerate.
    face: DVec3,
    /// 1 if the mesh's normals are on this side, else -1.
    sign: f64,
}

impl ShadedPoint {
    /// Makes the frame of a hit, oriented to `eye`, the unit direction to the eye.
    ///
    /// # Domain
    /// Any hit of a valid mesh. The frame is orthonormal and cos_o positive, even if normals or
    /// tangents of the corners cancel.
    pub fn new(parts: &MeshParts, hit: &Hit, eye: DVec3, tangents: Tangents) -> Self {
        let corners = parts.triangles[hit.triangle].map(|corner| corner as usize);
        let weighted = |values: &[DVec3]| -> DVec3 {
            corners.iter().zip(hit.weights).map(|(corner, weight)| values[*corner] * weight).sum()
        };
        let (n, side) = surface_normal(parts, corners, weighted(&parts.normals), eye);
        let u = match tangents {
            Tangents::Vertex => weighted(&parts.tangents),
            Tangents::Triangle => triangle_tangent(parts, corners),
        };
        let u = u - n * u.dot(n);
        let u = if u.length() > MIN_LENGTH { u.normalize() } else { fixed_tangent(n) };
        let frame = LocalFrame::new(n, u);
        let uv = corners.iter().zip(hit.weights).map(|(corner, w)| parts.uvs[*corner] * w).sum();
        let wo = frame.local(eye);
        Self {
            position: weighted(&parts.positions),
            uv,
            wo: above_horizon(wo),
            frame,
            side,
            replaced: None,
            faces_away: wo.z <= 0.0,
        }
    }

    /// Returns the normal of the mesh on the side of the eye, whatever the normal map.
    pub fn mesh_normal(&self) -> DVec3 {
        self.replaced.unwrap_or(self.frame.n())
    }

    /// Returns the shading normal on the outside of the mesh.
    pub fn outwards(&self) -> DVec3 {
        self.frame.n() * self.side.sign
    }

    /// Returns the point with another shading normal on the outside of the mesh, and the tangent
    /// turned with it.
    pub fn with_outwards(&self, n: DVec3, eye: DVec3) -> Self {
        let n = n * self.side.sign;
        let u = self.frame.u() - n * self.frame.u().dot(n);
        let u = if u.length() > MIN_LENGTH { u.normalize() } else { fixed_tangent(n) };
        let frame = LocalFrame::new(n, u);
        let wo = frame.local(eye);
        let replaced = Some(self.mesh_normal());
        Self { wo: above_horizon(wo), frame, replaced, faces_away: wo.z <= 0.0, ..*self }
    }

    /// False for directions below a surface whose normal a normal map has replaced: no light of
    /// lamps comes from there.
    pub fn is_above(&self, towards: DVec3) -> bool {
        self.replaced.is_none_or(|n| n.dot(towards) > 0.0)
    }

    /// False if plain normals are used and the shading normal faces away from the eye: such points
    /// reflect nothing.
    pub fn reflects(&self, normals: Normals) -> bool {
        normals == Normals::Curved || !self.faces_away
    }

    /// Returns the start of shadow rays in the mesh's own coordinates: on the flat triangle, or
    /// lifted onto the curved surface that the normals imply, so that a convex surface never
    /// shadows itself where its normals face the light.
    ///
    /// # Source
    /// Hanika 2021, *Hacking the Shadow Terminator*, in Ray Tracing Gems II: the position is
    /// projected onto the tangent plane of each corner that is above it, and the projections are
    /// interpolated with the corner weights.
    pub fn shadow_start(&self, normals: Normals, parts: &MeshParts, hit: &Hit) -> DVec3 {
        if normals == Normals::Plain {
            return self.position;
        }
        let corners = parts.triangles[hit.triangle].map(|corner| corner as usize);
        let lift = |(corner, weight): (usize, f64)| {
            let n = parts.normals[corner] * self.side.sign;
            let below = (parts.positions[corner] - self.position).dot(n);
            // A normal more than 60 degrees from the triangle's does not describe a curved surface.
            let is_curved = below > 0.0 && n.dot(self.side.face) > 0.5;
            if is_curved { n * (below * weight) } else { DVec3::ZERO }
        };
        self.position + corners.into_iter().zip(hit.weights).map(lift).sum::<DVec3>()
    }

    /// Returns the geometric normal on the side that faces the eye.
    pub fn face(&self) -> DVec3 {
        if self.side.face.is_finite() { self.side.face } else { self.frame.n() }
    }
}

/// Returns the unit direction of growing u on a triangle; 0 if its texture coordinates are
/// collinear or equal.
///
/// # Source
/// The derivative of the position by u of Mitsuba's meshes.
fn triangle_tangent(parts: &MeshParts, corners: [usize; 3]) -> DVec3 {
    let [a, b, c] = corners.map(|corner| parts.positions[corner]);
    let [ta, tb, tc] = corners.map(|corner| parts.uvs[corner]);
    let (d, e) = (tb - ta, tc - ta);
    let det = d.perp_dot(e);
    let along = ((b - a) * e.y - (c - a) * d.y) * det.signum();
    if det == 0.0 { DVec3::ZERO } else { along.normalize_or_zero() }
}

/// Returns the interpolated normal on the side of the surface that faces the eye, and that side.
fn surface_normal(parts: &MeshParts, corners: [usize; 3], n: DVec3, eye: DVec3) -> (DVec3, Side) {
    let [a, b, c] = corners.map(|corner| parts.positions[corner]);
    let face = (b - a).cross(c - a);
    let face = face / face.length();
    // The mesh's normals define the outside, not the winding of the corners.
    let given: DVec3 = corners.iter().map(|corner| parts.normals[*corner]).sum();
    let outwards = if face.dot(given) < 0.0 { -face } else { face };
    let n = if n.length() > MIN_LENGTH { n.normalize() } else { outwards };
    if outwards.dot(eye) < 0.0 {
        return (-n, Side { face: -outwards, sign: -1.0 });
    }
    (n, Side { face: outwards, sign: 1.0 })
}

/// Returns the direction if its cosine is positive, else the direction of the same azimuth just
/// above the horizon (cosine 1e-4).
#[must_use]
pub fn above_horizon(w: DVec3) -> DVec3 {
    if w.z > 0.0 {
        return w;
    }
    let level = w.truncate();
    // A vertical direction has no azimuth: +x is used.
    let level = if level.length() > MIN_LENGTH { level.normalize() } else { DVec2::X };
    (level * (1.0 - SILHOUETTE_COS * SILHOUETTE_COS).sqrt()).extend(SILHOUETTE_COS)
}
