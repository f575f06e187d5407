//! The trait that every BRDF implements, modelled or measured, and the properties it can claim.

use glam::DVec3;

use crate::DirectionPair;

/// A bidirectional reflectance distribution function.
pub trait Brdf: Send + Sync {
    /// Returns f(wi, wo), without the cosine of wi.
    ///
    /// # Units
    /// 1/sr; linear red, green, blue.
    ///
    /// # Domain
    /// Any pair; 0 unless both directions are above the surface. Never NaN.
    fn f(&self, pair: &DirectionPair) -> DVec3;

    /// Properties that hold with these parameters. Tests check them.
    fn claims(&self) -> Claims;
}

/// Physical properties that a BRDF guarantees.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Claims {
    /// f(wi, wo) = f(wo, wi), in every bit.
    pub reciprocal: bool,
    /// The directional albedo is at most 1 in every direction.
    pub conserving: bool,
}
