//! Prefiltered radiance of an environment: means over ever wider parts of the sphere.

use std::borrow::Cow;
use std::f64::consts::PI;

use glam::DVec3;

use super::grid::PixelGrid;
use super::sphere_map::{direction, square, texel_angle, wrapped};

/// Largest side of the finest level: 0.4 degrees a texel.
const SIDE_MAX: usize = 512;
/// Side of the coarsest level, if the finest is not smaller: 25 degrees a texel.
const SIDE_MIN: usize = 8;
/// Side of the square of irradiances: 3 degrees a texel.
const IRRADIANCE_SIDE: usize = 64;
/// Weights of the four texels of a finer level that each axis of a texel covers: a quadratic
/// B-spline, so that wide means change smoothly.
const SPLINE: [f32; 4] = [0.125, 0.375, 0.375, 0.125];
/// Side of a texel divided by the spacing of tents whose variance equals that of the texel's
/// filter: 0.25 texels squared by [`SPLINE`] and 1/6 by interpolation, against 1/6 of the spacing
/// squared.
const TEXEL_PER_SPACING: f64 = 0.63;

/// Means of radiance over the sphere, each level half as fine as the one before.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Pyramid {
    levels: Vec<Level>,
}

/// Square of texels with a border of one texel, which continues the map.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Level {
    side: usize,
    texels: Vec<[f32; 4]>,
}

impl Pyramid {
    /// Upper bound of the memory of a pyramid, in bytes.
    pub const BYTES: usize = SIDE_MAX * SIDE_MAX * 16 * 3 / 2;

    /// Filters the means of a square of texels.
    pub fn new(mut means: Vec<[f32; 3]>, mut side: usize) -> Self {
        let mut levels = Vec::new();
        loop {
            levels.push(Level::new(side, &means));
            if side == SIDE_MIN {
                return Self { levels };
            }
            means = halved(&means, side);
            side /= 2;
        }
    }

    /// Returns the level whose means are as wide as tents of that spacing in radians; fractions lie
    /// between levels.
    pub fn level(&self, spacing: f64) -> f32 {
        let finest = texel_angle(self.levels[0].side);
        let level = libm::log2(TEXEL_PER_SPACING * spacing / finest);
        level.clamp(0.0, (self.levels.len() - 1) as f64) as f32
    }

    /// Returns the mean radiance around a point of the square of [`square`].
    ///
    /// # Domain
    /// Both coordinates within [0, 1]. A level beyond the coarsest means the coarsest.
    #[inline(always)]
    pub fn radiance(&self, point: [f32; 2], level: u8) -> [f32; 4] {
        self.levels[usize::from(level).min(self.levels.len() - 1)].radiance(point)
    }
}

impl Level {
    /// Adds the border to `side` x `side` values.
    pub fn new(side: usize, means: &[[f32; 3]]) -> Self {
        let last = i64::try_from(side).expect("a side is small");
        let mut texels = Vec::with_capacity((side + 2) * (side + 2));
        for y in -1..=last {
            for x in -1..=last {
                let (x, y) = wrapped((x, y), last);
                let [r, g, b] = means[y * side + x];
                texels.push([r, g, b, 0.0]);
            }
        }
        Self { side, texels }
    }

    /// Interpolates between the texels around a point of the square; the fourth channel is 0.
    #[inline(always)]
    pub fn radiance(&self, [x, y]: [f32; 2]) -> [f32; 4] {
        let (x, y) = (x * self.side as f32 + 0.5, y * self.side as f32 + 0.5);
        // Both are positive, so that truncation rounds down.
        let (column, row) = (x as usize, y as usize);
        let (a, b) = (x - column as f32, y - row as f32);
        let stride = self.side + 2;
        let at = row.min(self.side) * stride + column.min(self.side);
        let (top, bottom) = (&self.texels[at..at + 2], &self.texels[at + stride..at + stride + 2]);
        // Loops without closures, which are not compiled with the instructions of a caller.
        let mut mean = [0.0; 4];
        for c in 0..4 {
            let above = top[0][c] + (top[1][c] - top[0][c]) * a;
            let below = bottom[0][c] + (bottom[1][c] - bottom[0][c]) * a;
            mean[c] = above + (below - above) * b;
        }
        mean
    }
}

/// Returns the mean radiance of each texel of a square as fine as the map, and the texels of a
/// side.
pub(super) fn means(map: &PixelGrid) -> (Vec<[f32; 3]>, usize) {
    let (width, height) = map.size();
    let pixels = width * height;
    let mut side = SIDE_MIN;
    while side < SIDE_MAX && 4 * side * side <= pixels {
        side *= 2;
    }
    (if pixels >= 16 * side * side { splat(map, side) } else { draw(map, side) }, side)
}

/// Returns the irradiance of surfaces that face each texel of a square, and its side.
///
/// # Shapes
/// `means`: radiance of each texel of a square of `side` texels.
pub(super) fn irradiance(means: &[[f32; 3]], side: usize) -> (Vec<[f32; 3]>, usize) {
    let (mut means, mut fine) = (Cow::Borrowed(means), side);
    while fine > IRRADIANCE_SIDE {
        let half = fine / 2;
        let mean = |k: usize| {
            let at = 2 * (k / half) * fine + 2 * (k % half);
            let four = [means[at], means[at + 1], means[at + fine], means[at + fine + 1]];
            [0, 1, 2].map(|c| 0.25 * four.iter().map(|texel| texel[c]).sum::<f32>())
        };
        means = Cow::Owned((0..half * half).map(mean).collect());
        fine = half;
    }
    let centre = |k: usize, side: usize| {
        let at = |texel: usize| (texel as f64 + 0.5) / side as f64;
        direction([at(k % side), at(k / side)]).as_vec3().to_array()
    };
    let from: Vec<[f32; 3]> = (0..fine * fine).map(|k| centre(k, fine)).collect();
    let share = (4.0 * PI / (fine * fine) as f64) as f32;
    let facing = |k: usize| {
        let n = centre(k, IRRADIANCE_SIDE);
        let (mut sum, mut cosines) = ([0.0f32; 3], 0.0f32);
        for (towards, mean) in from.iter().zip(&*means) {
            let cos = (n[0] * towards[0] + n[1] * towards[1] + n[2] * towards[2]).max(0.0);
            cosines += cos;
            (0..3).for_each(|c| sum[c] += cos * mean[c]);
        }
        // The sum of cosines is pi over the share, up to the error of the texels.
        let scale = PI as f32 / (cosines * share) * share;
        sum.map(|sum| sum * scale)
    };
    ((0..IRRADIANCE_SIDE * IRRADIANCE_SIDE).map(facing).collect(), IRRADIANCE_SIDE)
}

/// Returns the means of texels from samples of the map at 3 x 3 points each.
fn draw(map: &PixelGrid, side: usize) -> Vec<[f32; 3]> {
    const POINTS: usize = 3;
    let texel = |index: usize| {
        let mut sum = [0.0; 3];
        for point in 0..POINTS * POINTS {
            let at = |texel: usize, k: usize| {
                (texel as f64 + (k as f64 + 0.5) / POINTS as f64) / side as f64
            };
            let place = [at(index % side, point % POINTS), at(index / side, point / POINTS)];
            let radiance = map.radiance(direction(place));
            sum.iter_mut().zip(radiance).for_each(|(sum, channel)| *sum += channel);
        }
        sum.map(|sum| (sum / (POINTS * POINTS) as f64) as f32)
    };
    (0..side * side).map(texel).collect()
}

/// Returns the means of texels from all pixels of a map that has many for each texel.
fn splat(map: &PixelGrid, side: usize) -> Vec<[f32; 3]> {
    let (width, height) = map.size();
    let turns: Vec<(f64, f64)> = (0..width)
        .map(|column| ((column as f64 + 0.5) / width as f64 - 0.5) * 2.0 * PI)
        .map(|turn| (libm::sin(turn), -libm::cos(turn)))
        .collect();
    let mut sums = vec![[0.0f64; 4]; side * side];
    for row in 0..height {
        let (cos, solid_angle) = map.row(row);
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        for (column, (x, z)) in turns.iter().enumerate() {
            let towards = DVec3::new(sin * x, cos, sin * z).as_vec3();
            let [u, v] = square(towards.to_array());
            let texel = |at: f32| ((at * side as f32) as usize).min(side - 1);
            let sum = &mut sums[texel(v) * side + texel(u)];
            for (sum, channel) in sum.iter_mut().zip(map.pixel(row, column)) {
                *sum += channel * solid_angle;
            }
            sum[3] += solid_angle;
        }
    }
    let mean = |[r, g, b, all]: [f64; 4]| [r, g, b].map(|sum| (sum / all.max(1e-30)) as f32);
    sums.into_iter().map(mean).collect()
}

/// Returns a square of means half as fine.
fn halved(means: &[[f32; 3]], side: usize) -> Vec<[f32; 3]> {
    let half = side / 2;
    let all = i64::try_from(side).expect("a side is small");
    let texel = |index: usize| {
        let first = |k: usize| i64::try_from(2 * k).expect("a side is small") - 1;
        let (left, top) = (first(index % half), first(index / half));
        let mut sum = [0.0; 3];
        for (y, down) in (top..).zip(SPLINE) {
            for (x, across) in (left..).zip(SPLINE) {
                let (x, y) = wrapped((x, y), all);
                for (sum, mean) in sum.iter_mut().zip(means[y * side + x]) {
                    *sum += down * across * mean;
                }
            }
        }
        sum
    };
    (0..half * half).map(texel).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environment::EnvironmentMap;

    #[test]
    fn every_level_keeps_the_mean() {
        for (width, height) in [(64, 32), (31, 9), (2048, 1024)] {
            let pixel = |k: usize| {
                let (row, column) = (k / width, k % width);
                [1.0 + (row * 7 / height) as f32, (column * 5 / width) as f32, 0.25]
            };
            let map = EnvironmentMap::new(width, height, (0..width * height).map(pixel).collect())
                .unwrap();
            let (texels, side) = means(map.grid());
            let pyramid = Pyramid::new(texels, side);
            for level in &pyramid.levels {
                let mut sum = [0.0f64; 3];
                for y in 1..=level.side {
                    for x in 1..=level.side {
                        let texel = level.texels[y * (level.side + 2) + x];
                        (0..3).for_each(|c| sum[c] += f64::from(texel[c]));
                    }
                }
                for (sum, mean) in sum.iter().zip(map.mean()) {
                    let found = sum / (level.side * level.side) as f64;
                    let bound = if width < 64 { 0.05 } else { 0.02 };
                    assert!(
                        (found - mean).abs() < bound * mean,
                        "{width} {} {found} {mean}",
                        level.side
                    );
                }
            }
        }
    }

    #[test]
    fn finest_level_shows_the_map_and_coarser_ones_blur_it() {
        let lit = |k: usize| if k / 256 < 40 { [4.0; 3] } else { [0.0; 3] };
        let map = EnvironmentMap::new(256, 128, (0..256 * 128).map(lit).collect()).unwrap();
        let (texels, side) = means(map.grid());
        let pyramid = Pyramid::new(texels, side);
        let up = [0.0, 1.0, 0.0];
        let down = [0.6, -0.8, 0.0];
        assert_eq!(pyramid.radiance(square(up), 0)[..3], [4.0; 3]);
        assert_eq!(pyramid.radiance(square(down), 0)[..3], [0.0; 3]);
        let [far, ..] = pyramid.radiance(square([0.8, 0.6, 0.0]), 4);
        assert!(far > 0.5 && far < 3.5, "{far}");
        assert!(pyramid.level(0.0) == 0.0 && pyramid.level(0.2) > 2.0);
    }
}
