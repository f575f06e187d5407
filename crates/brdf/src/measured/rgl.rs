//! RGL's `.bsdf`: a material measured where its own microfacets send the light, as a table over the numbers that they are drawn by.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DVec2, DVec3};

use super::tensor::{TensorError, Tensors};
use super::warp::{Axis, Grid, Mix, Warp, WarpError};
use crate::{Brdf, Claims, DirectionPair};

/// A measured material, isotropic or not.
///
/// Values below 0, which colours beyond the display's have, are 0 once they are interpolated, unless they are asked for
/// ([`Rgl::keep_negative`]).
///
/// # Source
/// Dupuy and Jakob 2018, "An adaptive parameterization for efficient material acquisition and rendering".
pub struct Rgl {
    phi: Axis,
    theta: Axis,
    symmetry: Symmetry,
    /// Density of the normals, and the area that they show to a direction.
    ndf: Grid,
    sigma: Grid,
    /// Density of the normals that are seen from a direction.
    vndf: Warp,
    /// Red, green and blue after each other, f cos_o over the density by which it was sampled.
    rgb: Grid,
    /// That density is to be multiplied with.
    weighted: bool,
    /// What is interpolated may be below 0.
    negative: bool,
}

/// What turning the material about its normal changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Symmetry {
    /// Nothing.
    Isotropic,
    /// Everything: measured over a whole turn.
    None,
    /// Half a turn changes nothing, and half of it was measured.
    Half,
    /// Mirrored in both axes it is the same, and a quarter was measured.
    Quarter,
}

/// Why bytes are no such material.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum RglError {
    /// Not the container, or not what it should hold.
    #[error("the .bsdf file cannot be read: {0}")]
    Tensor(#[from] TensorError),
    /// Spectra instead of colours.
    #[error(
        "the .bsdf file holds spectra at {0} wavelengths; only the RGB variant of a material is read"
    )]
    Spectral(usize),
    /// Angles of incidence that do not ascend.
    #[error("the angles {0} of the .bsdf file do not ascend")]
    Angles(&'static str),
    /// A table with fewer than two entries along a side.
    #[error("the table {0} of the .bsdf file is too small")]
    Small(&'static str),
    /// A density below 0.
    #[error("entry {1} of the table {0} of the .bsdf file is below 0")]
    Negative(&'static str, usize),
    /// A direction from which nothing is seen.
    #[error("the table vndf of the .bsdf file is 0 everywhere for the incidence number {0}")]
    Empty(usize),
}

impl Rgl {
    /// Reads a file.
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
        let weighted = tensors.byte("jacobian")? != 0;
        let symmetry = Symmetry::of(&phi);
        Ok(Self { phi, theta, symmetry, ndf, sigma, vndf, rgb, weighted, negative: false })
    }

    /// The same with the values below 0 that its tables give: no reflectance, but what other readers of the file have.
    #[must_use]
    pub fn keep_negative(self) -> Self {
        Self { negative: true, ..self }
    }
}

impl Symmetry {
    /// By how much of a turn was measured.
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

    /// The same directions to this material, where it was measured.
    fn reduce(self, wi: DVec3, wo: DVec3) -> (DVec3, DVec3) {
        // Measured are azimuths from -pi to 0, or to -pi / 2.
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

/// Where a direction lies in the square: the polar angle by its square root, then the azimuth.
fn place(theta: f64, phi: f64) -> DVec2 {
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
        let about = if self.symmetry == Symmetry::Isotropic { phi_m - phi_i } else { phi_m };
        let normal = place(theta_m, about);
        let mix = Mix::of((&self.phi, phi_i), (&self.theta, theta_i));
        let drawn = self.vndf.invert(normal, &mix);
        let rgb = [0, 1, 2].map(|channel| self.rgb.strided(drawn, &mix, (3, channel)));
        let least = if self.negative { DVec3::NEG_INFINITY } else { DVec3::ZERO };
        let mut f = DVec3::from_array(rgb).max(least) / pair.cos_o();
        if self.weighted {
            let sigma = self.sigma.at(place(theta_i, phi_i), &Mix::WHOLE);
            if sigma <= 0.0 {
                return DVec3::ZERO;
            }
            f *= self.ndf.at(normal, &Mix::WHOLE) / (4.0 * sigma);
        }
        f
    }

    fn claims(&self) -> Claims {
        Claims { reciprocal: false, conserving: false }
    }
}

#[cfg(test)]
mod tests;
