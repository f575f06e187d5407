//! Developed pictures.

use brood_scene::{Film, PictureSize, PixelArea};

use super::exposure::Gain;
use super::srgb;

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
        self.rgba[4 * pixel..4 * pixel + 3].copy_from_slice(&gain.codes(radiance));
    }

    /// Returns an opaque picture of a radiance in each pixel.
    ///
    /// # Panics
    /// If the number of pixels is not that of the size.
    #[must_use]
    pub fn opaque(
        PictureSize { width, height }: PictureSize,
        radiance: &[[f32; 3]],
        (film, exposure_ev): (Film, f64),
    ) -> Self {
        assert_eq!(radiance.len(), width as usize * height as usize, "one radiance for each pixel");
        let gain = Gain::fixed(exposure_ev).with_tone(film.tone);
        let mut picture =
            Self { width, height, rgba: vec![u8::MAX; 4 * radiance.len()], exposure_ev };
        for (pixel, radiance) in radiance.iter().enumerate() {
            picture.put(pixel, *radiance, gain);
        }
        picture
    }

    /// Returns an opaque picture of one colour: sRGB within [0, 1].
    #[must_use]
    pub fn plain(PictureSize { width, height }: PictureSize, color: [f64; 3]) -> Self {
        let [r, g, b] = color.map(|channel| (channel * 255.0 + 0.5) as u8);
        let pixels = width as usize * height as usize;
        Self { width, height, rgba: [r, g, b, u8::MAX].repeat(pixels), exposure_ev: 0.0 }
    }

    /// Returns a picture of display values times opacity, and opacity.
    ///
    /// # Panics
    /// If there is not one for each pixel.
    #[must_use]
    pub fn of_display(PictureSize { width, height }: PictureSize, colors: &[[f32; 4]]) -> Self {
        assert_eq!(colors.len(), width as usize * height as usize, "one colour for each pixel");
        let codes = colors.iter().flat_map(|[r, g, b, opacity]| {
            let straight = if *opacity > 0.0 { 255.0 / opacity } else { 0.0 };
            [r * straight, g * straight, b * straight, opacity * 255.0].map(|c| (c + 0.5) as u8)
        });
        Self { width, height, rgba: codes.collect(), exposure_ev: 0.0 }
    }

    /// Puts the picture over another one: straight alpha, mixed in linear light.
    ///
    /// # Panics
    /// If the other picture has another size.
    pub fn put_over(&mut self, backdrop: &Self) {
        assert_eq!(self.rgba.len(), backdrop.rgba.len(), "the backdrop is as large as the picture");
        let curve = srgb::curve();
        let behind = backdrop.rgba.as_chunks::<4>().0;
        for (pixel, behind) in self.rgba.as_chunks_mut::<4>().0.iter_mut().zip(behind) {
            let alpha = f32::from(pixel[3]) / 255.0;
            match pixel[3] {
                255 => {}
                0 => *pixel = *behind,
                _ if behind[3] == 0 => {}
                _ => {
                    let all = alpha + (1.0 - alpha) * f32::from(behind[3]) / 255.0;
                    let share = alpha / all;
                    for c in 0..3 {
                        let [own, behind] = [pixel[c], behind[c]]
                            .map(|code| srgb::decode_srgb(f64::from(code) / 255.0) as f32);
                        pixel[c] = curve.encode(behind + (own - behind) * share);
                    }
                    pixel[3] = (all * 255.0 + 0.5) as u8;
                }
            }
        }
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
