//! A pair of unit directions in the local frame (z = n, x = u), pointing away from the surface.

use glam::{DVec2, DVec3};

/// How far a direction's length may be off 1 before it is refused rather than normalised.
pub const LENGTH_TOLERANCE: f64 = 1e-3;

/// Why two vectors are not a pair of directions.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum DirectionError {
    /// A component is NaN or infinite.
    #[error("a component of the direction is not finite")]
    NotFinite,
    /// The length is off 1 by more than 1e-3.
    #[error("the direction has length {0}, which is off 1 by more than 0.001")]
    NotUnit(f64),
}

/// The incident and the outgoing direction of one shading sample.
///
/// # Domain
/// Both are unit to within f64 rounding. A direction below the surface (z <= 0) is allowed; the inputs are defined
/// there too, and it is the caller who knows that no light is reflected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DirectionPair {
    wi: DVec3,
    wo: DVec3,
}

impl DirectionPair {
    /// Normalises `wi` (to the light) and `wo` (to the eye), refusing what is not a direction.
    pub fn new(wi: DVec3, wo: DVec3) -> Result<Self, DirectionError> {
        Ok(Self { wi: unit(wi)?, wo: unit(wo)? })
    }

    /// To the light.
    #[must_use]
    #[inline]
    pub fn wi(&self) -> DVec3 {
        self.wi
    }

    /// To the eye.
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

    /// The same pair with the roles of light and eye exchanged.
    #[must_use]
    #[inline]
    pub fn swapped(&self) -> Self {
        Self { wi: self.wo, wo: self.wi }
    }

    /// Components along x and y of `wi` and of `wo`.
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
