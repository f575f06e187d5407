//! Oklab: lightness and opponent colours that are even to the eye, from and to codes of a display.
//!
//! # Source
//! Ottosson, *A perceptual color space for image processing* (2020).

use libm::{cbrt, cos, pow, sin};

/// Steps of the search for the largest chroma within the gamut: to 2^-12 of the chroma.
const GAMUT_STEPS: u32 = 12;
/// Tolerance of the gamut in linear values, below half a dark code.
const GAMUT_MARGIN: f64 = 1e-4;

/// A colour in Oklab.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Oklab {
    /// Lightness, 0 for black and 1 for white.
    pub lightness: f64,
    /// Green to red.
    pub a: f64,
    /// Blue to yellow.
    pub b: f64,
}

impl Oklab {
    /// Creates a colour of a hue in radians.
    #[must_use]
    pub fn of_hue(lightness: f64, chroma: f64, hue: f64) -> Self {
        Self { lightness, a: chroma * cos(hue), b: chroma * sin(hue) }
    }

    /// Converts display values from 0 to 1.
    #[must_use]
    pub fn of_display(values: [f64; 3]) -> Self {
        Self::of_linear(values.map(linear))
    }

    /// Converts linear display values from 0 to 1.
    #[must_use]
    pub fn of_linear([red, green, blue]: [f64; 3]) -> Self {
        let l = cbrt(0.412_221_470_8 * red + 0.536_332_536_3 * green + 0.051_445_992_9 * blue);
        let m = cbrt(0.211_903_498_2 * red + 0.680_699_545_1 * green + 0.107_396_956_6 * blue);
        let s = cbrt(0.088_302_461_9 * red + 0.281_718_837_6 * green + 0.629_978_700_5 * blue);
        Self {
            lightness: 0.210_454_255_3 * l + 0.793_617_785_0 * m - 0.004_072_046_8 * s,
            a: 1.977_998_495_1 * l - 2.428_592_205_0 * m + 0.450_593_709_9 * s,
            b: 0.025_904_037_1 * l + 0.782_771_766_2 * m - 0.808_675_766_0 * s,
        }
    }

    /// Converts 8-bit codes.
    #[must_use]
    pub fn of_codes(codes: [u8; 3]) -> Self {
        Self::of_display(codes.map(|code| f64::from(code) / 255.0))
    }

    /// Distance from grey.
    #[must_use]
    pub fn chroma(self) -> f64 {
        libm::hypot(self.a, self.b)
    }

    /// Returns the colour with its hue turned by an angle in radians and its chroma scaled.
    #[must_use]
    pub fn turned(self, angle: f64, scale: f64) -> Self {
        let (sin, cos) = (scale * sin(angle), scale * cos(angle));
        let Self { lightness, a, b } = self;
        Self { lightness, a: a * cos - b * sin, b: a * sin + b * cos }
    }

    /// Nearest 8-bit codes, with as much of the chroma as the display has at this lightness.
    #[must_use]
    pub fn codes(self) -> [u8; 3] {
        let lightness = self.lightness.clamp(0.0, 1.0);
        let at = |scale: f64| {
            let own = Self { lightness, a: self.a * scale, b: self.b * scale };
            own.linear_display()
        };
        let fits = |scale: f64| {
            at(scale).iter().all(|value| (-GAMUT_MARGIN..=1.0 + GAMUT_MARGIN).contains(value))
        };
        let (mut inside, mut outside) = (0.0, 1.0);
        if fits(1.0) {
            inside = 1.0;
        } else {
            for _ in 0..GAMUT_STEPS {
                let middle = 0.5 * (inside + outside);
                if fits(middle) { inside = middle } else { outside = middle }
            }
        }
        // The cast rounds values that are within 0 to 255.5.
        at(inside).map(|value| (255.0 * encoded(value.clamp(0.0, 1.0)) + 0.5) as u8)
    }

    /// Linear display values, which are outside 0 to 1 for colours out of gamut.
    fn linear_display(self) -> [f64; 3] {
        let Self { lightness, a, b } = self;
        let l = cube(lightness + 0.396_337_777_4 * a + 0.215_803_757_3 * b);
        let m = cube(lightness - 0.105_561_345_8 * a - 0.063_854_172_8 * b);
        let s = cube(lightness - 0.089_484_177_5 * a - 1.291_485_548_0 * b);
        [
            4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s,
            -1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s,
            -0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701_0 * s,
        ]
    }
}

fn cube(value: f64) -> f64 {
    value * value * value
}

/// Linear value of a display value.
pub(crate) fn linear(value: f64) -> f64 {
    if value <= 0.040_45 { value / 12.92 } else { pow((value + 0.055) / 1.055, 2.4) }
}

/// Display value of a linear value.
fn encoded(value: f64) -> f64 {
    if value <= 0.003_130_8 { 12.92 * value } else { 1.055 * pow(value, 1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn oklab_has_the_published_values_of_the_primaries() {
        let red = Oklab::of_codes([255, 0, 0]);
        assert!((red.lightness - 0.627_955).abs() < 1e-5, "{red:?}");
        assert!((red.a - 0.224_863).abs() < 1e-5 && (red.b - 0.125_846).abs() < 1e-5, "{red:?}");
        let white = Oklab::of_codes([255; 3]);
        assert!((white.lightness - 1.0).abs() < 1e-6 && white.chroma() < 1e-6, "{white:?}");
    }

    #[test]
    fn codes_survive_the_conversion() {
        for code in 0..4096_u32 {
            let codes = [0, 4, 8].map(|shift| ((code >> shift & 15) * 17) as u8);
            assert_eq!(Oklab::of_codes(codes).codes(), codes);
        }
    }

    #[test]
    fn colours_out_of_gamut_keep_their_lightness_and_lose_chroma() {
        for step in 0..24 {
            let wanted = Oklab::of_hue(0.6, 0.5, f64::from(step) * 0.26);
            let shown = Oklab::of_codes(wanted.codes());
            assert!((shown.lightness - 0.6).abs() < 0.02, "{shown:?}");
            assert!(shown.chroma() < 0.35 && shown.chroma() > 0.08, "{shown:?}");
        }
    }
}
