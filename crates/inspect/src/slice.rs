//! Image slice of a program: f over theta_h, the angle between half vector and normal, and theta_d,
//! the angle between light and half vector.

use brood_brdf::DirectionPair;
use brood_eval::{direction_at, encode_srgb};
use brood_program::Program;
use glam::{DVec2, DVec3};

use crate::evaluate::evaluate;

/// Quantile of the largest channels that is exposed to [`WHITE`], as in the film's automatic
/// exposure.
const SHARE: f64 = 0.97;
/// Linear value that the quantile [`SHARE`] is exposed to.
const WHITE: f32 = 0.9;

/// Square picture of f over half angle and difference angle.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Slice {
    /// Side in pixels.
    pub size_px: u32,
    /// Red, green, blue, alpha in sRGB codes, row by row from the top; transparent where a
    /// direction would be below the surface.
    pub rgba: Vec<u8>,
}

/// Draws f over theta_h, 0 to 90 degrees from left to right, and theta_d, 0 to 90 degrees from
/// bottom to top, at phi_d = 90 degrees, phi_h = 0 and texture position (1/2, 1/2), with automatic
/// exposure.
///
/// The left edge shows the highlight, the top edge grazing angles with the Fresnel rise, the bottom
/// edge retro-reflection.
///
/// # Source
/// Burley, *Physically-Based Shading at Disney* (SIGGRAPH 2012 course), section 2; angles by
/// Rusinkiewicz (1998).
#[must_use]
pub fn image_slice(program: &Program, size_px: u32) -> Slice {
    let side = size_px as usize;
    let angle = |index: usize| (index as f64 + 0.5) / side as f64 * std::f64::consts::FRAC_PI_2;
    let mut pairs = Vec::new();
    let mut places = Vec::new();
    for row in 0..side {
        for column in 0..side {
            if let Some(pair) = pair_of(angle(column), angle(side - 1 - row)) {
                pairs.push(pair);
                places.push(row * side + column);
            }
        }
    }
    let f = evaluate(program, &pairs, DVec2::splat(0.5));
    let count = pairs.len();
    let pixel = |index: usize| [f[index], f[count + index], f[2 * count + index]];
    let mut largest: Vec<f32> =
        (0..count).map(|index| pixel(index).into_iter().fold(0.0, f32::max)).collect();
    largest.sort_by(f32::total_cmp);
    let rank = libm::ceil(SHARE * count as f64) as usize;
    let reference = largest.get(rank.max(1) - 1).copied().unwrap_or(0.0);
    let gain = if reference > 1e-8 { WHITE / reference } else { 1.0 };
    let mut rgba = vec![0; 4 * side * side];
    for (index, place) in places.into_iter().enumerate() {
        let [r, g, b] = pixel(index).map(|f| encode_srgb(f * gain));
        rgba[4 * place..4 * place + 4].copy_from_slice(&[r, g, b, 255]);
    }
    Slice { size_px, rgba }
}

/// Returns the pair with half angle `theta_h` and difference angle `theta_d` at phi_d = 90 degrees,
/// or `None` if a direction is below the surface.
fn pair_of(theta_h: f64, theta_d: f64) -> Option<DirectionPair> {
    let (sin_h, cos_h) = libm::sincos(theta_h);
    let h = direction_at(sin_h, cos_h, 0.0);
    let (sin_d, cos_d) = libm::sincos(theta_d);
    // Perpendicular to h and to the plane of h and the normal: phi_d = 90 degrees.
    let across = DVec3::Y * sin_d;
    let (wi, wo) = (h * cos_d + across, h * cos_d - across);
    let above = wi.z > 0.0 && wo.z > 0.0;
    above.then(|| DirectionPair::new(wi, wo).expect("built from sines and cosines"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pair_has_the_given_angles() {
        let pair = pair_of(0.4, 1.1).unwrap();
        let h = (pair.wi() + pair.wo()).normalize();
        assert!((h.z.acos() - 0.4).abs() < 1e-12);
        assert!((h.dot(pair.wi()).acos() - 1.1).abs() < 1e-12);
    }

    #[test]
    fn highlight_is_at_the_left_edge() {
        // Largest where the cosines are largest: at h = n and small difference angles.
        let text =
            "brood 1\n.dialect paper smooth registers 7\nMUL R0, R0.x, R0.x\nMUL R0, R0, R0\n";
        let slice = image_slice(&Program::lower(&text.parse().unwrap()), 32);
        let green = |column: usize, row: usize| slice.rgba[4 * (row * 32 + column) + 1];
        assert_eq!(slice.rgba.len(), 4 * 32 * 32);
        assert!(green(0, 31) == 255, "{}", green(0, 31));
        assert!(green(0, 31) > green(20, 31) && green(0, 31) > green(0, 10));
    }
}
