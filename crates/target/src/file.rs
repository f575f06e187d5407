//! Readers of target files of every kind, shared by the command line, the server and its workers.

use std::fmt;
use std::str::FromStr;

use brood_brdf::{
    Brdf, CsvError, DirectionPair, GoniometerError, ImageSlice, ImageSliceError, MeasuredSamples,
    Merl, MerlError, Rgl, RglError, Scattered,
};
use brood_eval::{LinearPictureError, decode_linear};

use crate::bundle::{BundleError, PictureBundle};
use crate::known::Pictures;
use crate::{MeasuredTarget, TargetError};

/// Largest side of a slice. Above the side of any slice, so that the error is about the slice's
/// size.
const SLICE_PX: u32 = 4096;
/// Bytes of a pair of directions and its reflectance.
const SAMPLE_BYTES: usize = size_of::<DirectionPair>() + size_of::<[f64; 3]>();

brood_brdf::named_enum! {
    /// Kind of a target file; the name is that in requests and on the command line.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub enum TargetKind {
        /// CSV of directions and reflectances.
        Samples => "samples",
        /// Image slice as EXR.
        Slice => "slice",
        /// MERL `.binary`.
        Merl => "merl",
        /// RGL `.bsdf`.
        Rgl => "rgl",
        /// Goniometer measurements as text, as published by Cornell.
        Cornell => "cornell",
        /// Pictures of known scenes, bundled with the scenes.
        Image => "image",
    }
}

impl TargetKind {
    /// Name on the page and in messages.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Samples => "scattered samples",
            Self::Slice => "image slice",
            Self::Merl => "MERL table",
            Self::Rgl => "RGL material",
            Self::Cornell => "goniometer measurements",
            Self::Image => "picture",
        }
    }

    /// Kind of files with this extension, in lower case without the dot. Pictures have none: they
    /// need a scene as well.
    #[must_use]
    pub fn of_extension(extension: &str) -> Option<Self> {
        match extension {
            "csv" => Some(Self::Samples),
            "exr" => Some(Self::Slice),
            "binary" => Some(Self::Merl),
            "bsdf" => Some(Self::Rgl),
            "brdf" => Some(Self::Cornell),
            _ => None,
        }
    }
}

impl fmt::Display for TargetKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Error for a name that is no kind of target.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("unknown kind of target; use one of {}", TargetKind::ALL.map(TargetKind::name).join(", "))]
pub struct UnknownKind;

impl FromStr for TargetKind {
    type Err = UnknownKind;

    fn from_str(text: &str) -> Result<Self, UnknownKind> {
        Self::from_name(text).ok_or(UnknownKind)
    }
}

/// A target read from a file.
#[derive(Debug)]
pub struct TargetFile {
    /// Samples to match.
    pub target: MeasuredTarget,
    /// Number of samples in the file that are not above the surface and were skipped.
    pub skipped: usize,
    /// Total number of samples in the file; 0 for tables, which are defined everywhere.
    pub rows: usize,
    /// Pictures, if the file is a bundle of them.
    pub pictures: Option<Pictures>,
}

/// A measured material read from a file, for rendering.
pub struct MeasuredFile {
    /// Material, interpolated and extrapolated from the samples.
    pub brdf: Box<dyn Brdf>,
    /// Number of samples in the file that are not above the surface and were skipped.
    pub skipped: usize,
    /// Total number of samples in the file; 0 for tables, which are defined everywhere.
    pub rows: usize,
}

/// Error of reading a target file.
#[derive(Debug, thiserror::Error)]
pub enum TargetFileError {
    /// Invalid CSV of samples.
    #[error(transparent)]
    Csv(#[from] CsvError),
    /// Invalid goniometer text.
    #[error(transparent)]
    Goniometer(#[from] GoniometerError),
    /// Invalid MERL table.
    #[error(transparent)]
    Merl(#[from] MerlError),
    /// Invalid RGL material.
    #[error(transparent)]
    Rgl(#[from] RglError),
    /// A picture of another format, whose pixels are display codes and not reflectances.
    #[error("this is no EXR file; an image slice must be EXR")]
    Codes,
    /// Invalid picture.
    #[error(transparent)]
    Picture(#[from] LinearPictureError),
    /// A valid picture that is no image slice.
    #[error(transparent)]
    Slice(#[from] ImageSliceError),
    /// Readable, but nothing to match.
    #[error(transparent)]
    Target(#[from] TargetError),
    /// Invalid bundle of pictures, or pictures without usable pixels.
    #[error(transparent)]
    Bundle(#[from] BundleError),
    /// Pictures cannot be read as a material: they show it only in their scene.
    #[error("pictures show a material only in their own scene and light")]
    OnlyPictures,
}

impl TargetFile {
    /// Reads a file of this kind.
    ///
    /// # Errors
    /// Returns [`TargetFileError`] if the bytes are not a file of this kind, or hold nothing to
    /// match.
    pub fn read(kind: TargetKind, bytes: &[u8]) -> Result<Self, TargetFileError> {
        let known = |target| Self { target, skipped: 0, rows: 0, pictures: None };
        let of_samples = |samples: &MeasuredSamples| {
            let skipped = samples.skipped();
            let target = MeasuredTarget::of_samples(samples)?;
            let rows = samples.rows().len() + skipped;
            Ok(Self { target, skipped, rows, pictures: None })
        };
        match kind {
            TargetKind::Samples => of_samples(&MeasuredSamples::from_csv(bytes)?),
            TargetKind::Cornell => of_samples(&MeasuredSamples::from_goniometer(bytes)?),
            TargetKind::Slice => Ok(known(MeasuredTarget::of_slice(&slice(bytes)?)?)),
            TargetKind::Merl => Ok(known(MeasuredTarget::of(&Merl::read(bytes)?)?)),
            TargetKind::Rgl => Ok(known(MeasuredTarget::of(&Rgl::read(bytes)?)?)),
            TargetKind::Image => {
                let (pictures, target) = PictureBundle::decode(bytes)?.target()?;
                Ok(Self { pictures: Some(pictures), ..known(target) })
            }
        }
    }

    /// Approximate memory use in bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let MeasuredTarget { fitted, held, .. } = &self.target;
        let samples = fitted.len() + held.len();
        let means = fitted.means().bytes() + held.means().bytes();
        let pictures = self.pictures.as_ref().map_or(0, Pictures::bytes);
        samples * SAMPLE_BYTES + means + pictures
    }
}

impl MeasuredFile {
    /// Reads a file of this kind.
    ///
    /// # Errors
    /// Returns [`TargetFileError::OnlyPictures`] for pictures, and the error of the format if the
    /// bytes are not a file of this kind.
    pub fn read(kind: TargetKind, bytes: &[u8]) -> Result<Self, TargetFileError> {
        let known = |brdf| Self { brdf, skipped: 0, rows: 0 };
        let scattered = |samples: &MeasuredSamples| {
            let skipped = samples.skipped();
            let rows = samples.rows().len() + skipped;
            Self { brdf: Box::new(Scattered::new(samples)), skipped, rows }
        };
        Ok(match kind {
            TargetKind::Samples => scattered(&MeasuredSamples::from_csv(bytes)?),
            TargetKind::Cornell => scattered(&MeasuredSamples::from_goniometer(bytes)?),
            TargetKind::Slice => known(Box::new(slice(bytes)?)),
            TargetKind::Merl => known(Box::new(Merl::read(bytes)?)),
            TargetKind::Rgl => known(Box::new(Rgl::read(bytes)?)),
            TargetKind::Image => return Err(TargetFileError::OnlyPictures),
        })
    }
}

fn slice(bytes: &[u8]) -> Result<ImageSlice, TargetFileError> {
    let picture = match decode_linear(bytes, SLICE_PX) {
        Ok(picture) if picture.is_linear => picture,
        Ok(_) | Err(LinearPictureError::Kind) => return Err(TargetFileError::Codes),
        Err(error) => return Err(error.into()),
    };
    Ok(ImageSlice::new(picture.width as usize, picture.height as usize, picture.pixels)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(kind: TargetKind, bytes: &[u8]) -> String {
        TargetFile::read(kind, bytes).err().unwrap().to_string()
    }

    #[test]
    fn target_kind_parses_names_and_extensions() {
        for kind in TargetKind::ALL {
            assert_eq!(kind.name().parse(), Ok(kind));
        }
        assert_eq!("picture".parse::<TargetKind>(), Err(UnknownKind));
        assert_eq!(TargetKind::of_extension("bsdf"), Some(TargetKind::Rgl));
        assert_eq!(TargetKind::of_extension("brood"), None);
    }

    #[test]
    fn csv_samples_are_read_and_counted() {
        let mut text = String::from("wix,wiy,wiz,wox,woy,woz,r,g,b\n");
        for _ in 0..200 {
            text += "0,0,1,0.6,0,0.8,0.5,0.25,0.125\n";
        }
        text += "0,0,-1,0.6,0,0.8,1,1,1\n";
        let read = TargetFile::read(TargetKind::Samples, text.as_bytes()).unwrap();
        assert_eq!((read.rows, read.skipped, read.target.held.len()), (201, 1, 40));
    }

    #[test]
    fn read_explains_rejected_files() {
        assert!(refused(TargetKind::Samples, b"r,g,b\n").contains("column wix"));
        assert!(refused(TargetKind::Merl, &[0; 20]).contains("90"));
        assert!(refused(TargetKind::Rgl, b"tensor").contains("ends within its head"));
        assert!(refused(TargetKind::Slice, b"tensor").contains("no EXR"));
        assert!(refused(TargetKind::Cornell, b"analytic\n").contains("formula"));
    }
}
