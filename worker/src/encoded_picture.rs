//! Picture as a file, with the cost of shading it.

use brood_eval::{
    Developed, LitBackdrop, LitSpheres, RadianceImage, encode_angles, encode_exr, encode_png,
    encode_ray_ends,
};
use brood_inspect::Picture;
use brood_program::Program;
use brood_protocol::{PictureFormat, PictureKey, RenderedPicture};
use brood_scene::{LitAngles, LobeNodes, RayEnds, SphereLayout};

use crate::error::RenderError;
use crate::evaluated_picture::EvaluatedPicture;

fn no_picture() -> RenderError {
    RenderError::Encode("the format does not show this subject".to_owned())
}

/// Encoded picture.
pub(crate) struct EncodedPicture {
    pub(crate) bytes: Vec<u8>,
    /// Exposure that was applied, in EV; 0 for linear files.
    pub(crate) exposure_ev: f64,
    /// Number of samples shaded.
    pub(crate) samples: u64,
    /// Number of scalar operations executed.
    pub(crate) operations: u64,
}

impl EncodedPicture {
    /// Develops and encodes a picture of a program.
    pub(crate) fn of(
        format: PictureFormat,
        program: &Program,
        picture: &dyn EvaluatedPicture,
        backdrop: &LitBackdrop,
    ) -> Result<Self, RenderError> {
        let encoded = match format {
            PictureFormat::Png => Self::png(&backdrop.behind(picture.develop()?)),
            PictureFormat::Exr => {
                let mut radiance = picture.radiance()?;
                backdrop.join(&mut radiance);
                Self::exr(&radiance)?
            }
            PictureFormat::Spheres | PictureFormat::Angles | PictureFormat::RayEnds => {
                return Err(no_picture());
            }
        };
        let samples = picture.samples();
        Ok(Self { samples, operations: samples * program.operations() as u64, ..encoded })
    }

    /// Encodes a picture of a material that is not a program.
    pub(crate) fn of_material(
        format: PictureFormat,
        picture: &Picture,
    ) -> Result<Self, RenderError> {
        let encoded = match format {
            PictureFormat::Png => Self::png(&picture.developed),
            PictureFormat::Exr => Self::exr(&picture.radiance)?,
            PictureFormat::Spheres | PictureFormat::Angles | PictureFormat::RayEnds => {
                return Err(no_picture());
            }
        };
        Ok(Self { samples: picture.samples as u64, ..encoded })
    }

    /// Encodes a developed picture.
    pub(crate) fn png(developed: &Developed) -> Self {
        let Developed { width, height, rgba, exposure_ev } = developed;
        let bytes = encode_png(*width, *height, rgba);
        Self { bytes, exposure_ev: *exposure_ev, samples: 0, operations: 0 }
    }

    /// Encodes the radiance of a program on its lit spheres.
    pub(crate) fn spheres(
        layout: SphereLayout,
        radiance: &[[f32; 3]],
        backdrop: Option<&[[f32; 3]]>,
        program: &Program,
    ) -> Self {
        let samples = LobeNodes::get().set().len() as u64;
        let operations = samples * program.operations() as u64;
        let bytes = LitSpheres::encode(layout, radiance, backdrop);
        Self { bytes, exposure_ev: 0.0, samples, operations }
    }

    /// Encodes the angles at which the lights of a scene reach its points.
    pub(crate) fn angles(angles: &LitAngles) -> Self {
        Self::of_geometry(encode_angles(angles))
    }

    /// Encodes the ends of the rays of a clear body.
    pub(crate) fn ray_ends(ends: &RayEnds) -> Self {
        Self::of_geometry(encode_ray_ends(ends))
    }

    fn of_geometry(bytes: Vec<u8>) -> Self {
        Self { bytes, exposure_ev: 0.0, samples: 0, operations: 0 }
    }

    fn exr(radiance: &RadianceImage) -> Result<Self, RenderError> {
        let bytes = encode_exr(radiance).map_err(|error| RenderError::Encode(error.to_string()))?;
        Ok(Self { bytes, exposure_ev: 0.0, samples: 0, operations: 0 })
    }

    /// Returns the picture with its key.
    pub(crate) fn with_key(self, key: PictureKey) -> RenderedPicture {
        let Self { bytes, exposure_ev, samples, operations } = self;
        RenderedPicture { key, bytes, exposure_ev, samples, operations }
    }
}
