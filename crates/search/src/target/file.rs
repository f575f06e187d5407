//! Targets from the bytes of files, one kind after the other: the same for the command line, the server and its workers.

use std::fmt;
use std::str::FromStr;

use brood_brdf::{
    Brdf, CsvError, DirectionPair, GoniometerError, Merl, MerlError, Rgl, RglError, Samples,
    Scattered, Slice, SliceError,
};
use brood_eval::{LinearPictureError, decode_linear};

use super::bundle::{BundleError, PictureBundle};
use super::known::Pictures;
use super::{MeasuredTarget, TargetError};

/// Far more than a slice has: a picture of another size is told by its size, not by its bytes.
const SLICE_PX: u32 = 4096;
/// A pair of directions and what is reflected there.
const SAMPLE_BYTES: usize = size_of::<DirectionPair>() + size_of::<[f64; 3]>();

/// What a file holds that a search can match.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum TargetKind {
    /// A CSV of directions and reflectances.
    Samples,
    /// An image slice as EXR.
    Slice,
    /// A MERL `.binary`.
    Merl,
    /// An RGL `.bsdf`.
    Rgl,
    /// A goniometer's text, as Cornell published them.
    Cornell,
    /// Pictures of known scenes, together with the scenes.
    Image,
}

impl TargetKind {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::Samples, Self::Slice, Self::Merl, Self::Rgl, Self::Cornell, Self::Image];

    /// As it is written.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Samples => "samples",
            Self::Slice => "slice",
            Self::Merl => "merl",
            Self::Rgl => "rgl",
            Self::Cornell => "cornell",
            Self::Image => "image",
        }
    }

    /// As people say it.
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

    /// The kind of files with that ending, without its dot and in lower case. Pictures need more than a file.
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

/// A word that is no kind of target.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("a kind of target is one of {}", TargetKind::ALL.map(TargetKind::name).join(", "))]
pub struct UnknownKind;

impl FromStr for TargetKind {
    type Err = UnknownKind;

    fn from_str(text: &str) -> Result<Self, UnknownKind> {
        Self::ALL.into_iter().find(|kind| kind.name() == text).ok_or(UnknownKind)
    }
}

/// A target that was read from a file.
#[derive(Debug)]
pub struct TargetFile {
    /// What is to be matched.
    pub target: MeasuredTarget,
    /// Samples of the file that are not above the surface.
    pub skipped: usize,
    /// Samples of the file in all; 0 where it is known everywhere.
    pub rows: usize,
    /// The pictures, where it is of those.
    pub pictures: Option<Pictures>,
}

/// A measured material that was read from a file, as it can be drawn.
pub struct MeasuredFile {
    /// What was measured, between and beside the samples as well.
    pub brdf: Box<dyn Brdf>,
    /// Samples of the file that are not above the surface.
    pub skipped: usize,
    /// Samples of the file in all; 0 where it is known everywhere.
    pub rows: usize,
}

/// Why bytes are no target of that kind.
#[derive(Debug, thiserror::Error)]
pub enum TargetFileError {
    /// No CSV of samples.
    #[error(transparent)]
    Csv(#[from] CsvError),
    /// No goniometer's text.
    #[error(transparent)]
    Goniometer(#[from] GoniometerError),
    /// No MERL table.
    #[error(transparent)]
    Merl(#[from] MerlError),
    /// No RGL material.
    #[error(transparent)]
    Rgl(#[from] RglError),
    /// A picture whose numbers are not reflectances.
    #[error("this is no EXR file, and an image slice is one")]
    Codes,
    /// No picture.
    #[error(transparent)]
    Picture(#[from] LinearPictureError),
    /// A picture, but no slice.
    #[error(transparent)]
    Slice(#[from] SliceError),
    /// Readable, and still nothing to match.
    #[error(transparent)]
    Target(#[from] TargetError),
    /// No pictures of known scenes, or none that a material can be told from.
    #[error(transparent)]
    Bundle(#[from] BundleError),
    /// A material was wanted, and pictures show one only where they look.
    #[error("a picture is known in its own scene and light alone")]
    OnlyPictures,
}

impl TargetFile {
    /// Reads a file of that kind.
    pub fn read(kind: TargetKind, bytes: &[u8]) -> Result<Self, TargetFileError> {
        let known = |target| Self { target, skipped: 0, rows: 0, pictures: None };
        let of_samples = |samples: &Samples| {
            let skipped = samples.skipped();
            let target = MeasuredTarget::of_samples(samples)?;
            let rows = samples.rows().len() + skipped;
            Ok(Self { target, skipped, rows, pictures: None })
        };
        match kind {
            TargetKind::Samples => of_samples(&Samples::from_csv(bytes)?),
            TargetKind::Cornell => of_samples(&Samples::from_goniometer(bytes)?),
            TargetKind::Slice => Ok(known(MeasuredTarget::of_slice(&slice(bytes)?)?)),
            TargetKind::Merl => Ok(known(MeasuredTarget::of(&Merl::read(bytes)?)?)),
            TargetKind::Rgl => Ok(known(MeasuredTarget::of(&Rgl::read(bytes)?)?)),
            TargetKind::Image => {
                let (pictures, target) = PictureBundle::decode(bytes)?.target()?;
                Ok(Self { pictures: Some(pictures), ..known(target) })
            }
        }
    }

    /// Bytes of memory that it takes, about.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let samples = self.target.fitted.len() + self.target.held.len();
        let pictures = self.pictures.as_ref().map_or(0, Pictures::bytes);
        samples * SAMPLE_BYTES + pictures
    }
}

impl MeasuredFile {
    /// Reads a file of that kind; pictures are none.
    pub fn read(kind: TargetKind, bytes: &[u8]) -> Result<Self, TargetFileError> {
        let known = |brdf| Self { brdf, skipped: 0, rows: 0 };
        let scattered = |samples: &Samples| {
            let skipped = samples.skipped();
            let rows = samples.rows().len() + skipped;
            Self { brdf: Box::new(Scattered::new(samples)), skipped, rows }
        };
        Ok(match kind {
            TargetKind::Samples => scattered(&Samples::from_csv(bytes)?),
            TargetKind::Cornell => scattered(&Samples::from_goniometer(bytes)?),
            TargetKind::Slice => known(Box::new(slice(bytes)?)),
            TargetKind::Merl => known(Box::new(Merl::read(bytes)?)),
            TargetKind::Rgl => known(Box::new(Rgl::read(bytes)?)),
            TargetKind::Image => return Err(TargetFileError::OnlyPictures),
        })
    }
}

fn slice(bytes: &[u8]) -> Result<Slice, TargetFileError> {
    let picture = match decode_linear(bytes, SLICE_PX) {
        Ok(picture) if picture.is_linear => picture,
        Ok(_) | Err(LinearPictureError::Kind) => return Err(TargetFileError::Codes),
        Err(error) => return Err(error.into()),
    };
    Ok(Slice::new(picture.width as usize, picture.height as usize, picture.pixels)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(kind: TargetKind, bytes: &[u8]) -> String {
        TargetFile::read(kind, bytes).err().unwrap().to_string()
    }

    #[test]
    fn kinds_are_told_by_name_and_by_ending() {
        for kind in TargetKind::ALL {
            assert_eq!(kind.name().parse(), Ok(kind));
        }
        assert_eq!("picture".parse::<TargetKind>(), Err(UnknownKind));
        assert_eq!(TargetKind::of_extension("bsdf"), Some(TargetKind::Rgl));
        assert_eq!(TargetKind::of_extension("brood"), None);
    }

    #[test]
    fn csv_is_read_and_counted() {
        let mut text = String::from("wix,wiy,wiz,wox,woy,woz,r,g,b\n");
        for _ in 0..200 {
            text += "0,0,1,0.6,0,0.8,0.5,0.25,0.125\n";
        }
        text += "0,0,-1,0.6,0,0.8,1,1,1\n";
        let read = TargetFile::read(TargetKind::Samples, text.as_bytes()).unwrap();
        assert_eq!((read.rows, read.skipped, read.target.held.len()), (201, 1, 40));
    }

    #[test]
    fn what_is_no_target_is_refused_in_words() {
        assert!(refused(TargetKind::Samples, b"r,g,b\n").contains("column wix"));
        assert!(refused(TargetKind::Merl, &[0; 20]).contains("90"));
        assert!(refused(TargetKind::Rgl, b"tensor").contains("ends within its head"));
        assert!(refused(TargetKind::Slice, b"tensor").contains("no EXR"));
        assert!(refused(TargetKind::Cornell, b"analytic\n").contains("formula"));
    }
}
