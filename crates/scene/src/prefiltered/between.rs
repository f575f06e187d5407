//! Pixels between points: where a picture is smooth, some pixels take the bilinear mean of the
//! radiances of points around them, instead of light of their own.
//!
//! Lobes vary over a picture as the light around the mirror direction does, seen as wide as they
//! are. A square of pixels has light at its corners alone if bilinear means of their mirrored
//! light, narrow and wide, and of their normals are close to those of every pixel within.

use rayon::prelude::*;

use super::point::LitPoint;
use crate::{PictureSize, PixelArea};

/// Sides of the largest and the smallest squares, in pixels.
const LARGEST: usize = 8;
const SMALLEST: usize = 2;
/// Largest error of a mean radiance, relative to itself.
const RADIANCE_ERROR: f32 = 0.02;
/// Largest error of a mean radiance, relative to the radiance of a white diffuse surface.
const DIFFUSE_ERROR: f32 = 0.005;
/// Largest distance of a normal from the mean.
const NORMAL_ERROR: f32 = 0.005;
/// Share of a pixel from which one point is all of it, up to rounding.
const WHOLE: f32 = 0.999;
/// Pixel without a single point.
const NONE: u32 = u32::MAX;

/// Pixel whose radiance is a mean of those of four points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelBetween {
    /// Index of the pixel in the image.
    pub pixel: u32,
    /// Indices of the points.
    pub points: [u32; 4],
    /// Weights of the points; their sum is the share of the pixel.
    pub weights: [f32; 4],
}

/// Widths of lobes for which the light is compared, in radians: 0.35 to 11 degrees.
pub(super) const WIDTHS: [f64; 4] = [0.006, 0.02, 0.06, 0.2];

/// Light of a point around its mirror direction.
#[derive(Debug, Clone, Copy)]
pub(super) struct MirroredLight {
    /// Mean radiance for each of [`WIDTHS`].
    pub radiance: [[f32; 3]; WIDTHS.len()],
    /// Radiance of a white diffuse surface, a mean of the channels.
    pub diffuse: f32,
}

/// Square of pixels: its corner of least coordinates, and the distance to the next corners.
#[derive(Clone, Copy)]
struct Square {
    x: usize,
    y: usize,
    side: usize,
}

/// Points of a picture by pixel.
struct Grid<'a> {
    points: &'a [LitPoint],
    mirrored: &'a [MirroredLight],
    width: usize,
    height: usize,
    /// The point of each pixel that has one alone; otherwise [`NONE`].
    single: Vec<u32>,
}

/// Separates the pixels of a picture that need no light of their own. Returns the points of the
/// others, and the pixels between them; both ascend.
///
/// # Shapes
/// `mirrored`: one for each point; `width`: that of the picture in pixels. The first pixel is the
/// corner of a square.
pub(super) fn thin(
    points: Vec<LitPoint>,
    mirrored: &[MirroredLight],
    width: usize,
) -> (Vec<LitPoint>, Vec<PixelBetween>) {
    let grid = Grid::new(&points, mirrored, width);
    let rows = (0..grid.height).into_par_iter().step_by(LARGEST);
    let squares: Vec<Square> = rows
        .flat_map_iter(|y| {
            let mut found = Vec::new();
            for x in (0..width).step_by(LARGEST) {
                grid.divide(Square { x, y, side: LARGEST }, &mut found);
            }
            found
        })
        .collect();
    let mut corner = vec![false; grid.single.len()];
    for square in &squares {
        for (x, y) in square.corners() {
            corner[y * width + x] = true;
        }
    }
    let mut square_of = vec![NONE; grid.single.len()];
    for (square, index) in squares.iter().zip(0..) {
        for (dx, dy) in square.own_pixels() {
            let pixel = (square.y + dy) * width + square.x + dx;
            if !corner[pixel] {
                square_of[pixel] = index;
            }
        }
    }
    let mut kept = Vec::new();
    let mut indices = vec![NONE; points.len()];
    for (point, index) in points.iter().zip(&mut indices) {
        if square_of[point.pixel as usize] == NONE {
            *index = kept.len() as u32;
            kept.push(*point);
        }
    }
    let mut between = Vec::new();
    for (pixel, square) in (0..).zip(&square_of) {
        if *square == NONE {
            continue;
        }
        let square = squares[*square as usize];
        let (dx, dy) = (pixel as usize % width - square.x, pixel as usize / width - square.y);
        let share = points[grid.single[pixel as usize] as usize].weight;
        between.push(PixelBetween {
            pixel,
            points: square.corners().map(|(x, y)| indices[grid.single[y * width + x] as usize]),
            weights: square.weights((dx, dy)).map(|weight| weight * share),
        });
    }
    (kept, between)
}

/// Returns the area whose points decide how the pixels of an area are lit: the squares of the whole
/// picture in it, and those before, of which the corners are points.
pub(super) fn surroundings(area: PixelArea, size_px: PictureSize) -> PixelArea {
    let side = LARGEST as u32;
    let first = |at: u32| (at / side).saturating_sub(1) * side;
    let end = |at: u32, most: u32| (at.next_multiple_of(side) + 1).min(most);
    let (x, y) = (first(area.x), first(area.y));
    PixelArea {
        x,
        y,
        width: end(area.x + area.width, size_px.width) - x,
        height: end(area.y + area.height, size_px.height) - y,
    }
}

/// Keeps the pixels of an area. Points outside of it that light its pixels stay, with weight 0.
pub(super) fn crop(
    (points, mut between): (Vec<LitPoint>, Vec<PixelBetween>),
    from: PixelArea,
    to: PixelArea,
) -> (Vec<LitPoint>, Vec<PixelBetween>) {
    let place = |pixel: u32| {
        let (x, y) = (from.x + pixel % from.width, from.y + pixel / from.width);
        let (x, y) = (x.checked_sub(to.x)?, y.checked_sub(to.y)?);
        (x < to.width && y < to.height).then(|| y * to.width + x)
    };
    between.retain_mut(|one| place(one.pixel).map(|pixel| one.pixel = pixel).is_some());
    let mut is_used = vec![false; points.len()];
    for point in between.iter().flat_map(|one| one.points) {
        is_used[point as usize] = true;
    }
    let mut kept = Vec::new();
    let mut indices = vec![NONE; points.len()];
    for ((point, is_used), index) in points.into_iter().zip(is_used).zip(&mut indices) {
        *index = kept.len() as u32;
        match place(point.pixel) {
            Some(pixel) => kept.push(LitPoint { pixel, ..point }),
            None if is_used => kept.push(LitPoint { pixel: 0, weight: 0.0, ..point }),
            None => {}
        }
    }
    for one in &mut between {
        one.points = one.points.map(|point| indices[point as usize]);
    }
    (kept, between)
}

impl<'a> Grid<'a> {
    fn new(points: &'a [LitPoint], mirrored: &'a [MirroredLight], width: usize) -> Self {
        let height = points.last().map_or(0, |last| last.pixel as usize / width + 1);
        let mut single = vec![NONE; width * height];
        for (pixel, index) in points.chunk_by(|a, b| a.pixel == b.pixel).scan(0, |start, pixel| {
            let index = *start;
            *start += pixel.len() as u32;
            Some((pixel, index))
        }) {
            if pixel.len() == 1 && pixel[0].weight > WHOLE {
                single[pixel[0].pixel as usize] = index;
            }
        }
        Self { points, mirrored, width, height, single }
    }

    /// Adds the largest squares within a square that need light at their corners alone.
    fn divide(&self, square: Square, found: &mut Vec<Square>) {
        if self.is_smooth(square) {
            found.push(square);
        } else if square.side > SMALLEST {
            let side = square.side / 2;
            for (right, below) in [(0, 0), (side, 0), (0, side), (side, side)] {
                self.divide(Square { x: square.x + right, y: square.y + below, side }, found);
            }
        }
    }

    /// True if the bilinear means of the corners are close to the values of every pixel.
    fn is_smooth(&self, square: Square) -> bool {
        let Square { x, y, side } = square;
        if x + side >= self.width || y + side >= self.height {
            return false;
        }
        let at = |x: usize, y: usize| match self.single[y * self.width + x] {
            NONE => None,
            index => Some((&self.points[index as usize], &self.mirrored[index as usize])),
        };
        let mut corners = [None; 4];
        for (corner, (x, y)) in corners.iter_mut().zip(square.corners()) {
            *corner = at(x, y);
        }
        let [Some(a), Some(b), Some(c), Some(d)] = corners else { return false };
        square.pixels().all(|(dx, dy)| {
            let Some((point, light)) = at(x + dx, y + dy) else { return false };
            let weights = square.weights((dx, dy));
            let mean = |values: [[f32; 3]; 4]| {
                [0, 1, 2].map(|axis| (0..4).map(|k| weights[k] * values[k][axis]).sum::<f32>())
            };
            let n = mean([a, b, c, d].map(|(point, _)| point.n));
            let squares = (0..3).map(|axis| (n[axis] - point.n[axis]).powi(2));
            squares.sum::<f32>() <= NORMAL_ERROR * NORMAL_ERROR
                && (0..WIDTHS.len()).all(|width| {
                    let own = light.radiance[width];
                    let radiance = mean([a, b, c, d].map(|(_, light)| light.radiance[width]));
                    (0..3).all(|channel| {
                        let bound = RADIANCE_ERROR * own[channel] + DIFFUSE_ERROR * light.diffuse;
                        (radiance[channel] - own[channel]).abs() <= bound
                    })
                })
        })
    }
}

impl Square {
    fn corners(self) -> [(usize, usize); 4] {
        let Self { x, y, side } = self;
        [(x, y), (x + side, y), (x, y + side), (x + side, y + side)]
    }

    /// Returns the distances of all pixels, borders included, from the first corner, without the
    /// corners.
    fn pixels(self) -> impl Iterator<Item = (usize, usize)> {
        let Self { side, .. } = self;
        let all = (0..=side).flat_map(move |dy| (0..=side).map(move |dx| (dx, dy)));
        all.filter(move |(dx, dy)| !(dx.is_multiple_of(side) && dy.is_multiple_of(side)))
    }

    /// As [`Self::pixels`], without the borders that belong to the next squares.
    fn own_pixels(self) -> impl Iterator<Item = (usize, usize)> {
        self.pixels().filter(move |(dx, dy)| *dx < self.side && *dy < self.side)
    }

    /// Returns the bilinear weights of the corners at a pixel.
    fn weights(self, (dx, dy): (usize, usize)) -> [f32; 4] {
        let [right, below] = [dx, dy].map(|distance| distance as f32 / self.side as f32);
        let (left, above) = (1.0 - right, 1.0 - below);
        [left * above, right * above, left * below, right * below]
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    const WIDTH: usize = 37;
    const HEIGHT: usize = 29;

    /// A plane that fills the picture, with mirrored light by pixel.
    fn plane(light: impl Fn(usize, usize) -> f32) -> (Vec<LitPoint>, Vec<MirroredLight>) {
        let pixels = (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x, y)));
        let points = |(pixel, (x, y)): (u32, (usize, usize))| {
            let point = LitPoint::new((pixel, 1.0), (DVec3::Z, DVec3::Z), 0.0);
            let radiance = [[light(x, y); 3]; WIDTHS.len()];
            (point, MirroredLight { radiance, diffuse: 1.0 })
        };
        (0..).zip(pixels).map(points).unzip()
    }

    /// Asserts that every pixel is a point or between points, once, and returns the number of
    /// points and the radiances that pixels get from those of points.
    fn check(light: impl Fn(usize, usize) -> f32) -> (usize, Vec<f32>) {
        let (points, mirrored) = plane(&light);
        let (kept, between) = thin(points, &mirrored, WIDTH);
        let mut found = vec![f32::NAN; WIDTH * HEIGHT];
        let own = |pixel: u32| light(pixel as usize % WIDTH, pixel as usize / WIDTH);
        for point in &kept {
            found[point.pixel as usize] = own(point.pixel);
        }
        for pixel in &between {
            assert!(found[pixel.pixel as usize].is_nan(), "{pixel:?}");
            assert!((pixel.weights.iter().sum::<f32>() - 1.0).abs() < 1e-6, "{pixel:?}");
            let corners = pixel.points.map(|point| own(kept[point as usize].pixel));
            let products = corners.iter().zip(pixel.weights).map(|(light, weight)| light * weight);
            found[pixel.pixel as usize] = products.sum();
        }
        assert!(found.iter().all(|light| light.is_finite()));
        assert!(kept.is_sorted_by_key(|point| point.pixel));
        assert!(between.is_sorted_by_key(|pixel| pixel.pixel));
        (kept.len(), found)
    }

    #[test]
    fn linear_light_needs_the_corners_of_large_squares_alone() {
        let (points, found) = check(|x, y| 1.0 + x as f32 * 0.1 + y as f32 * 0.2);
        assert!(points < WIDTH * HEIGHT / 6, "{points}");
        for (pixel, found) in found.iter().enumerate() {
            let expected = 1.0 + (pixel % WIDTH) as f32 * 0.1 + (pixel / WIDTH) as f32 * 0.2;
            assert!((found - expected).abs() < 1e-5, "{pixel}");
        }
    }

    #[test]
    fn edges_and_spots_have_light_of_their_own() {
        let light = |x: usize, y: usize| match (x, y) {
            (13, 9) => 50.0,
            _ if x + y < 40 => 0.2,
            _ => 3.0,
        };
        let (points, found) = check(light);
        assert!(points < WIDTH * HEIGHT * 2 / 3, "{points}");
        for (pixel, found) in found.iter().enumerate() {
            let own = light(pixel % WIDTH, pixel / WIDTH);
            let bound = RADIANCE_ERROR * own + DIFFUSE_ERROR;
            assert!((found - own).abs() <= bound * 1.001, "{pixel} {found} {own}");
        }
    }

    #[test]
    fn pixels_of_several_points_and_curved_ones_are_kept() {
        let (mut points, mirrored) = plane(|_, _| 1.0);
        let middle = 14 * WIDTH + 18;
        points[middle].weight = 0.5;
        points[middle + 4].n = [0.1, 0.0, 0.995];
        let (kept, _) = thin(points, &mirrored, WIDTH);
        for pixel in [middle, middle + 4] {
            assert!(kept.iter().any(|point| point.pixel as usize == pixel), "{pixel}");
        }
    }
}
