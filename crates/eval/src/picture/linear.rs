//! Pictures of others as linear light: EXR and Radiance HDR as they are, PNG and JPEG through sRGB's curve.

use std::io::Cursor;

use image::{DynamicImage, ImageFormat, ImageReader, Limits};

/// A picture as linear red, green and blue.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearPicture {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Row by row from the top; times alpha where the picture has one.
    pub pixels: Vec<[f32; 3]>,
    /// Whether a channel is as bright as the picture can show it, so that it may have been brighter. Never so where the picture
    /// holds linear light.
    pub clipped: Vec<bool>,
    /// Whether the file holds linear light, and not codes of a curve.
    pub is_linear: bool,
}

/// Why bytes are no picture.
#[derive(Debug, thiserror::Error)]
pub enum LinearPictureError {
    /// Another format.
    #[error("a picture is an EXR, a Radiance HDR, a PNG or a JPEG file")]
    Kind,
    /// Broken, or too large.
    #[error("the picture cannot be read: {0}")]
    Image(#[from] image::ImageError),
}

/// Reads a picture.
///
/// # Units
/// EXR and HDR: the file's own, with the primaries of sRGB. PNG and JPEG: 1 is the brightest that they show.
///
/// # Domain
/// At most `side` pixels in each direction. Values of EXR files that are not finite are handed on.
pub fn decode_linear(bytes: &[u8], side: u32) -> Result<LinearPicture, LinearPictureError> {
    let format = image::guess_format(bytes).map_err(|_| LinearPictureError::Kind)?;
    let is_linear = match format {
        ImageFormat::OpenExr | ImageFormat::Hdr => true,
        ImageFormat::Png | ImageFormat::Jpeg => false,
        _ => return Err(LinearPictureError::Kind),
    };
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(side), Some(side));
    reader.limits(limits);
    let decoded = reader.decode()?;
    Ok(if is_linear { linear(&decoded) } else { encoded(&decoded) })
}

/// Width and height of a picture as its head tells them, so that a large one need not be decoded to be refused.
pub fn picture_size(bytes: &[u8]) -> Result<(u32, u32), LinearPictureError> {
    let format = image::guess_format(bytes).map_err(|_| LinearPictureError::Kind)?;
    Ok(ImageReader::with_format(Cursor::new(bytes), format).into_dimensions()?)
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
        [r, g, b].map(|value| (from_srgb(unit(value)) * unit(alpha)) as f32)
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

/// sRGB's transfer curve, from encoded to linear.
///
/// # Source
/// IEC 61966-2-1.
fn from_srgb(value: f64) -> f64 {
    if value <= 0.04045 { value / 12.92 } else { libm::pow((value + 0.055) / 1.055, 2.4) }
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
    fn codes_become_light_and_what_is_brightest_may_be_clipped() {
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
    fn linear_light_is_taken_as_it_is() {
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
    fn every_code_survives_decoding_and_encoding() {
        for value in 0..=255u8 {
            #[expect(clippy::cast_possible_truncation, reason = "as the film has it")]
            let linear = from_srgb(f64::from(value) / 255.0) as f32;
            assert_eq!(crate::encode_srgb(linear), value);
        }
    }
}
