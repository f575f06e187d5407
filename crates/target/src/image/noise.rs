//! Noise of pictures of display codes, and what it leaves of the bounds of clipped pixels.

use brood_eval::{LinearPicture, decode_srgb, encode_srgb};

/// Median of |x| over the standard deviation, of a normal distribution.
const MEDIAN: f64 = 0.674_489_750_196_081_7;
/// Standard deviations by which a bound is lowered: noise lifts about as many pixels over the
/// clipping level as it keeps below.
const LOWERED: f64 = 3.0;

/// Standard deviation of the noise of 8-bit codes, rounding included. 0 for pictures of linear
/// light.
///
/// Each channel has the median over the used pixels of the second difference of the second
/// difference, which leaves out smooth shading and straight edges. The largest channel counts.
///
/// # Source
/// Immerkaer, *Fast Noise Variance Estimation* (1996), with the median instead of the mean.
pub(super) fn deviation(picture: &LinearPicture, is_used: impl Fn(usize) -> bool) -> f64 {
    if picture.is_linear {
        return 0.0;
    }
    let (width, height) = (picture.width as usize, picture.height as usize);
    let code = |at: usize, channel: usize| f64::from(encode_srgb(picture.pixels[at][channel]));
    let inner = (1..height - 1).flat_map(|row| (1..width - 1).map(move |x| row * width + x));
    let inner: Vec<usize> = inner.filter(|at| is_used(*at)).collect();
    let of_channel = |channel: usize| {
        let row =
            |at: usize| code(at - 1, channel) - 2.0 * code(at, channel) + code(at + 1, channel);
        let difference = |at: &usize| (row(at - width) - 2.0 * row(*at) + row(at + width)).abs();
        let mut all: Vec<f64> = inner.iter().map(difference).collect();
        all.sort_by(f64::total_cmp);
        // The weights of the nine pixels have squares of sum 36.
        all.get(all.len() / 2).map_or(0.0, |median| median / (6.0 * MEDIAN))
    };
    [0, 1, 2].map(of_channel).into_iter().fold(0.0, f64::max)
}

/// True for a channel of a clipped pixel that is itself below the code from which it is clipped, by
/// more than noise.
pub(super) fn is_known(value: f32, from: Option<u8>, deviation: f64) -> bool {
    f64::from(encode_srgb(value)) + LOWERED * deviation < f64::from(from.unwrap_or(u8::MAX))
}

/// Value of a channel of a clipped pixel, lowered by what noise may have added. The value is
/// linear, as decoded.
pub(super) fn lowered(value: f32, deviation: f64) -> f32 {
    if deviation == 0.0 {
        return value;
    }
    let code = f64::from(encode_srgb(value)) - LOWERED * deviation;
    #[expect(clippy::cast_possible_truncation, reason = "pixels of pictures are f32")]
    let value = decode_srgb(code.max(0.0) / 255.0) as f32;
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Smooth picture with noise of a triangular distribution.
    fn picture(amplitude: i32) -> LinearPicture {
        let mut state = 1u32;
        let mut draw = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 16) as i32 % (amplitude + 1)
        };
        let pixel = |at: i32| {
            let code = 60 + at % 64 + at / 128 + draw() - draw();
            [decode_srgb(f64::from(code) / 255.0) as f32; 3]
        };
        LinearPicture {
            width: 64,
            height: 64,
            pixels: (0..4096).map(pixel).collect(),
            clipped: vec![false; 4096],
            is_linear: false,
        }
    }

    #[test]
    fn noise_is_measured_on_top_of_shading() {
        assert!(deviation(&picture(0), |_| true) < 0.5);
        // Differences of two uniform draws from 0 to n: variance n (n + 2) / 6.
        for amplitude in [4, 9] {
            let wanted = (f64::from(amplitude * (amplitude + 2)) / 6.0).sqrt();
            let found = deviation(&picture(amplitude), |_| true);
            assert!((found / wanted - 1.0).abs() < 0.15, "{found} instead of {wanted}");
        }
        assert_eq!(deviation(&picture(9), |_| false), 0.0);
        let linear = LinearPicture { is_linear: true, ..picture(9) };
        assert_eq!(deviation(&linear, |_| true), 0.0);
    }

    #[test]
    fn bound_is_lowered_by_noise() {
        assert_eq!(lowered(1.0, 0.0), 1.0);
        assert_eq!(lowered(1.0, 2.0), decode_srgb(249.0 / 255.0) as f32);
        assert_eq!(lowered(0.001, 100.0), 0.0);
        let value = decode_srgb(240.0 / 255.0) as f32;
        assert!(is_known(value, Some(255), 2.0) && is_known(value, None, 2.0));
        assert!(!is_known(value, Some(244), 2.0) && !is_known(1.0, None, 0.0));
    }
}
