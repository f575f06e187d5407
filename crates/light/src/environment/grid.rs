//! Pixels of an equirectangular picture, and their directions.

use std::f64::consts::PI;

use brood_mesh::angle::sin_cos_deg;
use glam::DVec3;

/// Pixels row by row from the top, each row from left to right; oriented as
/// [`super::EnvironmentMap`].
#[derive(Debug, Clone, PartialEq)]
pub(super) struct PixelGrid {
    width: usize,
    height: usize,
    pixels: Vec<[f32; 3]>,
    /// Cosine of the polar angle at the upper edge of each row, then at the lower edge of the last.
    edge_cosines: Vec<f64>,
}

impl PixelGrid {
    /// # Domain
    /// `width * height` pixels, at least one.
    pub fn new(width: usize, height: usize, pixels: Vec<[f32; 3]>) -> Self {
        let edge = |row: usize| sin_cos_deg(180.0 * row as f64 / height as f64).1;
        let edge_cosines = (0..=height).map(edge).collect();
        Self { width, height, pixels, edge_cosines }
    }

    /// Returns its size in memory in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(self.pixels.as_slice()) + size_of_val(self.edge_cosines.as_slice())
    }

    /// Returns the numbers of columns and rows.
    pub fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    pub fn pixels(&self) -> &[[f32; 3]] {
        &self.pixels
    }

    pub fn edge_cosines(&self) -> &[f64] {
        &self.edge_cosines
    }

    /// Returns the cosine of the polar angle in the middle of a row, and the solid angle of each of
    /// its pixels.
    pub fn row(&self, row: usize) -> (f64, f64) {
        let (above, below) = (self.edge_cosines[row], self.edge_cosines[row + 1]);
        (0.5 * (above + below), 2.0 * PI * (above - below) / self.width as f64)
    }

    pub fn pixel(&self, row: usize, column: usize) -> [f64; 3] {
        self.pixels[row * self.width + column].map(f64::from)
    }

    /// Returns the radiance from a direction.
    ///
    /// # Domain
    /// A unit vector.
    pub fn radiance(&self, direction: DVec3) -> [f64; 3] {
        let turns = libm::atan2(direction.x, -direction.z) / (2.0 * PI) + 0.5;
        // Truncation selects the pixel; the seam belongs to the last column.
        let column = ((turns * self.width as f64) as usize).min(self.width - 1);
        let below = self.edge_cosines.partition_point(|edge| *edge >= direction.y);
        let row = below.saturating_sub(1).min(self.height - 1);
        self.pixel(row, column)
    }
}
