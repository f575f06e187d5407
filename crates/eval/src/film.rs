//! Film: exposure and the sRGB transfer curve, to 8 bits.

mod srgb;

use brood_scene::Exposure;
pub use srgb::encode_srgb;

use crate::RadianceImage;

/// A developed picture: sRGB with straight alpha, row by row from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Developed {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Four bytes a pixel.
    pub rgba: Vec<u8>,
    /// The exposure used: radiance was multiplied by 2^this.
    pub exposure_ev: f64,
}

/// What automatic exposure maps its percentile to.
const AUTO_TARGET: f32 = 0.9;
/// Below this there is nothing to expose for.
const AUTO_FLOOR: f32 = 1e-8;

/// Develops a picture.
///
/// # Source
/// Automatic exposure: the 97th percentile of the first samples' largest channel becomes linear 0.9 (docs/maths/film.md).
#[must_use]
pub fn develop(image: &RadianceImage, exposure: Exposure) -> Developed {
    let (factor, exposure_ev) = match exposure {
        Exposure::Auto => automatic(image.first_samples()),
        Exposure::Ev(ev) => (nearest(libm::exp2(ev)), ev),
    };
    let curve = srgb::curve();
    let mut rgba = vec![0; 4 * image.coverage().len()];
    let pixels = image.premultiplied().iter().zip(image.coverage());
    for (place, (radiance, coverage)) in rgba.chunks_exact_mut(4).zip(pixels) {
        if *coverage > 0.0 {
            place.copy_from_slice(&pixel(curve, *radiance, *coverage, factor));
        }
    }
    Developed { width: image.width(), height: image.height(), rgba, exposure_ev }
}

#[inline]
fn pixel(curve: &srgb::Curve, radiance: [f32; 3], coverage: f32, factor: f32) -> [u8; 4] {
    let mut code = [0, 0, 0, (coverage * 255.0 + 0.5) as u8];
    for (code, channel) in code.iter_mut().zip(radiance) {
        let exposed = channel * factor;
        // Most pixels are covered whole, and a division by 1 changes nothing.
        *code = curve.encode(if coverage < 1.0 { exposed / coverage } else { exposed });
    }
    code
}

fn automatic(first_samples: &[f32]) -> (f32, f64) {
    let count = first_samples.len();
    if count == 0 {
        return (1.0, 0.0);
    }
    let rank = (97 * count).div_ceil(100) - 1;
    let mut values = first_samples.to_vec();
    let (_, value, _) = values.select_nth_unstable_by(rank, f32::total_cmp);
    if *value < AUTO_FLOOR {
        return (1.0, 0.0);
    }
    let factor = AUTO_TARGET / *value;
    (factor, libm::log2(f64::from(factor)))
}

#[expect(clippy::cast_possible_truncation, reason = "rounded to the nearest f32")]
fn nearest(value: f64) -> f32 {
    value as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn automatic_exposure_takes_the_97th_percentile_by_its_definition() {
        let values: Vec<f32> = (1..=200u8).map(f32::from).collect();
        // ceil(0.97 * 200) - 1 = 193, the value 194.
        assert_eq!(automatic(&values).0, 0.9 / 194.0);
        assert_eq!(automatic(&[2.0]).0, 0.45);
        assert_eq!(automatic(&[2.0]).1, libm::log2(f64::from(0.45f32)));
        assert_eq!(automatic(&[]), (1.0, 0.0));
        assert_eq!(automatic(&[1e-9; 50]), (1.0, 0.0));
    }
}
