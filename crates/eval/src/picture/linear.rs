//! Decoding of pictures: to linear light (EXR and Radiance HDR unchanged, PNG and JPEG through the
//! sRGB curve), and to codes of a display.

use std::io::Cursor;

use image::{DynamicImage, ImageFormat, ImageReader, Limits};

use brood_light::ImagePyramid;
use brood_scene::PixelArea;

use super::codec::{check_header, image_words};
use crate::RadianceImage;
use crate::film::decode_srgb;

/// A picture as linear red, green and blue.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearPicture {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Pixels row by row from the top, multiplied by alpha if the picture has one.
    pub pixels: Vec<[f32; 3]>,
    /// True for pixels with a channel at the largest code, which may have been brighter. Always
    /// false for files of linear light.
    pub clipped: Vec<bool>,
    /// True if the file stores linear light instead of codes of a curve.
    pub is_linear: bool,
}

/// A picture as codes of a display.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DisplayPicture {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Red, green, blue and straight alpha of each pixel, row by row from the top, as 8-bit sRGB.
    pub rgba: Vec<u8>,
}

/// Error of a picture that cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum LinearPictureError {
    /// The format is not supported.
    #[error("the picture must be an EXR, Radiance HDR, PNG or JPEG file")]
    Kind,
    /// The format does not store codes of a display.
    #[error("the picture must be a PNG or JPEG file")]
    DisplayKind,
    /// The picture has too many pixels.
    #[error("a picture has at most {most} x {most} pixels; this one has {width} x {height}")]
    Side {
        /// Most pixels in each direction.
        most: u32,
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
    },
    /// The file ends before the picture does.
    #[error("the picture cannot be read: the JPEG file is cut off")]
    CutOff,
    /// The file is broken or too large.
    #[error("the picture cannot be read: {}", image_words(.0))]
    Image(#[from] image::ImageError),
}

/// Decodes a picture.
///
/// # Units
/// EXR and HDR: the units of the file, with the primaries of sRGB. PNG and JPEG: 1 is the largest
/// code.
///
/// # Domain
/// At most `side` pixels in each direction. EXR values that are not finite are returned unchanged.
///
/// # Errors
/// Returns [`LinearPictureError::Kind`] for other formats, [`LinearPictureError::Image`] if the
/// file is broken or too large.
pub fn decode_linear(bytes: &[u8], side: u32) -> Result<LinearPicture, LinearPictureError> {
    let format = image::guess_format(bytes).map_err(|_| LinearPictureError::Kind)?;
    let is_linear = match format {
        ImageFormat::OpenExr | ImageFormat::Hdr => true,
        ImageFormat::Png | ImageFormat::Jpeg => false,
        _ => return Err(LinearPictureError::Kind),
    };
    let decoded = decode(bytes, format, side)?;
    Ok(if is_linear { linear(&decoded) } else { encoded(&decoded) })
}

/// Decodes a PNG or JPEG to codes; those of 16 bits are rounded. Colour profiles have no effect.
///
/// # Domain
/// At most `side` pixels in each direction.
///
/// # Errors
/// Returns [`LinearPictureError::DisplayKind`] for other formats, [`LinearPictureError::Side`] if
/// the picture is too large, [`LinearPictureError::CutOff`] if the end of a JPEG is missing,
/// [`LinearPictureError::Image`] if the file is broken.
pub fn decode_display(bytes: &[u8], side: u32) -> Result<DisplayPicture, LinearPictureError> {
    let format = match image::guess_format(bytes) {
        Ok(format @ (ImageFormat::Png | ImageFormat::Jpeg)) => format,
        _ => return Err(LinearPictureError::DisplayKind),
    };
    let (width, height) = picture_size(bytes)?;
    if width.max(height) > side {
        return Err(LinearPictureError::Side { most: side, width, height });
    }
    // The decoder fills what is missing with grey.
    if format == ImageFormat::Jpeg && !has_end(bytes) {
        return Err(LinearPictureError::CutOff);
    }
    Ok(DisplayPicture { width, height, rgba: decode(bytes, format, side)?.into_rgba8().into_raw() })
}

/// Largest width or height of images that scenes and painted materials name, in pixels.
pub const IMAGE_SIDE_MOST: u32 = 4096;

/// Decodes the PNG or JPEG file of an image that scenes and painted materials name.
///
/// # Errors
/// As [`decode_display`].
pub fn decode_image(file: &[u8]) -> Result<ImagePyramid, LinearPictureError> {
    let DisplayPicture { width, height, rgba } = decode_display(file, IMAGE_SIDE_MOST)?;
    Ok(ImagePyramid::new(width, height, &rgba))
}

fn decode(bytes: &[u8], format: ImageFormat, side: u32) -> Result<DynamicImage, image::ImageError> {
    check_header(bytes, format)?;
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(side), Some(side));
    reader.limits(limits);
    reader.decode()
}

/// True if the segments and scans of a JPEG file lead to the marker of its end. What follows the
/// marker does not matter.
fn has_end(bytes: &[u8]) -> bool {
    const START: u8 = 0xd8;
    const END: u8 = 0xd9;
    let mut at = 0;
    loop {
        // Within a scan, 0xff is followed by 0 or by the marker of a restart.
        let Some(next) = bytes[at..]
            .windows(2)
            .position(|pair| pair[0] == 0xff && !matches!(pair[1], 0 | 0xff | 0xd0..=0xd7))
        else {
            return false;
        };
        let marker = bytes[at + next + 1];
        at += next + 2;
        if marker == END {
            return true;
        }
        if marker != START {
            let Some(length) = bytes[at..].first_chunk() else { return false };
            at += usize::from(u16::from_be_bytes(*length));
        }
        if at >= bytes.len() {
            return false;
        }
    }
}

/// Reads width and height from the header, so that a large picture can be rejected without decoding
/// it.
///
/// # Errors
/// Returns [`LinearPictureError::Kind`] for an unknown format, [`LinearPictureError::Image`] if the
/// header is broken.
pub fn picture_size(bytes: &[u8]) -> Result<(u32, u32), LinearPictureError> {
    let format = image::guess_format(bytes).map_err(|_| LinearPictureError::Kind)?;
    check_header(bytes, format)?;
    Ok(ImageReader::with_format(Cursor::new(bytes), format).into_dimensions()?)
}

impl LinearPicture {
    /// Returns a part of the picture, with its values unchanged.
    ///
    /// # Domain
    /// `area` lies within the picture ([`PixelArea::is_within`]).
    #[must_use]
    pub fn cropped(&self, area: PixelArea) -> Self {
        let rows = area.y..area.y + area.height;
        let spans = rows.map(|row| {
            let from = row as usize * self.width as usize + area.x as usize;
            from..from + area.width as usize
        });
        Self {
            width: area.width,
            height: area.height,
            pixels: spans.clone().flat_map(|span| self.pixels[span].iter().copied()).collect(),
            clipped: spans.flat_map(|span| self.clipped[span].iter().copied()).collect(),
            is_linear: self.is_linear,
        }
    }
}

impl From<&RadianceImage> for LinearPicture {
    fn from(image: &RadianceImage) -> Self {
        Self {
            width: image.width(),
            height: image.height(),
            pixels: image.premultiplied().to_vec(),
            clipped: vec![false; image.premultiplied().len()],
            is_linear: true,
        }
    }
}

fn linear(decoded: &DynamicImage) -> LinearPicture {
    let (width, height) = (decoded.width(), decoded.height());
    let pixels: Vec<[f32; 3]> = decoded.to_rgb32f().pixels().map(|pixel| pixel.0).collect();
    let clipped = vec![false; pixels.len()];
    LinearPicture { width, height, pixels, clipped, is_linear: true }
}

fn encoded(decoded: &DynamicImage) -> LinearPicture {
    let (width, height) = (decoded.width(), decoded.height());
    let decoded = decoded.to_rgba16();
    let unit = |value: u16| f64::from(value) / 65535.0;
    let pixel = |pixel: &image::Rgba<u16>| {
        let [r, g, b, alpha] = pixel.0;
        #[expect(clippy::cast_possible_truncation, reason = "a code has at most 16 bits")]
        [r, g, b].map(|value| (decode_srgb(unit(value)) * unit(alpha)) as f32)
    };
    let is_clipped = |pixel: &image::Rgba<u16>| pixel.0[..3].contains(&u16::MAX);
    LinearPicture {
        width,
        height,
        pixels: decoded.pixels().map(pixel).collect(),
        clipped: decoded.pixels().map(is_clipped).collect(),
        is_linear: false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(picture: &DynamicImage, format: ImageFormat) -> Vec<u8> {
        let mut bytes = Vec::new();
        picture.write_to(&mut Cursor::new(&mut bytes), format).unwrap();
        bytes
    }

    #[test]
    fn codes_are_decoded_to_light_and_the_largest_code_counts_as_clipped() {
        let mut image = image::RgbaImage::new(2, 1);
        image.put_pixel(0, 0, image::Rgba([254, 188, 0, 255]));
        image.put_pixel(1, 0, image::Rgba([255, 10, 10, 255]));
        let picture =
            decode_linear(&written(&DynamicImage::ImageRgba8(image), ImageFormat::Png), 64)
                .unwrap();
        assert!(!picture.is_linear && (picture.width, picture.height) == (2, 1));
        assert!((picture.pixels[0][1] - 0.502_886).abs() < 1e-5);
        assert_eq!(picture.clipped, [false, true]);
    }

    #[test]
    fn codes_of_a_display_are_returned_with_straight_alpha() {
        let mut image = image::RgbaImage::new(2, 1);
        image.put_pixel(0, 0, image::Rgba([254, 188, 0, 51]));
        let picture = DynamicImage::ImageRgba8(image);
        let bytes = written(&picture, ImageFormat::Png);
        let decoded = decode_display(&bytes, 2).unwrap();
        assert_eq!((decoded.width, decoded.height), (2, 1));
        assert_eq!(decoded.rgba, [254, 188, 0, 51, 0, 0, 0, 0]);
        let deep = written(&DynamicImage::ImageRgba16(picture.to_rgba16()), ImageFormat::Png);
        assert_eq!(decode_display(&deep, 2).unwrap(), decoded);
        let jpeg = written(&DynamicImage::ImageRgb8(picture.to_rgb8()), ImageFormat::Jpeg);
        assert_eq!(decode_display(&jpeg, 2).unwrap().rgba.len(), 8);
        let words = decode_display(&bytes, 1).unwrap_err().to_string();
        assert_eq!(words, "a picture has at most 1 x 1 pixels; this one has 2 x 1");
        let exr = written(
            &DynamicImage::ImageRgb32F(image::Rgb32FImage::new(1, 1)),
            ImageFormat::OpenExr,
        );
        for bytes in [&exr[..], b"GIF89a", b""] {
            let refused = decode_display(bytes, 64);
            assert!(matches!(refused, Err(LinearPictureError::DisplayKind)), "{refused:?}");
        }
        assert!(decode_display(&bytes[..bytes.len() / 2], 64).is_err());
    }

    #[test]
    fn linear_light_is_returned_unchanged() {
        let image = image::Rgb32FImage::from_raw(1, 1, vec![0.25, 7.5, -0.5]).unwrap();
        let bytes = written(&DynamicImage::ImageRgb32F(image), ImageFormat::OpenExr);
        let picture = decode_linear(&bytes, 64).unwrap();
        assert!(picture.is_linear && picture.pixels == [[0.25, 7.5, -0.5]]);
        assert_eq!(picture.clipped, [false]);
        assert_eq!(picture_size(&bytes).unwrap(), (1, 1));
        assert!(matches!(
            picture_size(b"GIF89a"),
            Err(LinearPictureError::Kind) | Err(LinearPictureError::Image(_))
        ));
        assert!(matches!(decode_linear(b"GIF89a", 64), Err(LinearPictureError::Kind)));
        assert!(decode_linear(&bytes[..bytes.len() / 2], 64).is_err());
    }

    #[test]
    fn every_code_round_trips_through_decoding_and_encoding() {
        for value in 0..=255u8 {
            #[expect(clippy::cast_possible_truncation, reason = "the film works in f32")]
            let linear = decode_srgb(f64::from(value) / 255.0) as f32;
            assert_eq!(crate::encode_srgb(linear), value);
        }
    }

    #[test]
    fn cut_files_are_refused() {
        let pixel = |x, y| image::Rgb([(3 * x + 5 * y) as u8, (7 * y) as u8, (x * y) as u8]);
        let picture = DynamicImage::ImageRgb8(image::RgbImage::from_fn(64, 64, pixel));
        for format in [ImageFormat::Jpeg, ImageFormat::Png] {
            let bytes = written(&picture, format);
            decode_display(&bytes, 64).unwrap();
            for kept in [bytes.len() / 2, bytes.len() - 20, 200, 30] {
                assert!(decode_display(&bytes[..kept], 64).is_err(), "{format:?} {kept}");
            }
            // Phones append a film.
            let more = [bytes, vec![0xff, 0xd9, 7, 0xff, 0xda, 0, 12, 7]].concat();
            decode_display(&more, 64).unwrap();
        }
        let error = decode_display(&written(&picture, ImageFormat::Jpeg)[..900], 64).unwrap_err();
        assert_eq!(error.to_string(), "the picture cannot be read: the JPEG file is cut off");
    }
}
