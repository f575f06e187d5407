//! Frames of reference: the unit frame of a mesh and the local frame of a surface point.

use glam::{DMat3, DVec3};

use crate::Mesh;
use crate::angle::rotation_xyz_deg;
use crate::trace::Ray;

/// Transform from the world to the unit frame.
///
/// The unit frame is the mesh as stored, with its bounding sphere moved to centre 0 and radius 1.
/// The object's rotation and scale are applied inversely to everything else, so no vertex is ever
/// moved.
#[derive(Debug, Clone, Copy)]
pub struct UnitFrame {
    /// Centre and radius of the subject's mesh, about which cameras and lights are placed.
    pivot: DVec3,
    radius: f64,
    /// Centre of the object relative to the pivot, in radii of the subject's mesh.
    centre: DVec3,
    /// Radius of the object in radii of the subject's mesh.
    scale: f64,
    /// World to object: the inverse of the object's rotation.
    unturn: DMat3,
    /// Distance from the pivot that encloses the objects of the scene, in radii of the subject's
    /// mesh.
    reach: f64,
    /// Distance from the pivot that cameras frame by default, in the same unit.
    framed: f64,
}

impl UnitFrame {
    /// Makes the frame of a mesh that is scaled and rotated about its centre.
    ///
    /// # Units
    /// Degrees about x, then y, then z.
    #[must_use]
    pub fn new(mesh: &Mesh, scale: f64, rotation_deg: [f64; 3]) -> Self {
        Self {
            pivot: mesh.centre(),
            radius: mesh.radius(),
            centre: DVec3::ZERO,
            scale,
            unturn: rotation_xyz_deg(rotation_deg).transpose(),
            reach: scale,
            framed: 1.0,
        }
    }

    /// Returns the frame of another object of the scene, which is scaled and rotated about the
    /// centre of its mesh and then moved. `self` is the frame of the subject.
    ///
    /// # Units
    /// World units; degrees about x, then y, then z.
    #[must_use]
    pub fn of_object(
        &self,
        mesh: &Mesh,
        position: DVec3,
        scale: f64,
        rotation_deg: [f64; 3],
    ) -> Self {
        Self {
            centre: (mesh.centre() + position - self.pivot) / self.radius,
            scale: scale * mesh.radius() / self.radius,
            unturn: rotation_xyz_deg(rotation_deg).transpose(),
            ..*self
        }
    }

    /// Returns the frame in a scene whose objects other than the subject are within a distance from
    /// the subject's centre, in radii of the subject's mesh. Cameras frame these too.
    #[must_use]
    pub fn among(self, others: f64) -> Self {
        Self { reach: self.reach.max(others), framed: self.framed.max(others), ..self }
    }

    /// Returns the distance from the subject's centre that encloses the object, in radii of the
    /// subject's mesh.
    #[must_use]
    pub fn extent(&self) -> f64 {
        self.centre.length() + self.scale
    }

    /// Returns the distance from the subject's centre that encloses the objects of the scene, in
    /// radii of the subject's mesh.
    #[must_use]
    pub fn reach(&self) -> f64 {
        self.reach
    }

    /// Returns the distance from the subject's centre that cameras frame by default, in radii of
    /// the subject's mesh: 1 without other objects, whatever the subject's scale.
    #[must_use]
    pub fn framed(&self) -> f64 {
        self.framed
    }

    /// Returns the radius of the object in radii of the subject's mesh: of the subject, its scale.
    #[must_use]
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// Returns the transform of this frame to the frame of another object of the scene.
    #[must_use]
    pub fn to(&self, other: &Self) -> FrameChange {
        FrameChange {
            turn: other.unturn * self.unturn.transpose(),
            ratio: self.scale / other.scale,
            origin: other.position(self.centre),
        }
    }

    /// Returns the subject's centre in the unit frame.
    #[must_use]
    pub fn pivot(&self) -> DVec3 {
        if self.centre == DVec3::ZERO {
            // Not -0, which rotations make of 0.
            return DVec3::ZERO;
        }
        self.position(DVec3::ZERO)
    }

    /// Returns a world position relative to the subject's centre, in radii of the subject's mesh at
    /// scale 1.
    #[must_use]
    pub fn relative(&self, world: [f64; 3]) -> DVec3 {
        (DVec3::from(world) - self.pivot) / self.radius
    }

    /// Returns the world position of a position from [`UnitFrame::relative`].
    #[must_use]
    pub fn world(&self, relative: DVec3) -> [f64; 3] {
        (relative * self.radius + self.pivot).to_array()
    }

    /// Transforms a position from [`UnitFrame::relative`] to the unit frame.
    #[must_use]
    pub fn position(&self, relative: DVec3) -> DVec3 {
        self.direction(relative - self.centre) / self.scale
    }

    /// Transforms a world direction to the unit frame.
    #[must_use]
    pub fn direction(&self, world: DVec3) -> DVec3 {
        self.unturn * world
    }

    /// Converts a world length to radii of the subject's mesh at scale 1.
    #[must_use]
    pub fn length(&self, world: f64) -> f64 {
        world / self.radius
    }
}

/// Transform from the unit frame of one object of a scene to that of another.
#[derive(Debug, Clone, Copy)]
pub struct FrameChange {
    turn: DMat3,
    ratio: f64,
    origin: DVec3,
}

impl FrameChange {
    /// Transforms a ray.
    #[must_use]
    pub fn ray(&self, ray: Ray) -> Ray {
        Ray {
            origin: self.origin + self.turn * ray.origin * self.ratio,
            direction: (self.turn * ray.direction).normalize(),
        }
    }

    /// Transforms a length.
    #[must_use]
    pub fn length(&self, length: f64) -> f64 {
        length * self.ratio
    }

    /// Returns the centre of the first object in the frame of the second.
    #[must_use]
    pub fn centre(&self) -> DVec3 {
        self.origin
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
