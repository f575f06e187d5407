//! Images that scenes and painted materials name, filtered by footprint.

use std::ops::Range;

use glam::DVec2;

/// Largest number of positions along the longer side of a footprint.
const TAPS_MAX: f64 = 16.0;

/// Image pyramid: each level has half the width and height of the level before, down to one pixel.
/// Pixels are display values times opacity, and are averaged in these values.
#[derive(Debug)]
pub struct ImagePyramid {
    levels: Vec<Level>,
    hash: blake3::Hash,
}

/// Colours beyond the sides of an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Beyond {
    /// The image again.
    Repeated,
    /// The nearest pixel.
    Nearest,
}

#[derive(Debug)]
struct Level {
    width: u32,
    height: u32,
    pixels: Vec<[u8; 4]>,
}

impl ImagePyramid {
    /// Creates an image from codes of red, green, blue and opacity, rows from the top.
    ///
    /// # Panics
    /// If there are no pixels, or not as many as width times height.
    #[must_use]
    pub fn new(width: u32, height: u32, rgba: &[u8]) -> Self {
        let pixels = rgba.as_chunks::<4>().0;
        let count = width as usize * height as usize;
        assert!(count > 0 && rgba.len() == 4 * count, "{width} x {height} pixels of 4 codes");
        let codes = |value: [f32; 4]| value.map(|channel| (channel + 0.5) as u8);
        let level = |(width, height), pixels| Level { width, height, pixels };
        let mut size = (width, height);
        let whole = pixels.iter().map(|pixel| codes(premultiplied(pixel))).collect();
        let mut levels = vec![level(size, whole)];
        // The first level is not kept in f32, as large images would take four times the memory.
        let mut values: Option<Vec<[f32; 4]>> = None;
        while size != (1, 1) {
            let half = (size.0.div_ceil(2), size.1.div_ceil(2));
            let smaller = match &values {
                None => halved(|at| premultiplied(&pixels[at]), size, half),
                Some(values) => halved(|at| values[at], size, half),
            };
            size = half;
            levels.push(level(size, smaller.iter().copied().map(codes).collect()));
            values = Some(smaller);
        }
        let mut hasher = blake3::Hasher::new();
        hasher.update(&width.to_le_bytes()).update(&height.to_le_bytes());
        hasher.update(levels[0].pixels.as_flattened());
        Self { levels, hash: hasher.finalize() }
    }

    /// Hash of the size and the pixels.
    #[must_use]
    pub fn content_hash(&self) -> blake3::Hash {
        self.hash
    }

    /// Width and height in pixels.
    #[must_use]
    pub fn size(&self) -> (u32, u32) {
        (self.levels[0].width, self.levels[0].height)
    }

    /// Memory in bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.levels.iter().map(|level| size_of_val(level.pixels.as_slice())).sum()
    }

    /// Returns red, green and blue times opacity, and opacity, at a texture position: (0, 0) is the
    /// lower left corner of the image and (1, 1) the upper right one; it repeats beyond. The mean
    /// is over the parallelogram of a footprint, by trilinear samples along its longer side
    /// (McCormack et al. 1999, *Feline*).
    ///
    /// # Domain
    /// Finite positions.
    ///
    /// # Units
    /// Display values from 0 to 1.
    #[must_use]
    pub fn color(&self, uv: DVec2, footprint: [DVec2; 2]) -> [f32; 4] {
        self.mean(uv, footprint, Beyond::Repeated)
    }

    /// As [`ImagePyramid::color`], but the colours beyond the image are those of its nearest pixel.
    #[must_use]
    pub fn color_within(&self, uv: DVec2, footprint: [DVec2; 2]) -> [f32; 4] {
        self.mean(uv, footprint, Beyond::Nearest)
    }

    fn mean(&self, uv: DVec2, footprint: [DVec2; 2], beyond: Beyond) -> [f32; 4] {
        let (width, height) = self.size();
        let size = DVec2::new(f64::from(width), f64::from(height));
        let lengths = footprint.map(|side| (side * size).length());
        let (longer, side) = match lengths[0] >= lengths[1] {
            true => (lengths[0], footprint[0]),
            false => (lengths[1], footprint[1]),
        };
        let shorter = lengths[0].min(lengths[1]).max(1.0);
        let taps = (longer / shorter).ceil().clamp(1.0, TAPS_MAX);
        let level = libm::log2((longer / taps).max(1.0));
        let mut sum = [0.0; 4];
        for tap in 0..taps as u32 {
            let along = (f64::from(tap) + 0.5) / taps - 0.5;
            let color = self.trilinear(uv + side * along, level, beyond);
            sum = std::array::from_fn(|channel| sum[channel] + color[channel]);
        }
        sum.map(|channel| (channel / (255.0 * taps)) as f32)
    }

    /// Interpolates between the two levels around `level`: 0 is the whole image.
    fn trilinear(&self, uv: DVec2, level: f64, beyond: Beyond) -> [f64; 4] {
        let last = self.levels.len() - 1;
        let finer = (level as usize).min(last);
        let share = (level - finer as f64).clamp(0.0, 1.0);
        let a = self.levels[finer].bilinear(uv, beyond);
        if share == 0.0 || finer == last {
            return a;
        }
        let b = self.levels[finer + 1].bilinear(uv, beyond);
        std::array::from_fn(|channel| a[channel] + share * (b[channel] - a[channel]))
    }
}

impl Level {
    /// Interpolates between the middles of pixels. Opposite sides of repeated images are
    /// neighbours.
    fn bilinear(&self, uv: DVec2, beyond: Beyond) -> [f64; 4] {
        let place = |at: f64, count: u32| {
            let at = match beyond {
                Beyond::Repeated => at - at.floor(),
                Beyond::Nearest => at.clamp(0.0, 1.0),
            };
            let at = at * f64::from(count) - 0.5;
            let first = at.floor();
            let index = |index: f64| match beyond {
                Beyond::Repeated => index.rem_euclid(f64::from(count)) as usize,
                Beyond::Nearest => index.clamp(0.0, f64::from(count - 1)) as usize,
            };
            ([index(first), index(first + 1.0)], at - first)
        };
        let (columns, x) = place(uv.x, self.width);
        let (rows, y) = place(1.0 - uv.y, self.height);
        let pixel = |row: usize, column: usize| {
            self.pixels[rows[row] * self.width as usize + columns[column]].map(f64::from)
        };
        let mixed = |a: [f64; 4], b: [f64; 4], share: f64| -> [f64; 4] {
            std::array::from_fn(|channel| a[channel] + share * (b[channel] - a[channel]))
        };
        let row = |row: usize| mixed(pixel(row, 0), pixel(row, 1), x);
        mixed(row(0), row(1), y)
    }
}

fn premultiplied(codes: &[u8; 4]) -> [f32; 4] {
    let opacity = f32::from(codes[3]) / 255.0;
    let [red, green, blue, alpha] = codes.map(f32::from);
    [red * opacity, green * opacity, blue * opacity, alpha]
}

/// Averages pixels to a size of half as many, rounded up. Each pixel of an odd row counts by the
/// share of it that a new one covers.
fn halved(value: impl Fn(usize) -> [f32; 4], size: (u32, u32), half: (u32, u32)) -> Vec<[f32; 4]> {
    let mut halved = Vec::with_capacity(half.0 as usize * half.1 as usize);
    for y in 0..half.1 {
        let rows = covered(y, size.1, half.1);
        for x in 0..half.0 {
            let columns = covered(x, size.0, half.0);
            let (mut sum, mut weights) = ([0.0; 4], 0.0);
            for (row, height) in &rows {
                for (column, width) in &columns {
                    let (weight, at) = (height * width, row * size.0 as usize + column);
                    let value = value(at);
                    sum = std::array::from_fn(|channel| sum[channel] + weight * value[channel]);
                    weights += weight;
                }
            }
            halved.push(sum.map(|channel| channel / weights));
        }
    }
    halved
}

/// Pixels of a row of `count` that one of `half` covers, with their shares.
fn covered(index: u32, count: u32, half: u32) -> Vec<(usize, f32)> {
    let scale = f64::from(count) / f64::from(half);
    let range = Range { start: f64::from(index) * scale, end: f64::from(index + 1) * scale };
    let last = (range.end.ceil() as u32).min(count);
    let share = |pixel: u32| {
        let (from, to) = (f64::from(pixel), f64::from(pixel + 1));
        (range.end.min(to) - range.start.max(from)) as f32
    };
    (range.start as u32..last)
        .map(|pixel| (pixel as usize, share(pixel)))
        .filter(|(_, share)| *share > 1e-6)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checkers(side: u32) -> ImagePyramid {
        let code = |at: u32| 255 * ((at % side + at / side) % 2) as u8;
        let pixel = |at: u32| [code(at), code(at), code(at), 255];
        let rgba: Vec<u8> = (0..side * side).flat_map(pixel).collect();
        ImagePyramid::new(side, side, &rgba)
    }

    const NONE: [DVec2; 2] = [DVec2::ZERO; 2];

    #[test]
    fn middles_of_pixels_are_exact_and_the_first_row_is_on_top() {
        let rgba = [10, 20, 30, 255, 40, 50, 60, 255, 70, 80, 90, 255, 100, 110, 120, 255];
        let image = ImagePyramid::new(2, 2, &rgba);
        let codes = |u, v| image.color(DVec2::new(u, v), NONE).map(|c| (c * 255.0).round() as u8);
        assert_eq!(codes(0.25, 0.75), [10, 20, 30, 255]);
        assert_eq!(codes(0.75, 0.75), [40, 50, 60, 255]);
        assert_eq!(codes(0.25, 0.25), [70, 80, 90, 255]);
        assert_eq!(codes(1.75, -2.75), codes(0.75, 0.25));
        assert_eq!(codes(0.0, 0.75), [25, 35, 45, 255], "opposite sides are neighbours");
        let within =
            |u, v| image.color_within(DVec2::new(u, v), NONE).map(|c| (c * 255.0).round() as u8);
        assert_eq!(within(0.25, 0.75), [10, 20, 30, 255]);
        assert_eq!(within(0.0, 1.0), [10, 20, 30, 255]);
        assert_eq!(within(7.0, -3.0), [100, 110, 120, 255], "the nearest pixel");
    }

    #[test]
    fn wide_footprints_are_means() {
        for side in [2, 5, 16, 63] {
            let image = checkers(side);
            let whole = image.color(DVec2::new(0.4, 0.1), [DVec2::X, DVec2::Y]);
            let mean = if side % 2 == 0 { 0.5 } else { 0.5 - 0.5 / f64::from(side * side) };
            assert!((f64::from(whole[0]) - mean).abs() < 0.02, "{side}: {whole:?}");
            assert!((whole[3] - 1.0).abs() < 1e-6);
        }
        // A long footprint across stripes is their mean; along a stripe, its colour.
        let rgba: Vec<u8> =
            (0..64 * 64).flat_map(|at| [255 * (at % 64 / 8 % 2) as u8, 0, 0, 255]).collect();
        let stripes = ImagePyramid::new(64, 64, &rgba);
        let middle = DVec2::new(12.0 / 64.0, 0.5);
        let narrow = 1.0 / 64.0;
        let across = stripes.color(middle, [DVec2::new(0.5, 0.0), DVec2::new(0.0, narrow)]);
        let along = stripes.color(middle, [DVec2::new(narrow, 0.0), DVec2::new(0.0, 0.2)]);
        assert!((across[0] - 0.5).abs() < 0.1, "{across:?}");
        assert!(along[0] > 0.97, "{along:?}");
    }

    #[test]
    fn transparent_pixels_have_no_colour() {
        let rgba = [255, 0, 0, 255, 0, 255, 0, 0];
        let image = ImagePyramid::new(2, 1, &rgba);
        let middle = image.color(DVec2::new(0.5, 0.5), NONE);
        assert!(middle[1] == 0.0 && (middle[0] - 0.5).abs() < 1e-6, "{middle:?}");
        assert!((middle[3] - 0.5).abs() < 1e-6);
    }
}
