//! Pixels of a material that one sample does not do justice: textures and highlights finer than a pixel.
//!
//! Which they are is seen in the developed picture: where colours do not go on evenly from the one neighbour to the other.
//! An even slope, however steep, has its mean in the middle, so one sample is right there. What is rough depends on the
//! picture alone: it is the same whatever else is rendered, on every machine and by every exact evaluator.

use brood_brdf::InputMask;
use brood_program::Program;
use brood_scene::{PixelArea, SampleSet, Sampling};

use super::Developed;
use crate::Level;
use crate::canonical::Work;
use crate::radiance::shade_each;

/// A pixel that is off the mean of two opposite neighbours by more codes than this, in any channel, is rough.
const ROUGH_CODES: u8 = 12;
/// Samples of a rough pixel: with 8 the error of 60 random materials is 1 % less in the mean, for half as much work again.
const ROUGH_SAMPLING: Sampling = Sampling::Fixed(5);
/// Side of a tile in pixels: small enough that one rough spot costs little, large enough to be kept with little overhead.
const TILE_PX: u32 = 32;
/// Rough pixels that are evaluated together at least, where there are as many.
const BATCH_PIXELS: usize = 512;
/// Bytes that are looked at together, without branches: most pictures have nothing to find in most places.
const CHUNK: usize = 64;

/// The rough pixels of a tile.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RoughTile {
    /// Which of the [`rough_tile_count`] tiles of the picture it is, row by row.
    pub number: usize,
    /// Where it is in the whole picture: what its fine samples depend on besides the scene.
    pub tile: PixelArea,
    /// Its rough pixels, in ascending order: the number in the set's image, and the number in the tile.
    pub pixels: Vec<(u32, u32)>,
}

impl RoughTile {
    /// How its pixels are sampled again.
    pub const SAMPLING: Sampling = ROUGH_SAMPLING;
}

/// Tiles of a square picture of that side.
#[must_use]
pub fn rough_tile_count(size_px: u32) -> usize {
    (size_px.div_ceil(TILE_PX) as usize).pow(2)
}

/// The fine samples of a program's rough pixels, evaluated together.
#[derive(Debug)]
pub struct FineSamples {
    /// What is to be evaluated.
    pub set: SampleSet,
    /// The picture's pixels, in the order of the set's.
    pixels: Vec<u32>,
}

impl FineSamples {
    /// Takes the samples of rough pixels out of the sets of whole tiles, with what the program reads of them. There are as
    /// many batches as keep what is copied in a near cache.
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

    fn pick(rough: &[(&RoughTile, &SampleSet)], inputs: InputMask, directions: bool) -> Self {
        let of_tile = |tile: &RoughTile| tile.pixels.iter().map(|pixel| pixel.1).collect();
        let wanted: Vec<Vec<u32>> = rough.iter().map(|(tile, _)| of_tile(tile)).collect();
        let parts = rough.iter().zip(&wanted);
        let parts: Vec<(&SampleSet, &[u32])> =
            parts.map(|((_, set), wanted)| (*set, wanted.as_slice())).collect();
        let pixels = rough.iter().flat_map(|(tile, _)| &tile.pixels).map(|pixel| pixel.0);
        Self { set: SampleSet::pick(&parts, inputs, directions), pixels: pixels.collect() }
    }

    /// How many pixels.
    #[must_use]
    pub fn pixels(&self) -> u64 {
        self.pixels.len() as u64
    }

    /// Calls back with each pixel and its radiance, from the reflectance of the set's samples.
    pub fn radiance(&self, f: &[f32], mut put: impl FnMut(usize, [f32; 3])) {
        let coverage = &self.set.image().expect("pixels were picked").coverage;
        // Who has no samples is in the dark.
        let mut fine = vec![[0.0; 3]; self.pixels.len()];
        shade_each(&self.set, f, |k, radiance| fine[k] = radiance);
        for ((pixel, radiance), coverage) in self.pixels.iter().zip(fine).zip(coverage.iter()) {
            // Its centre hit, so this is 0 for nothing but the finest of slits.
            if *coverage > 0.0 {
                put(*pixel as usize, radiance.map(|channel| channel / coverage));
            }
        }
    }
}

/// The pixels that should get more samples, by tile; none where the picture is smooth or not sampled adaptively.
///
/// Only pixels that are covered whole and have one ray are looked at: edges have been taken care of.
///
/// # Panics
/// Where the picture is not one of the set.
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

/// A picture whose rough pixels are wanted, in ascending order, edges and all.
struct Search<'a> {
    width: usize,
    height: usize,
    rgba: &'a [u8],
}

impl Work for Search<'_> {
    type Done = Vec<u32>;

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
                let beside = [&row(y)[..inner], &row(y)[4..4 + inner], &row(y)[8..]];
                find(beside, |x| rough.push(number(x + 1)));
            }
            if y > 0 && y + 1 < height {
                find([row(y - 1), row(y), row(y + 1)], |x| rough.push(number(x)));
            }
            // Two ascending runs, which a stable sort merges.
            rough[before..].sort();
        }
        rough.dedup();
        rough
    }
}

/// Calls back with the pixels of the middle row that are off the mean of those before and after them, all three opaque.
#[inline(always)]
fn find([before, middle, after]: [&[u8]; 3], mut found: impl FnMut(usize)) {
    let length = middle.len();
    for start in (0..length).step_by(CHUNK) {
        let end = length.min(start + CHUNK);
        let chunks = [&before[start..end], &middle[start..end], &after[start..end]];
        let hits = match chunks.map(|chunk| chunk.first_chunk::<CHUNK>()) {
            [Some(before), Some(middle), Some(after)] => off_mean(before, middle, after),
            _ => {
                // The end of a row: what is not there is even.
                let mut rest = [[0; CHUNK]; 3];
                for (rest, chunk) in rest.iter_mut().zip(chunks) {
                    rest[..chunk.len()].copy_from_slice(chunk);
                }
                off_mean(&rest[0], &rest[1], &rest[2])
            }
        };
        if hits.iter().fold(0, |any, hit| any | hit) != 0 {
            hits.iter().enumerate().filter(|(_, hit)| **hit != 0).for_each(|(x, _)| {
                found(start / 4 + x);
            });
        }
    }
}

/// For each pixel: 0 where it is near the mean of those before and after it in every channel, or one of them is not opaque.
#[inline(always)]
fn off_mean(before: &[u8; CHUNK], middle: &[u8; CHUNK], after: &[u8; CHUNK]) -> [u32; CHUNK / 4] {
    let mut off = [0; CHUNK];
    for k in 0..CHUNK {
        let mean = ((u16::from(before[k]) + u16::from(after[k]) + 1) >> 1) as u8;
        // The two differences, one of them 0: saturating bytes stay bytes in vector registers.
        let apart = mean.saturating_sub(middle[k]) | middle[k].saturating_sub(mean);
        off[k] = apart.saturating_sub(ROUGH_CODES);
    }
    let words = |bytes: &[u8; CHUNK]| {
        let mut words = [0; CHUNK / 4];
        for (word, bytes) in words.iter_mut().zip(bytes.as_chunks::<4>().0) {
            *word = u32::from_le_bytes(*bytes);
        }
        words
    };
    let (mut hits, before, middle, after) =
        (words(&off), words(before), words(middle), words(after));
    for (x, hit) in hits.iter_mut().enumerate() {
        let opaque = before[x] & middle[x] & after[x] >= 0xff00_0000;
        *hit = if opaque { *hit } else { 0 };
    }
    hits
}

/// Those of the ascending pixels that are covered whole and have one ray, by tile.
fn tiles(set: &SampleSet, rough: &[u32]) -> Vec<RoughTile> {
    let layout = set.image().expect("the samples are those of a picture");
    let columns = layout.size_px.div_ceil(TILE_PX);
    let mut tiles: Vec<RoughTile> = Vec::new();
    let mut slots = vec![usize::MAX; rough_tile_count(layout.size_px)];
    let mut runs = layout.runs.iter().peekable();
    for pixel in rough {
        while runs.next_if(|run| run.pixel + run.pixels <= *pixel).is_some() {}
        let alone = runs
            .peek()
            .is_some_and(|run| run.pixel <= *pixel && run.centre > 0 && run.samples == run.centre);
        if !alone {
            continue;
        }
        let x = layout.area.x + pixel % layout.width;
        let y = layout.area.y + pixel / layout.width;
        let (left, top) = (x - x % TILE_PX, y - y % TILE_PX);
        let number = (y / TILE_PX * columns + x / TILE_PX) as usize;
        let slot = &mut slots[number];
        if *slot == usize::MAX {
            *slot = tiles.len();
            let width = TILE_PX.min(layout.size_px - left);
            let height = TILE_PX.min(layout.size_px - top);
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
    use brood_scene::{BuiltinMesh, Light, Mesh, Scene};

    use super::*;

    /// A picture of a sphere with these codes, and the rough pixels as columns and rows.
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
    fn even_slopes_are_not_rough_however_steep() {
        assert_eq!(rough(80, |x, _| (x * 3) as u8), []);
        assert_eq!(rough(80, |x, y| (x + 2 * y) as u8), []);
    }

    #[test]
    fn line_is_rough_with_what_is_beside_it_as_far_as_it_is_off() {
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
    fn rough_pixels_are_those_of_the_definition_up_to_the_edges() {
        let size_px = 77;
        let code = |x: u32, y: u32| ((x * x * 7 + y * 31 + x * y) % 97) as u8 * 2;
        let found = rough(size_px, code);
        let mesh = Mesh::builtin(BuiltinMesh::Sphere);
        let set = SampleSet::render(&mesh, &Scene::default(), size_px, Sampling::Adaptive);
        let layout = set.image().unwrap();
        let alone: Vec<u32> = layout
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
        let expected: Vec<(u32, u32)> = alone
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
    fn fine_samples_are_those_of_the_tiles_however_they_are_batched_and_dark_pixels_stay_dark() {
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
