//! Environment map: radiance from every direction, with importance sampling by luminance.
//!
//! Owns the equirectangular pixels and their cumulative sums. Does no I/O: the caller decodes files
//! to linear pixels.

mod builtin;
mod filtered;
mod grid;
mod prefiltered;
mod pyramid;
mod sphere_map;

use std::f64::consts::PI;
use std::sync::OnceLock;

use brood_mesh::angle::sin_cos_deg;
use glam::DVec3;

use crate::units::luminance;
pub use builtin::BuiltinEnvironment;
use filtered::Filtered;
pub use filtered::{SPOTS_MAX, Spots};
use grid::PixelGrid;
pub use prefiltered::PrefilteredEnvironment;

/// Largest number of pixels: a map of 8192 x 4096.
const PIXELS_MAX: usize = 1 << 25;

/// Reason why pixels are not a valid environment map.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum EnvironmentError {
    /// The number of pixels is 0, above 2^25, or not `width * height`.
    #[error(
        "an environment map of {width} x {height} needs width * height pixels, 1 to 2^25, got {pixels}"
    )]
    Size {
        /// Columns.
        width: usize,
        /// Rows.
        height: usize,
        /// Number of pixels passed.
        pixels: usize,
    },
    /// The radiance of this pixel is negative or not finite.
    #[error("pixel {0} must be finite and not negative in every channel")]
    Pixel(usize),
}

/// Root of the number of directions whose mean is that of an environment.
pub(crate) const MEAN_SIDE: u32 = 32;

/// Radiance from every direction, constant over each pixel of an equirectangular image.
///
/// The upper edge is +y, the middle of the image -z, and +x a quarter of the width to the right of
/// it, as seen looking along -z.
#[derive(Debug, Clone, PartialEq)]
pub struct EnvironmentMap {
    grid: PixelGrid,
    /// Cumulative luminance times solid angle: before each row, then the total.
    row_sums: Vec<f64>,
    /// Cumulative luminance within each row: before each pixel, then the row total.
    column_sums: Vec<f64>,
    mean: [f64; 3],
    /// Filtered on first use.
    filtered: OnceLock<Filtered>,
}

impl EnvironmentMap {
    /// Returns an upper bound of its size in memory in bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let sums = self.row_sums.len() + self.column_sums.len();
        self.grid.bytes() + size_of::<f64>() * sums + Filtered::BYTES
    }

    /// Creates a map from linear pixels.
    ///
    /// # Shapes
    /// `width * height` pixels, row by row from the top, each row from left to right.
    ///
    /// # Units
    /// Radiance, W/(m2 sr), up to the scale of the light.
    ///
    /// # Errors
    /// Returns [`EnvironmentError::Size`] if the number of pixels is wrong and
    /// [`EnvironmentError::Pixel`] for the first pixel that is negative or not finite.
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
        let grid = PixelGrid::new(width, height, pixels);
        let edge_cosines = grid.edge_cosines();
        let mut row_sums = vec![0.0];
        let mut column_sums = Vec::with_capacity((width + 1) * height);
        let mut mean = [0.0; 3];
        for (row, row_pixels) in grid.pixels().chunks(width).enumerate() {
            let (mut sum, share) =
                (0.0, 0.5 * (edge_cosines[row] - edge_cosines[row + 1]) / width as f64);
            column_sums.push(sum);
            for pixel in row_pixels {
                let channels = pixel.map(f64::from);
                sum += luminance(channels);
                column_sums.push(sum);
                mean.iter_mut().zip(channels).for_each(|(mean, channel)| *mean += channel * share);
            }
            row_sums.push(row_sums[row] + sum * share * 4.0 * PI);
        }
        let filtered = OnceLock::new();
        Ok(Self { grid, row_sums, column_sums, mean, filtered })
    }

    /// Returns the filtered map.
    fn filtered(&self) -> &Filtered {
        self.filtered.get_or_init(|| Filtered::new(&self.grid, self.mean))
    }

    #[cfg(test)]
    fn grid(&self) -> &PixelGrid {
        &self.grid
    }

    /// Creates a map by drawing the radiance from the direction of each pixel's centre.
    fn drawn((width, height): (usize, usize), radiance: impl Fn(DVec3) -> [f64; 3]) -> Self {
        let pixel = |index: usize| {
            let polar = 180.0 * ((index / width) as f64 + 0.5) / height as f64;
            let around = 360.0 * ((index % width) as f64 + 0.5) / width as f64 - 180.0;
            let ((sin, cos), (x, z)) = (sin_cos_deg(polar), sin_cos_deg(around));
            radiance(DVec3::new(sin * x, cos, -sin * z)).map(|channel| channel as f32)
        };
        let pixels = (0..width * height).map(pixel).collect();
        Self::new(width, height, pixels).expect("radiances are finite and not negative")
    }

    /// Returns the radiance from a direction.
    ///
    /// # Domain
    /// A unit vector.
    #[must_use]
    pub fn radiance(&self, direction: DVec3) -> [f64; 3] {
        self.grid.radiance(direction)
    }

    /// Mean of directions drawn in proportion to luminance, normalized; `None` if they cancel.
    #[must_use]
    pub fn mean_direction(&self) -> Option<DVec3> {
        (self.sum_of_directions() / f64::from(MEAN_SIDE * MEAN_SIDE)).try_normalize()
    }

    /// Sum of `MEAN_SIDE` squared directions drawn in proportion to luminance.
    pub(crate) fn sum_of_directions(&self) -> DVec3 {
        let at = |k: u32| (f64::from(k) + 0.5) / f64::from(MEAN_SIDE);
        let points = (0..MEAN_SIDE).flat_map(|x| (0..MEAN_SIDE).map(move |y| [at(x), at(y)]));
        points.filter_map(|point| self.draw(point)).map(|(direction, _)| direction).sum()
    }

    /// Mean radiance over all directions.
    #[must_use]
    pub fn mean(&self) -> [f64; 3] {
        self.mean
    }

    /// Samples a direction in proportion to luminance; returns it with its radiance, or `None` if
    /// the map is black.
    ///
    /// # Domain
    /// Both coordinates of the sample point within [0, 1).
    pub(crate) fn draw(&self, [x, y]: [f64; 2]) -> Option<(DVec3, [f64; 3])> {
        let (width, height) = self.grid.size();
        let total = self.row_sums[height];
        if total <= 0.0 {
            return None;
        }
        let (row, within_row) = find_interval(&self.row_sums, y * total);
        let columns = &self.column_sums[row * (width + 1)..][..=width];
        let (column, within_column) = find_interval(columns, x * columns[width]);
        let edges = &self.grid.edge_cosines()[row..row + 2];
        let cos = edges[0] + (edges[1] - edges[0]) * within_row;
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        let turns = ((column as f64 + within_column) / width as f64 - 0.5) * 2.0 * PI;
        let direction = DVec3::new(sin * libm::sin(turns), cos, -sin * libm::cos(turns));
        let radiance = self.grid.pixel(row, column);
        (luminance(radiance) > 0.0).then_some((direction, radiance))
    }

    /// Probability density with which [`Self::draw`] samples a direction of that radiance; constant
    /// over a pixel.
    ///
    /// # Units
    /// 1/sr; 0 for a black map.
    pub(crate) fn density(&self, radiance: [f64; 3]) -> f64 {
        let total = self.row_sums[self.grid.size().1];
        if total > 0.0 { luminance(radiance) / total } else { 0.0 }
    }

    /// Hash of size and pixels.
    #[must_use]
    pub fn content_hash(&self) -> blake3::Hash {
        let mut hasher = blake3::Hasher::new();
        hasher.update(&(self.grid.size().0 as u64).to_le_bytes());
        for pixel in self.grid.pixels() {
            hasher.update(bytemuck::bytes_of(pixel));
        }
        hasher.finalize()
    }
}

/// Returns the index of the non-empty interval of cumulative `sums` that contains `value`, and the
/// fraction of the interval below `value`.
fn find_interval(sums: &[f64], value: f64) -> (usize, f64) {
    let last = sums.len() - 2;
    let index = sums.partition_point(|sum| *sum <= value).saturating_sub(1);
    // Rounding may select an index past the end or an empty interval.
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

    /// A map of 16 x 8 pixels, black except for the given ones.
    fn map(lit: &[(usize, [f32; 3])]) -> EnvironmentMap {
        let mut pixels = vec![[0.0; 3]; 128];
        lit.iter().for_each(|(index, radiance)| pixels[*index] = *radiance);
        EnvironmentMap::new(16, 8, pixels).unwrap()
    }

    #[test]
    fn radiance_is_oriented_as_seen_looking_along_minus_z() {
        let index = |row: usize, column: usize| row * 16 + column;
        let map =
            map(&[(index(3, 8), [1.0; 3]), (index(3, 12), [2.0; 3]), (index(0, 0), [3.0; 3])]);
        let level = |x: f64, z: f64| DVec3::new(x, 0.1, z).normalize();
        assert_eq!(map.radiance(level(0.01, -1.0))[0], 1.0, "centre of the image");
        assert_eq!(map.radiance(level(1.0, 0.01))[0], 2.0, "three quarters of the width");
        assert_eq!(
            map.radiance(DVec3::new(-0.001, 1.0, 0.02).normalize())[0],
            3.0,
            "upper left corner"
        );
    }

    #[test]
    fn draw_estimates_the_mean_and_skips_black_pixels() {
        let map = map(&[(5, [1.0, 2.0, 3.0]), (77, [40.0, 1.0, 0.5]), (127, [0.1; 3])]);
        let side = 256;
        let mut sum = [0.0; 3];
        for k in 0..side * side {
            let at = |k: usize| (k as f64 + 0.5) / side as f64;
            let (direction, radiance) = map.draw([at(k % side), at(k / side)]).unwrap();
            assert_eq!(radiance, map.radiance(direction), "{direction}");
            assert!(radiance[0] > 0.0, "{direction}");
            let density = map.density(radiance);
            sum.iter_mut().zip(radiance).for_each(|(sum, radiance)| *sum += radiance / density);
        }
        for (sum, mean) in sum.iter().zip(map.mean()) {
            let estimate = sum / (side * side) as f64 / (4.0 * PI);
            assert!((estimate - mean).abs() < 3e-2 * mean, "{estimate} {mean}");
        }
    }

    #[test]
    fn draw_is_uniform_when_the_map_is_constant() {
        let map = EnvironmentMap::new(7, 5, vec![[2.0; 3]; 35]).unwrap();
        for place in [[0.0, 0.0], [0.3, 0.9], [0.999_999, 0.999_999]] {
            let (direction, radiance) = map.draw(place).unwrap();
            assert!((direction.length() - 1.0).abs() < 1e-12);
            assert!((map.density(radiance) * 4.0 * PI - 1.0).abs() < 1e-12, "{radiance:?}");
        }
        assert!((map.mean()[1] - 2.0).abs() < 1e-12);
    }

    #[test]
    fn map_is_refused_when_its_size_or_a_pixel_is_invalid() {
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
