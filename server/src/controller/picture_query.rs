//! Query parameters that pictures have in common.

use brood_protocol::PictureFormat;
use brood_scene::{PictureSize, Sampling};

use crate::limit;
use crate::problem::{ApiError, quote};

/// Default side of a picture in pixels.
pub const SIZE: u32 = 256;

/// Returns the size of a picture; 256 x 256 pixels by default.
///
/// # Errors
/// 400 if it is not a size or out of range.
pub fn size(asked: Option<&str>) -> Result<PictureSize, ApiError> {
    asked.map_or(Ok(SIZE.into()), |text| limit::size(text, limit::PICTURE_PX))
}

/// Checks a light angle.
///
/// # Errors
/// 400 if it is not a number from -1e6 to 1e6.
pub fn check_light(light_deg: Option<f64>) -> Result<(), ApiError> {
    match light_deg.filter(|light| !(light.is_finite() && light.abs() <= 1e6)) {
        Some(_) => Err(ApiError::bad_parameter("light_deg", "must be a number from -1e6 to 1e6")),
        None => Ok(()),
    }
}

/// Checks that a picture needs at most [`limit::RAYS`] rays.
///
/// # Errors
/// 422 if it needs more.
pub fn check_rays(pixels: u64, sampling: Sampling) -> Result<(), ApiError> {
    let rays = pixels * u64::from(sampling.min_rays());
    if rays > limit::RAYS {
        let words =
            format!("size and samples add up to {rays} rays; at most {} are allowed", limit::RAYS);
        return Err(ApiError::refused(words));
    }
    Ok(())
}

/// Returns the content type of a format.
pub fn content_type(format: PictureFormat) -> &'static str {
    match format {
        PictureFormat::Png => "image/png",
        PictureFormat::Exr => "image/x-exr",
        PictureFormat::Spheres | PictureFormat::Angles | PictureFormat::RayEnds => {
            "application/octet-stream"
        }
    }
}

/// Parses a `samples` parameter; adaptive by default.
///
/// # Errors
/// 400 if it is neither `adaptive` nor 1 to 64.
pub fn sampling(text: Option<&str>) -> Result<Sampling, ApiError> {
    let Some(text) = text else { return Ok(Sampling::default()) };
    let known =
        text.parse().ok().filter(|sampling: &Sampling| sampling.min_rays() <= limit::SAMPLES);
    known.ok_or_else(|| {
        let words = format!("must be adaptive or 1 to {}, got {}", limit::SAMPLES, quote(text));
        ApiError::bad_parameter("samples", words)
    })
}
