//! Pictures to compare, read from PNG or EXR.

use std::path::Path;

use anyhow::{Context, Result, bail};
use brood_bench::output::read_file;
use brood_eval::decode_srgb;
use brood_inspect::LinearImage;
use image::{DynamicImage, ImageFormat, ImageReader};

const LIMIT_BYTES: u64 = 256 << 20;

/// Picture with the range of its format.
#[derive(Debug)]
pub struct ComparedPicture {
    pub image: LinearImage,
    pub range: DynamicRange,
}

/// Dynamic range of a picture format.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DynamicRange {
    /// PNG: display colours of 0..1.
    Low,
    /// EXR: radiance.
    High,
}

impl ComparedPicture {
    /// Reads a PNG (8 or 16 bits, sRGB) or an EXR (linear, with premultiplied alpha).
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
        let range = match format {
            Some(ImageFormat::Png) => DynamicRange::Low,
            Some(ImageFormat::OpenExr) => DynamicRange::High,
            _ => bail!("{} must be a PNG or an EXR", path.display()),
        };
        let decoded = reader.decode().with_context(context)?;
        let image = match range {
            DynamicRange::Low => over_black(&decoded),
            DynamicRange::High => LinearImage::of_premultiplied(&decoded),
        };
        if let Some(index) = image.linear().iter().flatten().position(|value| !value.is_finite()) {
            let (pixel, width) = (index / 3, image.size().0 as usize);
            bail!(
                "{} must have finite values, got {} in {} of pixel ({}, {})",
                path.display(),
                image.linear()[pixel][index % 3],
                ["red", "green", "blue"][index % 3],
                pixel % width,
                pixel / width
            );
        }
        Ok(Self { image, range })
    }

    /// Number of pixels with a negative value, which HDR-FLIP replaces by 0.
    pub fn negative(&self) -> usize {
        self.count(|value| value < 0.0)
    }

    /// Number of pixels with a value outside of 0..1, which LDR-FLIP clips.
    pub fn clipped(&self) -> usize {
        self.count(|value| !(0.0..=1.0).contains(&value))
    }

    fn count(&self, is: impl Fn(f64) -> bool) -> usize {
        self.image.linear().iter().filter(|rgb| rgb.iter().any(|value| is(*value))).count()
    }
}

fn over_black(decoded: &DynamicImage) -> LinearImage {
    let unit = |value: u16| f64::from(value) / 65535.0;
    let over_black = |pixel: &image::Rgba<u16>| {
        let [r, g, b, alpha] = pixel.0;
        [r, g, b].map(|value| decode_srgb(unit(value)) * unit(alpha))
    };
    let linear = decoded.to_rgba16().pixels().map(over_black).collect();
    LinearImage::new(decoded.width(), decoded.height(), linear)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn png_decodes_to_linear_over_black() {
        let mut image = image::RgbaImage::new(2, 1);
        image.put_pixel(0, 0, image::Rgba([255, 188, 0, 255]));
        image.put_pixel(1, 0, image::Rgba([255, 255, 255, 51]));
        let picture = over_black(&DynamicImage::ImageRgba8(image));
        let [[r, g, b], [faint, ..]] = [picture.linear()[0], picture.linear()[1]];
        assert!(
            (r, b) == (1.0, 0.0) && (g - 0.502_886).abs() < 1e-5 && (faint - 0.2).abs() < 1e-12
        );
        assert_eq!(picture.encoded()[..3], [255, 188, 0]);
    }

    #[test]
    fn every_8_bit_value_survives_decoding_and_encoding() {
        for value in 0..=255u8 {
            let linear = decode_srgb(f64::from(value) / 255.0);
            assert_eq!(brood_eval::encode_srgb(linear as f32), value);
        }
    }
}
