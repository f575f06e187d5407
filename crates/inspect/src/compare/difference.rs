//! Differences between pictures: exposed linear RGB over black, and metrics of two pictures.

use brood_eval::RadianceImage;
use image::{DynamicImage, ImageFormat};

use super::exposures::Exposures;
use super::similarity::ssim;
use super::{flip as metric, itp};

/// Linear RGB of a picture, composed over black.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearImage {
    width: u32,
    height: u32,
    linear: Vec<[f64; 3]>,
}

/// Error if bytes are not a linear picture.
#[derive(Debug, thiserror::Error)]
#[error("the file must be an EXR picture: {0}")]
pub struct LinearImageError(#[from] image::ImageError);

impl LinearImage {
    /// Creates a picture from linear pixels, row by row.
    ///
    /// # Panics
    /// If the number of pixels is not `width * height`.
    #[must_use]
    pub fn new(width: u32, height: u32, linear: Vec<[f64; 3]>) -> Self {
        assert_eq!(linear.len(), width as usize * height as usize, "one colour for each pixel");
        Self { width, height, linear }
    }

    /// Reads radiance with premultiplied alpha from an EXR and exposes it.
    ///
    /// # Errors
    /// Returns [`LinearImageError`] if the bytes are not an EXR picture.
    pub fn from_exr(bytes: &[u8], exposure_ev: f64) -> Result<Self, LinearImageError> {
        let decoded = image::load_from_memory_with_format(bytes, ImageFormat::OpenExr)?;
        Ok(Self::of_premultiplied(&decoded).exposed(exposure_ev))
    }

    /// Converts a decoded picture of linear colour with premultiplied alpha.
    #[must_use]
    pub fn of_premultiplied(decoded: &DynamicImage) -> Self {
        let linear = decoded.to_rgb32f().pixels().map(|pixel| pixel.0.map(f64::from)).collect();
        Self::new(decoded.width(), decoded.height(), linear)
    }

    /// Converts linear radiance.
    #[must_use]
    pub fn of_radiance(radiance: &RadianceImage) -> Self {
        let linear = radiance.premultiplied().iter().map(|rgb| rgb.map(f64::from)).collect();
        Self::new(radiance.width(), radiance.height(), linear)
    }

    /// Multiplies by 2^`ev`.
    #[must_use]
    pub fn exposed(mut self, ev: f64) -> Self {
        let gain = libm::exp2(ev);
        self.linear.iter_mut().flatten().for_each(|channel| *channel *= gain);
        self
    }

    /// Width and height in pixels.
    #[must_use]
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// Returns the pixels, row by row.
    #[must_use]
    pub fn linear(&self) -> &[[f64; 3]] {
        &self.linear
    }

    /// Returns 8-bit sRGB, clipped to 0..1, with red, green and blue interleaved.
    #[must_use]
    pub fn encoded(&self) -> Vec<u8> {
        self.linear.iter().flatten().map(|value| brood_eval::encode_srgb(*value as f32)).collect()
    }

    /// Returns 8-bit sRGB with alpha 255, clipped to 0..1.
    #[must_use]
    pub fn encoded_rgba(&self) -> Vec<u8> {
        self.encoded().chunks_exact(3).flat_map(|rgb| [rgb[0], rgb[1], rgb[2], 255]).collect()
    }

    /// Returns the root mean square error of linear RGB against a picture of the same size.
    #[must_use]
    pub fn rmse(&self, other: &Self) -> f64 {
        let pairs = self.linear.iter().zip(&other.linear);
        let squares: f64 =
            pairs.flat_map(|(a, b)| (0..3).map(|c| (a[c] - b[c]) * (a[c] - b[c]))).sum();
        (squares / (3.0 * self.linear.len().max(1) as f64)).sqrt()
    }

    /// Returns the absolute difference from a picture of the same size.
    #[must_use]
    pub fn absolute_difference(&self, other: &Self) -> Self {
        let difference = |(a, b): (&[f64; 3], &[f64; 3])| [0, 1, 2].map(|c| (a[c] - b[c]).abs());
        let linear = self.linear.iter().zip(&other.linear).map(difference).collect();
        Self::new(self.width, self.height, linear)
    }

    /// Returns the mean structural similarity in 8-bit sRGB against a picture of the same size: 1
    /// if equal, `None` if smaller than 11 x 11.
    ///
    /// # Source
    /// Wang et al., Image Quality Assessment: From Error Visibility to Structural Similarity, 2004.
    #[must_use]
    pub fn ssim(&self, other: &Self) -> Option<f64> {
        let (width, height) = (self.width as usize, self.height as usize);
        ssim(&self.encoded(), &other.encoded(), width, height)
    }

    /// Returns the mean LDR-FLIP error against a picture of the same size, both in 8-bit sRGB,
    /// clipped to 0..1.
    ///
    /// # Source
    /// Andersson et al., FLIP: A Difference Evaluator for Alternating Images, 2020.
    #[must_use]
    pub fn flip(&self, other: &Self) -> f64 {
        flip(self.size(), &self.encoded(), &other.encoded())
    }

    /// Returns the mean HDR-FLIP error of a picture of the same size against this reference, `None`
    /// if the reference is black.
    ///
    /// # Domain
    /// Finite values in the range of f32. Negative values count as 0.
    ///
    /// # Error
    /// 1e-6 against flip-evaluator 1.7 (`hdr_flip_agrees_with_the_reference_implementation`).
    ///
    /// # Source
    /// Andersson et al., Visualizing Errors in Rendered High Dynamic Range Images, 2021.
    #[must_use]
    pub fn hdr_flip(&self, test: &Self) -> Option<HdrFlip> {
        let [reference, test] = [self, test].map(|picture| -> Vec<[f64; 3]> {
            picture.linear.iter().map(|rgb| rgb.map(|value| value.max(0.0))).collect()
        });
        let exposures = Exposures::of(&reference)?;
        let mean = metric::mean_over(&exposures, self.width as usize, &reference, &test);
        Some(HdrFlip { mean, exposures })
    }

    /// Returns the mean Delta E_ITP against a picture of the same size; 1 is about a just
    /// noticeable difference in the most critical adaptation.
    ///
    /// # Units
    /// Linear RGB has the primaries of BT.709, and 1 is `white` cd/m2. Negative values count as 0.
    ///
    /// # Source
    /// ITU-R BT.2124-0 (2019), with BT.2087 and BT.2100 for the conversion from BT.709 to ICtCp.
    #[must_use]
    pub fn itp(&self, other: &Self, white: f64) -> f64 {
        let pairs = self.linear.iter().zip(&other.linear);
        let sum: f64 = pairs.map(|(a, b)| itp::difference(*a, *b, white)).sum();
        sum / self.linear.len().max(1) as f64
    }
}

/// HDR-FLIP error with the exposures that it was taken over.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HdrFlip {
    /// Mean of the pixels, 0 to 1.
    pub mean: f64,
    /// Exposures of the pictures.
    pub exposures: Exposures,
}

/// Returns the mean LDR-FLIP error between two pictures of 8-bit sRGB with red, green and blue
/// interleaved.
///
/// # Panics
/// If a picture does not have `width * height` pixels.
#[must_use]
pub fn flip((width, height): (u32, u32), a: &[u8], b: &[u8]) -> f64 {
    let linear: [f64; 256] =
        std::array::from_fn(|code| brood_eval::decode_srgb(code as f64 / 255.0));
    let [a, b] = [a, b].map(|codes| -> Vec<[f64; 3]> {
        assert_eq!(codes.len(), 3 * width as usize * height as usize, "three bytes for each pixel");
        let pixels = codes.chunks_exact(3);
        pixels.map(|rgb| [0, 1, 2].map(|channel| linear[usize::from(rgb[channel])])).collect()
    });
    metric::mean(width as usize, &a, &b)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gradient(shift: f64) -> LinearImage {
        let pixel = |i: u32| [f64::from(i % 32) / 32.0 + shift, f64::from(i / 32) / 32.0, 0.25];
        LinearImage::new(32, 32, (0..1024).map(pixel).collect())
    }

    #[test]
    fn difference_is_zero_when_pictures_are_equal() {
        let (a, b) = (gradient(0.0), gradient(0.0));
        assert_eq!((a.rmse(&b), a.flip(&b), a.itp(&b, 100.0)), (0.0, 0.0, 0.0));
        assert_eq!(a.ssim(&b), Some(1.0));
        assert!(a.absolute_difference(&b).linear().iter().flatten().all(|value| *value == 0.0));
    }

    #[test]
    fn difference_grows_when_the_shift_grows() {
        let (a, b, c) = (gradient(0.0), gradient(0.05), gradient(0.2));
        assert!((a.rmse(&b) - 0.05 / 3f64.sqrt()).abs() < 1e-12);
        assert!(a.flip(&b) > 0.0 && a.flip(&c) > a.flip(&b));
        assert!(a.itp(&b, 100.0) > 0.0 && a.itp(&c, 100.0) > a.itp(&b, 100.0));
        assert!(a.ssim(&c).unwrap() < a.ssim(&b).unwrap());
        let apart = b.absolute_difference(&a);
        assert!((apart.linear()[0][0] - 0.05).abs() < 1e-12 && apart.linear()[0][1] == 0.0);
    }

    #[test]
    fn exr_is_multiplied_by_the_exposure() {
        let stored = image::Rgba32FImage::from_raw(1, 1, vec![0.25, 0.5, 3.0, 0.5]).unwrap();
        let mut bytes = std::io::Cursor::new(Vec::new());
        DynamicImage::ImageRgba32F(stored).write_to(&mut bytes, ImageFormat::OpenExr).unwrap();
        let read = LinearImage::from_exr(bytes.get_ref(), -1.0).unwrap();
        assert_eq!(read.linear(), [[0.125, 0.25, 1.5]]);
        assert_eq!(read.encoded_rgba()[2..], [255, 255]);
        assert!(LinearImage::from_exr(b"EXR?", 0.0).is_err());
    }
}
