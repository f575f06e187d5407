//! A pair of unit directions in the local frame (z = n, x = u), pointing away from the surface.

use glam::{DVec2, DVec3};

/// Largest deviation of a direction's length from 1 that is normalised; a larger one is an error.
pub const LENGTH_TOLERANCE: f64 = 1e-3;

/// Error of [`DirectionPair::new`].
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum DirectionError {
    /// A component is NaN or infinite.
    #[error("a component of the direction is not finite")]
    NotFinite,
    /// The length differs from 1 by more than 1e-3.
    #[error("the length of the direction must be 1 within 0.001, got {0}")]
    NotUnit(f64),
}

/// The incident and the outgoing direction of one shading sample.
///
/// # Domain
/// Both are unit to within f64 rounding. A direction below the surface (z <= 0) is allowed, and the
/// inputs are defined there; the caller must handle that no light is reflected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DirectionPair {
    wi: DVec3,
    wo: DVec3,
}

impl DirectionPair {
    /// Normalises `wi` (to the light) and `wo` (to the eye).
    ///
    /// # Errors
    /// Returns [`DirectionError`] if a component is not finite or a length differs from 1 by
    /// more than 1e-3.
    pub fn new(wi: DVec3, wo: DVec3) -> Result<Self, DirectionError> {
        Ok(Self { wi: unit(wi)?, wo: unit(wo)? })
    }

    /// Direction to the light.
    #[must_use]
    #[inline]
    pub fn wi(&self) -> DVec3 {
        self.wi
    }

    /// Direction to the eye.
    #[must_use]
    #[inline]
    pub fn wo(&self) -> DVec3 {
        self.wo
    }

    /// Cosine of the angle between the normal and `wi`.
    #[must_use]
    #[inline]
    pub fn cos_i(&self) -> f64 {
        self.wi.z
    }

    /// Cosine of the angle between the normal and `wo`.
    #[must_use]
    #[inline]
    pub fn cos_o(&self) -> f64 {
        self.wo.z
    }

    /// Returns the pair with the roles of light and eye exchanged.
    #[must_use]
    #[inline]
    pub fn swapped(&self) -> Self {
        Self { wi: self.wo, wo: self.wi }
    }

    /// The x and y components of `wi` and of `wo`.
    pub(crate) fn tangential(&self) -> (DVec2, DVec2) {
        (self.wi.truncate(), self.wo.truncate())
    }
}

fn unit(w: DVec3) -> Result<DVec3, DirectionError> {
    if !w.is_finite() {
        return Err(DirectionError::NotFinite);
    }
    let length = w.length();
    if (length - 1.0).abs() > LENGTH_TOLERANCE {
        return Err(DirectionError::NotUnit(length));
    }
    Ok(w / length)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pair_is_refused_when_a_direction_is_not_unit_or_not_finite() {
        let z = DVec3::Z;
        assert!(matches!(DirectionPair::new(z * 1.01, z), Err(DirectionError::NotUnit(_))));
        assert!(matches!(DirectionPair::new(z, z * f64::NAN), Err(DirectionError::NotFinite)));
        assert_eq!(DirectionPair::new(z * 1.0005, z).map(|pair| pair.wi()), Ok(z));
    }
}
