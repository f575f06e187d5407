//! A picture of an environment: radiance from every direction, and directions drawn in proportion to it.
//!
//! Owns the equirectangular map and its sums. Refuses to know files: whoever reads them brings linear pixels.

use std::f64::consts::PI;

use glam::DVec3;

use crate::angle::sin_cos_deg;
use crate::units::luminance;

/// Most pixels: a picture of 8192 x 4096.
const PIXELS_MAX: usize = 1 << 25;

/// Why pixels are no environment.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum EnvironmentError {
    /// No pixel, more than 2^25, or another number of them than the size says.
    #[error("an environment of {width} x {height} pixels cannot be made of {pixels}")]
    Size {
        /// Columns.
        width: usize,
        /// Rows.
        height: usize,
        /// Pixels that came.
        pixels: usize,
    },
    /// A radiance that is negative or not finite.
    #[error("pixel {0} is negative or not finite")]
    Pixel(usize),
}

/// Radiance from every direction: constant over each pixel of an equirectangular picture.
///
/// The upper edge is +y, the middle of the picture -z, and +x a quarter of the width to the right of it: what a person
/// sees who looks along -z.
#[derive(Debug, Clone, PartialEq)]
pub struct EnvironmentMap {
    width: usize,
    height: usize,
    pixels: Vec<[f32; 3]>,
    /// The cosine of the polar angle at the upper edge of each row, and at the lower edge of the last.
    edges: Vec<f64>,
    /// Sums of luminance times solid angle over the rows before each, and over all.
    rows: Vec<f64>,
    /// For each row: sums of luminance over the pixels before each, and over all.
    columns: Vec<f64>,
    mean: [f64; 3],
}

impl EnvironmentMap {
    /// An environment of linear pixels.
    ///
    /// # Shapes
    /// Row by row from the top, each from left to right; `width` times `height` of them.
    ///
    /// # Units
    /// Radiance, W/(m2 sr), up to the scale of the light.
    ///
    /// # Error
    /// Sizes that do not fit and radiances that are none.
    pub fn new(
        width: usize,
        height: usize,
        pixels: Vec<[f32; 3]>,
    ) -> Result<Self, EnvironmentError> {
        let count = pixels.len();
        let fits = width.checked_mul(height) == Some(count) && (1..=PIXELS_MAX).contains(&count);
        if !fits {
            return Err(EnvironmentError::Size { width, height, pixels: count });
        }
        let valid = |pixel: &[f32; 3]| pixel.iter().all(|c| c.is_finite() && *c >= 0.0);
        if let Some(index) = pixels.iter().position(|pixel| !valid(pixel)) {
            return Err(EnvironmentError::Pixel(index));
        }
        let edge = |row: usize| sin_cos_deg(180.0 * row as f64 / height as f64).1;
        let edges: Vec<f64> = (0..=height).map(edge).collect();
        let mut rows = vec![0.0];
        let mut columns = Vec::with_capacity((width + 1) * height);
        let mut mean = [0.0; 3];
        for (row, own) in pixels.chunks(width).enumerate() {
            let (mut sum, share) = (0.0, 0.5 * (edges[row] - edges[row + 1]) / width as f64);
            columns.push(sum);
            for pixel in own {
                let channels = pixel.map(f64::from);
                sum += luminance(channels);
                columns.push(sum);
                mean.iter_mut().zip(channels).for_each(|(mean, channel)| *mean += channel * share);
            }
            rows.push(rows[row] + sum * share * 4.0 * PI);
        }
        Ok(Self { width, height, pixels, edges, rows, columns, mean })
    }

    /// The radiance from a direction.
    ///
    /// # Domain
    /// A unit vector.
    #[must_use]
    pub fn radiance(&self, direction: DVec3) -> [f64; 3] {
        let turn = libm::atan2(direction.x, -direction.z) / (2.0 * PI) + 0.5;
        // Truncated to the pixel; the seam belongs to the last one.
        let column = ((turn * self.width as f64) as usize).min(self.width - 1);
        let below = self.edges.partition_point(|edge| *edge >= direction.y);
        let row = below.saturating_sub(1).min(self.height - 1);
        self.pixels[row * self.width + column].map(f64::from)
    }

    /// The mean radiance over all directions.
    #[must_use]
    pub fn mean(&self) -> [f64; 3] {
        self.mean
    }

    /// A direction drawn in proportion to luminance, and the radiance from it; `None` where all is dark.
    ///
    /// # Domain
    /// Both coordinates of the place within [0, 1).
    pub(crate) fn draw(&self, [across, down]: [f64; 2]) -> Option<(DVec3, [f64; 3])> {
        let whole = self.rows[self.height];
        if whole <= 0.0 {
            return None;
        }
        let (row, within_row) = find(&self.rows, down * whole);
        let columns = &self.columns[row * (self.width + 1)..][..=self.width];
        let (column, within_column) = find(columns, across * columns[self.width]);
        let cos = self.edges[row] + (self.edges[row + 1] - self.edges[row]) * within_row;
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        let turn = ((column as f64 + within_column) / self.width as f64 - 0.5) * 2.0 * PI;
        let direction = DVec3::new(sin * libm::sin(turn), cos, -sin * libm::cos(turn));
        let radiance = self.pixels[row * self.width + column].map(f64::from);
        (luminance(radiance) > 0.0).then_some((direction, radiance))
    }

    /// The density by which a direction of that radiance is drawn: the same all over its pixel.
    ///
    /// # Units
    /// 1/sr; 0 where all is dark.
    pub(crate) fn density(&self, radiance: [f64; 3]) -> f64 {
        let whole = self.rows[self.height];
        if whole > 0.0 { luminance(radiance) / whole } else { 0.0 }
    }

    /// Hash of size and pixels.
    #[must_use]
    pub fn content_hash(&self) -> blake3::Hash {
        let mut hasher = blake3::Hasher::new();
        hasher.update(&(self.width as u64).to_le_bytes());
        for pixel in &self.pixels {
            hasher.update(bytemuck::bytes_of(pixel));
        }
        hasher.finalize()
    }
}

/// The interval of ascending sums that holds a value, and how far into it the value is; never one of no length.
fn find(sums: &[f64], value: f64) -> (usize, f64) {
    let last = sums.len() - 2;
    let index = sums.partition_point(|sum| *sum <= value).saturating_sub(1);
    // Rounding may lead past the end, where intervals may have no length.
    let index = if index > last || sums[index + 1] <= sums[index] {
        (0..=last).rev().find(|k| sums[k + 1] > sums[*k] && sums[*k] <= value).unwrap_or(0)
    } else {
        index
    };
    let length = sums[index + 1] - sums[index];
    let along = if length > 0.0 { (value - sums[index]) / length } else { 0.0 };
    (index, along.clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 16 x 8 pixels, dark but for some.
    fn map(lit: &[(usize, [f32; 3])]) -> EnvironmentMap {
        let mut pixels = vec![[0.0; 3]; 128];
        lit.iter().for_each(|(index, radiance)| pixels[*index] = *radiance);
        EnvironmentMap::new(16, 8, pixels).unwrap()
    }

    #[test]
    fn picture_is_seen_as_a_person_who_looks_along_minus_z_does() {
        let index = |row: usize, column: usize| row * 16 + column;
        let map =
            map(&[(index(3, 8), [1.0; 3]), (index(3, 12), [2.0; 3]), (index(0, 0), [3.0; 3])]);
        let level = |x: f64, z: f64| DVec3::new(x, 0.1, z).normalize();
        assert_eq!(map.radiance(level(0.01, -1.0))[0], 1.0, "the middle");
        assert_eq!(map.radiance(level(1.0, 0.01))[0], 2.0, "to the right");
        assert_eq!(
            map.radiance(DVec3::new(-0.001, 1.0, 0.02).normalize())[0],
            3.0,
            "above, behind"
        );
    }

    #[test]
    fn what_is_drawn_has_the_mean_of_the_picture_and_dark_pixels_are_never_drawn() {
        let map = map(&[(5, [1.0, 2.0, 3.0]), (77, [40.0, 1.0, 0.5]), (127, [0.1; 3])]);
        let steps = 256;
        let mut sum = [0.0; 3];
        for k in 0..steps * steps {
            let at = |k: usize| (k as f64 + 0.5) / steps as f64;
            let (direction, radiance) = map.draw([at(k % steps), at(k / steps)]).unwrap();
            assert_eq!(radiance, map.radiance(direction), "{direction}");
            assert!(radiance[0] > 0.0, "{direction}");
            let density = map.density(radiance);
            sum.iter_mut().zip(radiance).for_each(|(sum, radiance)| *sum += radiance / density);
        }
        for (sum, mean) in sum.iter().zip(map.mean()) {
            let drawn = sum / (steps * steps) as f64 / (4.0 * PI);
            assert!((drawn - mean).abs() < 3e-2 * mean, "{drawn} {mean}");
        }
    }

    #[test]
    fn grey_environment_draws_every_direction_alike() {
        let map = EnvironmentMap::new(7, 5, vec![[2.0; 3]; 35]).unwrap();
        for place in [[0.0, 0.0], [0.3, 0.9], [0.999_999, 0.999_999]] {
            let (direction, radiance) = map.draw(place).unwrap();
            assert!((direction.length() - 1.0).abs() < 1e-12);
            assert!((map.density(radiance) * 4.0 * PI - 1.0).abs() < 1e-12, "{radiance:?}");
        }
        assert!((map.mean()[1] - 2.0).abs() < 1e-12);
    }

    #[test]
    fn pixels_that_are_no_environment_are_refused() {
        assert!(map(&[]).draw([0.5, 0.5]).is_none());
        assert_eq!(
            EnvironmentMap::new(2, 2, vec![[0.0; 3]; 3]),
            Err(EnvironmentError::Size { width: 2, height: 2, pixels: 3 })
        );
        assert!(EnvironmentMap::new(0, 0, Vec::new()).is_err());
        for wrong in [f32::NAN, f32::INFINITY, -1.0] {
            let pixels = vec![[0.0; 3], [0.0, wrong, 0.0]];
            assert_eq!(EnvironmentMap::new(2, 1, pixels), Err(EnvironmentError::Pixel(1)));
        }
    }
}
