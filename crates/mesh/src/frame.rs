//! Frames of reference: the unit frame of a mesh and the local frame of a surface point.

use glam::{DMat3, DVec3};

use crate::Mesh;
use crate::angle::rotation_xyz_deg;

/// Transform from the world to the unit frame.
///
/// The unit frame is the mesh as stored, with its bounding sphere moved to centre 0 and radius 1.
/// The object's rotation and scale are applied inversely to everything else, so no vertex is ever
/// moved.
#[derive(Debug, Clone, Copy)]
pub struct UnitFrame {
    centre: DVec3,
    radius: f64,
    scale: f64,
    /// World to object: the inverse of the object's rotation.
    unturn: DMat3,
}

impl UnitFrame {
    /// Makes the frame of a mesh that is scaled and rotated about its centre.
    ///
    /// # Units
    /// Degrees about x, then y, then z.
    #[must_use]
    pub fn new(mesh: &Mesh, scale: f64, rotation_deg: [f64; 3]) -> Self {
        Self {
            centre: mesh.centre(),
            radius: mesh.radius(),
            scale,
            unturn: rotation_xyz_deg(rotation_deg).transpose(),
        }
    }

    /// Returns the scale of the object.
    #[must_use]
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// Returns a world position relative to the mesh's centre, in radii of the mesh at scale 1.
    #[must_use]
    pub fn relative(&self, world: [f64; 3]) -> DVec3 {
        (DVec3::from(world) - self.centre) / self.radius
    }

    /// Transforms a position from [`UnitFrame::relative`] to the unit frame.
    #[must_use]
    pub fn position(&self, relative: DVec3) -> DVec3 {
        self.direction(relative) / self.scale
    }

    /// Transforms a world direction to the unit frame.
    #[must_use]
    pub fn direction(&self, world: DVec3) -> DVec3 {
        self.unturn * world
    }

    /// Converts a world length to radii of the mesh at scale 1.
    #[must_use]
    pub fn length(&self, world: f64) -> f64 {
        world / self.radius
    }
}

/// Orthonormal frame of a surface point: x is the tangent, y is n x u, z is the normal.
#[derive(Debug, Clone, Copy)]
pub struct LocalFrame {
    u: DVec3,
    b: DVec3,
    n: DVec3,
}

impl LocalFrame {
    /// Makes the frame of a normal and a tangent.
    ///
    /// # Domain
    /// Unit vectors at a right angle.
    #[must_use]
    #[inline]
    pub fn new(n: DVec3, u: DVec3) -> Self {
        Self { u, b: n.cross(u), n }
    }

    /// Returns the normal.
    #[must_use]
    #[inline]
    pub fn n(&self) -> DVec3 {
        self.n
    }

    /// Returns the tangent.
    #[must_use]
    #[inline]
    pub fn u(&self) -> DVec3 {
        self.u
    }

    /// Transforms a direction of the mesh's frame to the local frame.
    #[must_use]
    #[inline]
    pub fn local(&self, w: DVec3) -> DVec3 {
        DVec3::new(w.dot(self.u), w.dot(self.b), w.dot(self.n)).normalize()
    }

    /// Transforms a local direction to the frame of the mesh.
    #[must_use]
    #[inline]
    pub fn global(&self, w: DVec3) -> DVec3 {
        self.u * w.x + self.b * w.y + self.n * w.z
    }
}
