//! Pictures to be compared: read from PNG or EXR, held as linear RGB over black.

use std::path::Path;

use anyhow::{Context, Result, bail};
use image::{DynamicImage, ImageFormat, ImageReader, RgbImage};

use crate::output::read_file;

const LIMIT_BYTES: u64 = 256 << 20;

/// Linear RGB, composed over black where the file has alpha.
pub struct Picture {
    width: u32,
    height: u32,
    linear: Vec<[f64; 3]>,
}

impl Picture {
    /// Reads a PNG (8 or 16 bits, sRGB) or an EXR (linear, colour multiplied by alpha as the format has it).
    pub fn read(path: &Path) -> Result<Self> {
        let bytes = read_file(path, LIMIT_BYTES)?;
        let context = || format!("read the picture {}", path.display());
        let mut reader = ImageReader::new(std::io::Cursor::new(&bytes))
            .with_guessed_format()
            .with_context(context)?;
        let format = reader.format();
        let mut limits = image::Limits::default();
        (limits.max_image_width, limits.max_image_height) = (Some(16384), Some(16384));
        reader.limits(limits);
        let premultiplied = match format {
            Some(ImageFormat::Png) => false,
            Some(ImageFormat::OpenExr) => true,
            _ => bail!("{} is neither PNG nor EXR", path.display()),
        };
        let decoded = reader.decode().with_context(context)?;
        Ok(Self::from_decoded(&decoded, premultiplied))
    }

    /// Width, height, and linear pixels row by row.
    pub fn into_linear(self) -> (u32, u32, Vec<[f64; 3]>) {
        (self.width, self.height, self.linear)
    }

    /// A picture of linear pixels, row by row.
    pub fn from_linear(width: u32, height: u32, linear: Vec<[f64; 3]>) -> Self {
        Self { width, height, linear }
    }

    fn from_decoded(decoded: &DynamicImage, is_linear: bool) -> Self {
        let (width, height) = (decoded.width(), decoded.height());
        let linear = if is_linear {
            let pixels = decoded.to_rgb32f();
            pixels.pixels().map(|pixel| pixel.0.map(f64::from)).collect()
        } else {
            let pixels = decoded.to_rgba16();
            let unit = |value: u16| f64::from(value) / 65535.0;
            let over_black = |pixel: &image::Rgba<u16>| {
                let [r, g, b, alpha] = pixel.0;
                [r, g, b].map(|value| decode(unit(value)) * unit(alpha))
            };
            pixels.pixels().map(over_black).collect()
        };
        Self { width, height, linear }
    }

    /// Width and height in pixels.
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// The pixels, row by row.
    pub fn linear(&self) -> &[[f64; 3]] {
        &self.linear
    }

    /// 8-bit sRGB, clipped to 0..1.
    pub fn encoded(&self) -> RgbImage {
        let bytes =
            self.linear.iter().flatten().map(|value| brood_eval::encode_srgb(*value as f32));
        RgbImage::from_raw(self.width, self.height, bytes.collect()).expect("three bytes a pixel")
    }
}

/// The sRGB transfer curve, from encoded to linear.
fn decode(value: f64) -> f64 {
    if value <= 0.04045 { value / 12.92 } else { libm::pow((value + 0.055) / 1.055, 2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn png_decodes_to_linear_over_black() {
        let mut image = image::RgbaImage::new(2, 1);
        image.put_pixel(0, 0, image::Rgba([255, 188, 0, 255]));
        image.put_pixel(1, 0, image::Rgba([255, 255, 255, 51]));
        let picture = Picture::from_decoded(&DynamicImage::ImageRgba8(image), false);
        let [[r, g, b], [faint, ..]] = [picture.linear()[0], picture.linear()[1]];
        assert!(
            (r, b) == (1.0, 0.0) && (g - 0.502_886).abs() < 1e-5 && (faint - 0.2).abs() < 1e-12
        );
        assert_eq!(picture.encoded().as_raw()[..3], [255, 188, 0]);
    }

    #[test]
    fn every_8_bit_value_survives_decoding_and_encoding() {
        for value in 0..=255u8 {
            let linear = decode(f64::from(value) / 255.0);
            assert_eq!(brood_eval::encode_srgb(linear as f32), value);
        }
    }
}
