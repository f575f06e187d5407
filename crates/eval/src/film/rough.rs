//! Rough pixels: pixels that one sample per pixel cannot represent, because textures or highlights
//! are finer than a pixel.
//!
//! They are found in the developed picture: a pixel is rough if it differs from the mean of two
//! opposite neighbours. A linear gradient, however steep, has its mean in the middle and needs only
//! one sample. The choice depends only on the developed picture, so it is the same on every machine
//! and for every exact evaluator.

use brood_brdf::{InputMask, Level, SimdKernel};
use brood_program::Program;
use brood_scene::{PictureSize, PixelArea, SampleSet, Sampling};

use super::developed::Developed;
use crate::radiance::shade_each;

/// Largest difference in codes of a pixel from the mean of two opposite neighbours, in any channel,
/// that is not rough.
const ROUGH_CODES: u8 = 12;
/// Samples of a rough pixel: with 8 the mean error of 60 random materials is 1 % less, for half as
/// much work again.
const ROUGH_SAMPLES: u16 = 5;
/// Side of a tile in pixels: small enough that one rough spot costs little, large enough to be
/// cached with little overhead.
const TILE_PX: u32 = 32;
/// Smallest number of rough pixels that are evaluated together, except in the last batch.
const BATCH_PIXELS: usize = 512;
/// Number of bytes that are tested together without branches; most pictures have no rough pixels in
/// most places.
const CHUNK: usize = 64;

/// The rough pixels of a tile.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RoughTile {
    /// Index among the [`rough_tile_count`] tiles of the picture, row by row.
    pub number: usize,
    /// Area of the tile in the whole picture; besides the scene, its fine samples depend only on
    /// this.
    pub tile: PixelArea,
    /// Rough pixels in ascending order: index in the image of the set, and index in the tile.
    pub pixels: Vec<(u32, u32)>,
}

impl RoughTile {
    /// Number of samples of rough pixels.
    pub const SAMPLES: u16 = ROUGH_SAMPLES;
    /// Sampling of rough pixels.
    pub const SAMPLING: Sampling = Sampling::Fixed(ROUGH_SAMPLES);
}

/// Returns the number of tiles of a picture of that size.
#[must_use]
pub fn rough_tile_count(size_px: impl Into<PictureSize>) -> usize {
    let PictureSize { width, height } = size_px.into();
    width.div_ceil(TILE_PX) as usize * height.div_ceil(TILE_PX) as usize
}

/// The fine samples of the rough pixels of a program, evaluated together.
#[derive(Debug)]
pub struct FineSamples {
    /// Samples to evaluate.
    pub set: SampleSet,
    /// Pixels of the picture, in the order of the set's pixels.
    pixels: Vec<u32>,
}

impl FineSamples {
    /// Picks the samples of rough pixels from the sets of whole tiles, with the inputs that the
    /// program reads, in batches of whole tiles. The batches are small enough that the copied
    /// samples stay in cache.
    pub fn batches<'a>(
        rough: &'a [(&'a RoughTile, &'a SampleSet)],
        program: &Program,
    ) -> impl Iterator<Item = Self> + 'a {
        let (inputs, directions) = (program.inputs(), !program.layers().is_empty());
        let mut pixels = 0;
        let together = rough.chunk_by(move |(tile, _), _| {
            pixels = if pixels >= BATCH_PIXELS { 0 } else { pixels } + tile.pixels.len();
            pixels < BATCH_PIXELS
        });
        together.map(move |rough| Self::pick(rough, inputs, directions))
    }

    /// Picks the samples of some pixels of a picture, with the inputs that the program reads.
    /// `all`: samples of a row of pixels of the picture, and these pixels.
    ///
    /// # Domain
    /// Both lists of pixels ascend.
    ///
    /// # Panics
    /// If a pixel is not among all.
    #[must_use]
    pub fn of_pixels(all: (&SampleSet, &[u32]), pixels: &[u32], program: &Program) -> Self {
        let place = |pixel: &u32| {
            let place = all.1.binary_search(pixel).expect("the pixel is among all");
            u32::try_from(place).expect("fewer than 2^32 pixels")
        };
        let places: Vec<u32> = pixels.iter().map(place).collect();
        let (inputs, directions) = (program.inputs(), !program.layers().is_empty());
        let set = SampleSet::pick(&[(all.0, &places)], inputs, directions);
        Self { set, pixels: pixels.to_vec() }
    }

    /// Picks the samples of the rough pixels of some tiles; `directions` is true if the program has
    /// layers, which read directions.
    fn pick(rough: &[(&RoughTile, &SampleSet)], inputs: InputMask, directions: bool) -> Self {
        let indices = |tile: &RoughTile| tile.pixels.iter().map(|pixel| pixel.1).collect();
        let picked: Vec<Vec<u32>> = rough.iter().map(|(tile, _)| indices(tile)).collect();
        let parts = rough.iter().zip(&picked);
        let parts: Vec<(&SampleSet, &[u32])> =
            parts.map(|((_, set), picked)| (*set, picked.as_slice())).collect();
        let pixels = rough.iter().flat_map(|(tile, _)| &tile.pixels).map(|pixel| pixel.0);
        Self { set: SampleSet::pick(&parts, inputs, directions), pixels: pixels.collect() }
    }

    /// Returns the number of pixels.
    #[must_use]
    pub fn pixels(&self) -> u64 {
        self.pixels.len() as u64
    }

    /// Calls `put` with each pixel and its radiance, given the reflectance of the samples of the
    /// set.
    pub fn radiance(&self, f: &[f32], mut put: impl FnMut(usize, [f32; 3])) {
        let coverage = &self.set.image().expect("pixels were picked").coverage;
        // Pixels without samples are black.
        let mut fine = vec![[0.0; 3]; self.pixels.len()];
        shade_each(&self.set, f, |k, radiance| fine[k] = radiance);
        for ((pixel, radiance), coverage) in self.pixels.iter().zip(fine).zip(coverage.iter()) {
            // The centre of the pixel was hit, so coverage is 0 only in the finest of slits.
            if *coverage > 0.0 {
                put(*pixel as usize, radiance.map(|channel| channel / coverage));
            }
        }
    }
}

/// Returns the pixels that need more samples, by tile; empty if the picture is smooth or not
/// sampled adaptively.
///
/// Only fully covered pixels with one ray are considered: adaptive sampling has refined the edges
/// already.
///
/// # Panics
/// If the picture is not one of the set.
#[must_use]
pub fn rough_tiles(set: &SampleSet, developed: &Developed) -> Vec<RoughTile> {
    let layout = set.image().expect("the samples are those of a picture");
    let (width, height) = (layout.width as usize, layout.height as usize);
    assert_eq!(developed.rgba.len(), 4 * width * height, "the picture is one of the set");
    if layout.sampling != Sampling::Adaptive {
        return Vec::new();
    }
    let rough = Level::best().run(Search { width, height, rgba: &developed.rgba });
    tiles(set, &rough)
}

/// Returns the indices of the pixels that need more samples, in ascending order, of a picture whose
/// samples are not kept. `lone` is true for pixels with one ray.
///
/// # Panics
/// If `lone` has another number of pixels.
#[must_use]
pub fn rough_pixels(developed: &Developed, lone: &[bool]) -> Vec<u32> {
    let (width, height) = (developed.width as usize, developed.height as usize);
    assert_eq!(lone.len(), width * height, "one flag for each pixel");
    let mut rough = Level::best().run(Search { width, height, rgba: &developed.rgba });
    rough.retain(|pixel| lone[*pixel as usize]);
    rough
}

/// Kernel that finds all rough pixels of a picture in ascending order, including those at edges.
struct Search<'a> {
    width: usize,
    height: usize,
    rgba: &'a [u8],
}

impl SimdKernel for Search<'_> {
    type Output = Vec<u32>;

    #[inline(always)]
    fn run(self) -> Vec<u32> {
        let Self { width, height, rgba } = self;
        let mut rough = Vec::new();
        for y in 0..height {
            let row = |y: usize| &rgba[4 * y * width..4 * (y + 1) * width];
            let number = |x: usize| u32::try_from(y * width + x).expect("fewer than 2^32 pixels");
            let before = rough.len();
            if width > 2 {
                let inner = 4 * (width - 2);
                let rows = [&row(y)[..inner], &row(y)[4..4 + inner], &row(y)[8..]];
                find(rows, |x| rough.push(number(x + 1)));
            }
            if y > 0 && y + 1 < height {
                find([row(y - 1), row(y), row(y + 1)], |x| rough.push(number(x)));
            }
            // The part holds two ascending runs, which a stable sort merges.
            rough[before..].sort();
        }
        rough.dedup();
        rough
    }
}

/// Calls `found` with the pixels of the middle row that differ from the mean of those before and
/// after them, all three opaque.
#[inline(always)]
fn find([before, middle, after]: [&[u8]; 3], mut found: impl FnMut(usize)) {
    let length = middle.len();
    for start in (0..length).step_by(CHUNK) {
        let end = length.min(start + CHUNK);
        let chunks = [&before[start..end], &middle[start..end], &after[start..end]];
        let hits = match chunks.map(|chunk| chunk.first_chunk::<CHUNK>()) {
            [Some(before), Some(middle), Some(after)] => far_from_mean(before, middle, after),
            _ => {
                // At the end of a row the missing bytes are equal and so never rough.
                let mut rest = [[0; CHUNK]; 3];
                for (rest, chunk) in rest.iter_mut().zip(chunks) {
                    rest[..chunk.len()].copy_from_slice(chunk);
                }
                far_from_mean(&rest[0], &rest[1], &rest[2])
            }
        };
        if hits.iter().fold(0, |any, hit| any | hit) != 0 {
            hits.iter().enumerate().filter(|(_, hit)| **hit != 0).for_each(|(x, _)| {
                found(start / 4 + x);
            });
        }
    }
}

/// Returns for each pixel 0 if it is near the mean of those before and after it in every channel,
/// or one of the three is not opaque.
#[inline(always)]
fn far_from_mean(
    before: &[u8; CHUNK],
    middle: &[u8; CHUNK],
    after: &[u8; CHUNK],
) -> [u32; CHUNK / 4] {
    let mut excess = [0; CHUNK];
    for k in 0..CHUNK {
        let mean = ((u16::from(before[k]) + u16::from(after[k]) + 1) >> 1) as u8;
        // One of the two differences is 0; saturating bytes stay bytes in vector registers.
        let difference = mean.saturating_sub(middle[k]) | middle[k].saturating_sub(mean);
        excess[k] = difference.saturating_sub(ROUGH_CODES);
    }
    // One word per pixel: red is its lowest byte, alpha its highest.
    let words = |bytes: &[u8; CHUNK]| {
        let mut words = [0; CHUNK / 4];
        for (word, bytes) in words.iter_mut().zip(bytes.as_chunks::<4>().0) {
            *word = u32::from_le_bytes(*bytes);
        }
        words
    };
    let (mut hits, before, middle, after) =
        (words(&excess), words(before), words(middle), words(after));
    for (x, hit) in hits.iter_mut().enumerate() {
        let opaque = before[x] & middle[x] & after[x] >= 0xff00_0000;
        *hit = if opaque { *hit } else { 0 };
    }
    hits
}

/// Groups those of the ascending pixels that are fully covered and have one ray by tile.
fn tiles(set: &SampleSet, rough: &[u32]) -> Vec<RoughTile> {
    let layout = set.image().expect("the samples are those of a picture");
    let columns = layout.size_px.width.div_ceil(TILE_PX);
    let mut tiles: Vec<RoughTile> = Vec::new();
    // Index in `tiles`, by the number of the tile.
    let mut slots = vec![usize::MAX; rough_tile_count(layout.size_px)];
    let mut runs = layout.runs.iter().peekable();
    for pixel in rough {
        while runs.next_if(|run| run.pixel + run.pixels <= *pixel).is_some() {}
        // Covered, lit, and sampled by the ray through the centre only.
        let single = runs
            .peek()
            .is_some_and(|run| run.pixel <= *pixel && run.centre > 0 && run.samples == run.centre);
        if !single {
            continue;
        }
        let x = layout.area.x + pixel % layout.width;
        let y = layout.area.y + pixel / layout.width;
        let (left, top) = (x - x % TILE_PX, y - y % TILE_PX);
        let number = (y / TILE_PX * columns + x / TILE_PX) as usize;
        let slot = &mut slots[number];
        if *slot == usize::MAX {
            *slot = tiles.len();
            let width = TILE_PX.min(layout.size_px.width - left);
            let height = TILE_PX.min(layout.size_px.height - top);
            let tile = PixelArea { x: left, y: top, width, height };
            tiles.push(RoughTile { number, tile, pixels: Vec::new() });
        }
        let RoughTile { tile, pixels, .. } = &mut tiles[*slot];
        pixels.push((*pixel, (y - top) * tile.width + (x - left)));
    }
    tiles
}

#[cfg(test)]
mod tests {
    use brood_light::Light;
    use brood_mesh::{BuiltinMesh, Mesh};
    use brood_scene::Scene;

    use super::*;

    /// Returns the rough pixels of a picture of a sphere with these codes, as columns and rows.
    fn rough(size_px: u32, code: impl Fn(u32, u32) -> u8) -> Vec<(u32, u32)> {
        let mesh = Mesh::builtin(BuiltinMesh::Sphere);
        let set = SampleSet::render(&mesh, &Scene::default(), size_px, Sampling::Adaptive);
        let coverage = &set.image().unwrap().coverage;
        let pixel = |k: u32| {
            let c = code(k % size_px, k / size_px);
            [c, c / 2, 0, (coverage[k as usize] * 255.0 + 0.5) as u8]
        };
        let rgba = (0..size_px * size_px).flat_map(pixel).collect();
        let picture = Developed { width: size_px, height: size_px, rgba, exposure_ev: 0.0 };
        let tiles = rough_tiles(&set, &picture);
        for RoughTile { tile, pixels, number } in &tiles {
            assert!(*number < rough_tile_count(size_px));
            assert!(pixels.is_sorted_by(|a, b| a < b) && tile.is_within(size_px));
            for (pixel, of_tile) in pixels {
                let x = tile.x + of_tile % tile.width;
                assert_eq!((x, tile.y + of_tile / tile.width), (pixel % size_px, pixel / size_px));
            }
        }
        let mut all: Vec<u32> = tiles.iter().flat_map(|tile| &tile.pixels).map(|p| p.0).collect();
        all.sort_unstable();
        all.into_iter().map(|pixel| (pixel % size_px, pixel / size_px)).collect()
    }

    #[test]
    fn linear_gradients_are_not_rough_however_steep() {
        assert_eq!(rough(80, |x, _| (x * 3) as u8), []);
        assert_eq!(rough(80, |x, y| (x + 2 * y) as u8), []);
    }

    #[test]
    fn line_and_its_neighbours_are_rough_when_the_difference_is_large() {
        let line = |height: u8| rough(80, move |x, _| if x == 40 { 100 + height } else { 100 });
        assert_eq!(line(12), []);
        let columns: Vec<u32> = line(14).iter().map(|(x, _)| *x).collect();
        assert!(columns.len() > 20 && columns.iter().all(|x| *x == 40), "{columns:?}");
        let columns: Vec<u32> = line(100).iter().map(|(x, _)| *x).collect();
        assert!(
            (39..=41).all(|x| columns.contains(&x))
                && columns.iter().all(|x| (39..=41).contains(x))
        );
    }

    #[test]
    fn rough_pixels_match_the_definition_up_to_the_edges() {
        let size_px = 77;
        let code = |x: u32, y: u32| ((x * x * 7 + y * 31 + x * y) % 97) as u8 * 2;
        let found = rough(size_px, code);
        let mesh = Mesh::builtin(BuiltinMesh::Sphere);
        let set = SampleSet::render(&mesh, &Scene::default(), size_px, Sampling::Adaptive);
        let layout = set.image().unwrap();
        let single: Vec<u32> = layout
            .runs
            .iter()
            .filter(|run| run.centre > 0 && run.samples == run.centre)
            .flat_map(|run| run.pixel..run.pixel + run.pixels)
            .collect();
        let opaque = |x: u32, y: u32| layout.coverage[(y * size_px + x) as usize] > 0.999;
        let off = |a: (u32, u32), b: (u32, u32), c: (u32, u32)| {
            let channel = |divide: u8| {
                let [a, b, c] = [a, b, c].map(|(x, y)| i32::from(code(x, y) / divide));
                ((a + c + 1) / 2 - b).abs() > 12
            };
            [a, b, c].iter().all(|(x, y)| opaque(*x, *y)) && (channel(1) || channel(2))
        };
        let expected: Vec<(u32, u32)> = single
            .into_iter()
            .map(|pixel| (pixel % size_px, pixel / size_px))
            .filter(|(x, y)| {
                let inside = |v: u32| v > 0 && v + 1 < size_px;
                (inside(*x) && off((x - 1, *y), (*x, *y), (x + 1, *y)))
                    || (inside(*y) && off((*x, y - 1), (*x, *y), (*x, y + 1)))
            })
            .collect();
        assert!(expected.len() > 500, "{}", expected.len());
        assert_eq!(found, expected);
    }

    #[test]
    fn fine_samples_match_those_of_whole_tiles_in_any_batching_and_dark_pixels_stay_dark() {
        let (mesh, size_px) = (Mesh::builtin(BuiltinMesh::Sphere), 77);
        let lights = vec![Light::point_at([5.0, 0.0, 0.0])];
        let scene = Scene { lights, ..Scene::default() };
        let all = |tile: PixelArea| {
            let own = (0..tile.width * tile.height).map(move |own| {
                let (x, y) = (tile.x + own % tile.width, tile.y + own / tile.width);
                (y * size_px + x, own)
            });
            own.collect()
        };
        let corners = [(0, 0), (32, 0), (0, 32), (32, 32), (64, 64)];
        let rough: Vec<RoughTile> = corners
            .map(|(x, y)| {
                let tile =
                    PixelArea { x, y, width: 32.min(size_px - x), height: 32.min(size_px - y) };
                RoughTile { number: 0, tile, pixels: all(tile) }
            })
            .into();
        let fine: Vec<SampleSet> = rough
            .iter()
            .map(|rough| {
                let RoughTile { tile, .. } = *rough;
                SampleSet::render_area(&mesh, &scene, size_px, RoughTile::SAMPLING, tile)
            })
            .collect();
        let parts: Vec<_> = rough.iter().zip(&fine).collect();
        let white = |set: &SampleSet| vec![1.0; 3 * set.len()];
        let mut found = Vec::new();
        let mut batches = 0;
        let program =
            Program::lower(&"brood 1\n.model lambert\n".parse::<brood_genome::Genome>().unwrap());
        for batch in FineSamples::batches(&parts, &program) {
            batches += 1;
            assert!(batch.pixels() < (BATCH_PIXELS + 32 * 32) as u64);
            batch.radiance(&white(&batch.set), |pixel, radiance| found.push((pixel, radiance)));
        }
        assert!(batches > 2, "{batches}");
        let mut expected = Vec::new();
        for (rough, fine) in &parts {
            let image = crate::shade(fine, &white(fine));
            for (pixel, own) in &rough.pixels {
                let (own, coverage) = (*own as usize, image.coverage()[*own as usize]);
                let radiance = image.premultiplied()[own].map(|channel| channel / coverage);
                expected.extend((coverage > 0.0).then_some((*pixel as usize, radiance)));
            }
        }
        assert_eq!(found, expected);
        let dark = found.iter().filter(|(_, radiance)| *radiance == [0.0; 3]).count();
        assert!(dark > 500 && dark < found.len() - 500, "{dark} of {}", found.len());
    }
}
