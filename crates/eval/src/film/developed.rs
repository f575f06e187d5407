//! Developed pictures.

use brood_scene::PixelArea;

use super::exposure::Gain;
use super::{srgb, tone};

/// A developed picture: sRGB with straight alpha, row by row from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Developed {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// RGBA, four bytes per pixel.
    pub rgba: Vec<u8>,
    /// Exposure used: radiance was multiplied by 2^`exposure_ev`.
    pub exposure_ev: f64,
}

impl Developed {
    /// Replaces the colour of a pixel by another radiance: that of the covered part, not multiplied
    /// by coverage.
    ///
    /// # Panics
    /// If there is no such pixel.
    pub fn put(&mut self, pixel: usize, radiance: [f32; 3], gain: Gain) {
        let codes = radiance
            .map(|channel| srgb::curve().encode(tone::apply(gain.tone, channel * gain.factor)));
        self.rgba[4 * pixel..4 * pixel + 3].copy_from_slice(&codes);
    }

    /// Returns a part of the picture; `area` counts from the upper left corner of this picture.
    ///
    /// # Panics
    /// If the area is not within the picture.
    #[must_use]
    pub fn crop(&self, area: PixelArea) -> Self {
        let row = |y: u32| {
            let start = 4 * ((area.y + y) as usize * self.width as usize + area.x as usize);
            &self.rgba[start..start + 4 * area.width as usize]
        };
        let rgba = (0..area.height).flat_map(row).copied().collect();
        Self { width: area.width, height: area.height, rgba, exposure_ev: self.exposure_ev }
    }
}
