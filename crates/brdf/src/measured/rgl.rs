//! Reader of RGL's `.bsdf` files. A material is measured at directions that are drawn by importance
//! sampling of its own microfacets, and tabulated over the two uniform numbers of each draw. The
//! formula is in docs/maths/shading.md, section RGL.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DVec2, DVec3};

use super::tensor::{TensorError, Tensors};
use super::warp::{Axis, Grid, SliceWeights, Warp, WarpError};
use crate::{Brdf, Claims, DirectionPair};

/// A measured material, isotropic or anisotropic.
///
/// Interpolated values below 0, which occur for colours outside the display gamut, become 0 unless
/// [`Rgl::keep_negative`] is used.
///
/// # Source
/// Dupuy and Jakob 2018, "An adaptive parameterization for efficient material acquisition and
/// rendering".
pub struct Rgl {
    phi: Axis,
    theta: Axis,
    symmetry: Symmetry,
    /// Density of the facet normals.
    ndf: Grid,
    /// Projected area of the facets seen from each direction.
    sigma: Grid,
    /// Density of the visible normals for each incidence.
    vndf: Warp,
    /// Slices of red, green and blue: f cos_o, divided by ndf / (4 sigma) if `needs_density`.
    rgb: Grid,
    /// Field `jacobian`: true if `rgb` must be multiplied by ndf / (4 sigma).
    needs_density: bool,
    /// True if interpolated values may be below 0.
    keeps_negative: bool,
}

/// Symmetry under rotation about the normal, from the measured range of azimuths.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Symmetry {
    /// Unchanged by any rotation.
    Isotropic,
    /// None: measured over a full turn.
    None,
    /// Unchanged by half a turn; half a turn was measured.
    Half,
    /// Unchanged by mirroring along either axis; a quarter turn was measured.
    Quarter,
}

/// Error of [`Rgl::read`].
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum RglError {
    /// The container or one of its fields is not valid.
    #[error("the .bsdf file cannot be read: {0}")]
    Tensor(#[from] TensorError),
    /// The file has spectra instead of colours.
    #[error(
        "the .bsdf file holds spectra at {0} wavelengths; only the RGB variant of a material is read"
    )]
    Spectral(usize),
    /// The angles of incidence do not ascend.
    #[error("the angles {0} of the .bsdf file do not ascend")]
    Angles(&'static str),
    /// A table has fewer than two entries along a side.
    #[error("the table {0} of the .bsdf file is too small")]
    Small(&'static str),
    /// A density is below 0.
    #[error("entry {1} of the table {0} of the .bsdf file is below 0")]
    Negative(&'static str, usize),
    /// The density of visible normals is 0 everywhere for one direction.
    #[error("the table vndf of the .bsdf file is 0 everywhere for the incidence number {0}")]
    Empty(usize),
}

impl Rgl {
    /// Reads a file.
    ///
    /// # Errors
    /// Returns [`RglError`] if the file is damaged, has spectra, or has tables of the wrong
    /// size or sign.
    pub fn read(bytes: &[u8]) -> Result<Self, RglError> {
        let tensors = Tensors::open(bytes)?;
        if let (None, Some(shape)) = (tensors.shape("rgb"), tensors.shape("spectra")) {
            return Err(RglError::Spectral(shape.get(2).copied().unwrap_or(0)));
        }
        let axis = |name| {
            let (_, values) = tensors.floats::<1>(name)?;
            Axis::new(&values).ok_or(RglError::Angles(name))
        };
        let (phi, theta) = (axis("phi_i")?, axis("theta_i")?);
        let plain = |name| {
            let ([height, width], values) = tensors.floats::<2>(name)?;
            if let Some(entry) = values.iter().position(|value| *value < 0.0) {
                return Err(RglError::Negative(name, entry));
            }
            Grid::new((height, width), values).ok_or(RglError::Small(name))
        };
        let (ndf, sigma) = (plain("ndf")?, plain("sigma")?);
        let slices = [phi.len(), theta.len()];
        let ([.., height, width], _) = tensors.floats::<4>("vndf")?;
        let values = tensors.shaped("vndf", [slices[0], slices[1], height, width])?;
        let vndf = Warp::new((height, width), values).map_err(|error| match error {
            WarpError::Size => RglError::Small("vndf"),
            WarpError::Negative(entry) => RglError::Negative("vndf", entry),
            WarpError::Empty(slice) => RglError::Empty(slice),
        })?;
        let ([.., height, width], _) = tensors.floats::<5>("rgb")?;
        let values = tensors.shaped("rgb", [slices[0], slices[1], 3, height, width])?;
        let rgb = Grid::new((height, width), values).ok_or(RglError::Small("rgb"))?;
        let needs_density = tensors.byte("jacobian")? != 0;
        let symmetry = Symmetry::of(&phi);
        Ok(Self {
            phi,
            theta,
            symmetry,
            ndf,
            sigma,
            vndf,
            rgb,
            needs_density,
            keeps_negative: false,
        })
    }

    /// Returns the material with negative values kept: not physical, but comparable with other
    /// readers.
    #[must_use]
    pub fn keep_negative(self) -> Self {
        Self { keeps_negative: true, ..self }
    }
}

impl Symmetry {
    /// Derives the symmetry from the measured fraction of a turn.
    fn of(phi: &Axis) -> Self {
        if phi.len() <= 2 {
            return Self::Isotropic;
        }
        let parts = (TAU / phi.span()).round();
        match parts {
            2.0 => Self::Half,
            4.0 => Self::Quarter,
            _ => Self::None,
        }
    }

    /// Maps a pair to an equivalent pair within the measured azimuths.
    fn reduce(self, wi: DVec3, wo: DVec3) -> (DVec3, DVec3) {
        // Measured azimuths are -pi to 0, or -pi to -pi / 2.
        let (x, y) = match self {
            Self::Isotropic | Self::None => (false, false),
            Self::Half => (wi.y > 0.0, wi.y > 0.0),
            Self::Quarter => (wi.x > 0.0, wi.y > 0.0),
        };
        let sign = |turned: bool| if turned { -1.0 } else { 1.0 };
        let signs = DVec3::new(sign(x), sign(y), 1.0);
        (wi * signs, wo * signs)
    }
}

/// Position of a direction in the unit square: square root of the polar angle, then the azimuth.
fn square_position(theta: f64, phi: f64) -> DVec2 {
    let turns = (phi + PI) / TAU;
    DVec2::new((theta / FRAC_PI_2).sqrt(), turns - turns.floor())
}

fn polar(w: DVec3) -> f64 {
    libm::atan2(libm::hypot(w.x, w.y), w.z)
}

impl Brdf for Rgl {
    fn f(&self, pair: &DirectionPair) -> DVec3 {
        if !(pair.cos_i() > 0.0 && pair.cos_o() > 0.0) {
            return DVec3::ZERO;
        }
        let (wi, wo) = self.symmetry.reduce(pair.wi(), pair.wo());
        let h = wi + wo;
        let (theta_i, phi_i) = (polar(wi), libm::atan2(wi.y, wi.x));
        let (theta_m, phi_m) = (polar(h), libm::atan2(h.y, h.x));
        let azimuth = if self.symmetry == Symmetry::Isotropic { phi_m - phi_i } else { phi_m };
        let normal = square_position(theta_m, azimuth);
        let weights = SliceWeights::of((&self.phi, phi_i), (&self.theta, theta_i));
        let uniform = self.vndf.invert(normal, &weights);
        let rgb = [0, 1, 2].map(|channel| self.rgb.strided(uniform, &weights, (3, channel)));
        let least = if self.keeps_negative { DVec3::NEG_INFINITY } else { DVec3::ZERO };
        let mut f = DVec3::from_array(rgb).max(least) / pair.cos_o();
        if self.needs_density {
            let sigma = self.sigma.at(square_position(theta_i, phi_i), &SliceWeights::WHOLE);
            if sigma <= 0.0 {
                return DVec3::ZERO;
            }
            f *= self.ndf.at(normal, &SliceWeights::WHOLE) / (4.0 * sigma);
        }
        f
    }

    fn claims(&self) -> Claims {
        Claims { reciprocal: false, conserving: false }
    }
}

#[cfg(test)]
mod tests;
