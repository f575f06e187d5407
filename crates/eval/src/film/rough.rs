//! Pixels of a material that one sample does not do justice: textures and highlights finer than a pixel.
//!
//! Which they are is seen in the developed picture: next to a pixel that looks quite different. It depends on the picture
//! alone, so that it is the same whatever else is rendered, on every machine and by every exact evaluator.

use brood_scene::{PixelArea, SampleSet, Sampling};

use super::Developed;

/// Samples of a rough pixel.
pub const ROUGH_SAMPLING: Sampling = Sampling::Fixed(8);
/// Neighbours that differ by more codes than this, in any channel, are rough.
const ROUGH_CODES: u8 = 20;
/// Side of a tile in pixels: small enough that one rough spot costs little, large enough to be kept with little overhead.
const TILE_PX: u32 = 32;

/// The rough pixels of a tile.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RoughTile {
    /// Where it is in the whole picture: what its fine samples depend on besides the scene.
    pub tile: PixelArea,
    /// Its rough pixels, in ascending order: the number in the set's image, and the number in the tile.
    pub pixels: Vec<(u32, u32)>,
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
    let mut rough = vec![false; width * height];
    let mut any = false;
    let pixels = developed.rgba.as_chunks::<4>().0;
    for y in 0..height {
        let row = &pixels[y * width..(y + 1) * width];
        // Whole rows first, in a loop without branches: most pictures have nothing to find in most of them.
        let beside = row.iter().zip(&row[1..]).any(|(a, b)| differ(a, b));
        let below = pixels.get((y + 1) * width..(y + 2) * width);
        let under = below.is_some_and(|below| row.iter().zip(below).any(|(a, b)| differ(a, b)));
        if !beside && !under {
            continue;
        }
        any = true;
        for x in 0..width {
            let at = y * width + x;
            if x + 1 < width && differ(&row[x], &row[x + 1]) {
                rough[at] = true;
                rough[at + 1] = true;
            }
            if let Some(below) = below
                && differ(&row[x], &below[x])
            {
                rough[at] = true;
                rough[at + width] = true;
            }
        }
    }
    if !any { Vec::new() } else { tiles(set, &rough) }
}

/// Both opaque, and of quite different colours.
#[inline(always)]
fn differ(a: &[u8; 4], b: &[u8; 4]) -> bool {
    let apart = |channel: usize| a[channel].abs_diff(b[channel]) > ROUGH_CODES;
    (a[3] & b[3] == 255) & (apart(0) | apart(1) | apart(2))
}

fn tiles(set: &SampleSet, rough: &[bool]) -> Vec<RoughTile> {
    let layout = set.image().expect("the samples are those of a picture");
    let columns = layout.size_px.div_ceil(TILE_PX);
    let mut tiles: Vec<RoughTile> = Vec::new();
    let mut slots = vec![usize::MAX; (columns * columns) as usize];
    for run in layout.runs.iter().filter(|run| run.centre > 0 && run.samples == run.centre) {
        for pixel in run.pixel..run.pixel + run.pixels {
            if !rough[pixel as usize] {
                continue;
            }
            let x = layout.area.x + pixel % layout.width;
            let y = layout.area.y + pixel / layout.width;
            let (left, top) = (x - x % TILE_PX, y - y % TILE_PX);
            let slot = &mut slots[(y / TILE_PX * columns + x / TILE_PX) as usize];
            if *slot == usize::MAX {
                *slot = tiles.len();
                let width = TILE_PX.min(layout.size_px - left);
                let height = TILE_PX.min(layout.size_px - top);
                let tile = PixelArea { x: left, y: top, width, height };
                tiles.push(RoughTile { tile, pixels: Vec::new() });
            }
            let RoughTile { tile, pixels } = &mut tiles[*slot];
            pixels.push((pixel, (y - top) * tile.width + (x - left)));
        }
    }
    tiles
}
