//! Photographs at reduced size, and samples of pictures of their scenes.

use brood_brdf::Block;
use brood_eval::Level;
use brood_scene::{PictureSize, PixelArea, Raster, SampleSet, Sampling, Scene};
use brood_target::{KnownView, PixelStatus, ViewSetup, highlights};

use crate::analytic::LANES;

/// Number of pixels of all reduced pictures together, and their shortest side.
const PIXELS: u32 = 96 * 96;
const SIDE_PX: u32 = 40;
/// Largest number of reduced pixels in highlights, and number of rays of each.
const HIGHLIGHTS: usize = 256;
const RAYS: u16 = 16;
/// Distance from the object, in pixels, from which on pixels show the background alone.
const BESIDE: usize = 3;
/// Radiance below which a background is black, as a share of the median radiance of lit pixels.
const BLACK: f64 = 0.02;
/// Share of the background that may be brighter.
const BRIGHTER: f64 = 0.05;

/// A photograph at reduced size: each pixel is the mean of a square of pixels.
pub(super) struct Photograph {
    /// Index of the view.
    pub(super) view: usize,
    size_px: PictureSize,
    /// Pixels that count.
    pub(super) pixels: Vec<Seen>,
    /// Columns and rows of pixels in highlights of the stated scene, within which f differs.
    highlights: Vec<(u32, u32)>,
    /// Irradiance of red, green and blue at normal incidence: the median over the object.
    normal: [f64; 3],
}

/// A pixel that counts.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seen {
    /// Index in the reduced picture.
    at: usize,
    /// ln(1 + radiance / irradiance at normal incidence).
    wanted: [f64; 3],
    /// True if that is a lower bound.
    is_bound: bool,
}

/// Samples of a picture of a scene.
pub(super) struct Shot {
    blocks: Vec<Block<LANES>>,
    /// Pixel and irradiance of each sample.
    samples: Vec<(usize, [f64; 3])>,
}

impl Photograph {
    /// The photographs that are fitted.
    pub(super) fn all(views: &[KnownView]) -> Vec<Self> {
        let fitted = views.iter().enumerate().filter(|(_, view)| !view.setting.is_held_out);
        let fitted: Vec<(usize, &KnownView)> = fitted.collect();
        let pixels = f64::from(PIXELS) / fitted.len().max(1) as f64;
        fitted.into_iter().map(|(index, view)| Self::of(index, view, pixels)).collect()
    }

    fn of(index: usize, view: &KnownView, pixels: f64) -> Self {
        let whole = view.size_px();
        let ratio = (whole.pixels() as f64 / pixels).sqrt().ceil() as u32;
        let by = ratio.min(whole.shorter() / SIDE_PX).max(1);
        let size_px = PictureSize { width: whole.width / by, height: whole.height / by };
        let (width, by) = (whole.width as usize, by as usize);
        let known = &view.view;
        let uses_outline = has_black_background(view);
        let normal = normal_irradiance(view);
        let is_inside = |at: usize| known.statuses()[at] != PixelStatus::Background;
        let mut pixels = Vec::new();
        for at in 0..(size_px.width * size_px.height) as usize {
            let (row, column) = (at / size_px.width as usize, at % size_px.width as usize);
            let square = (0..by * by)
                .map(|k| (row * by + k / by) * width + column * by + k % by)
                .collect::<Vec<usize>>();
            let bound = |at: usize| known.lower_bound(at);
            let is_bound = square.iter().any(|at| bound(*at).is_some());
            let is_known = square.iter().all(|at| known.is_compared(*at) || bound(*at).is_some());
            let counts = uses_outline
                || is_deep(row * by + by / 2, column * by + by / 2, whole, by, &is_inside);
            if !is_known || !counts {
                continue;
            }
            let wanted = [0, 1, 2].map(|channel| {
                let radiance = |at: &usize| bound(*at).unwrap_or(known.target()[*at])[channel];
                let sum: f64 = square.iter().map(radiance).sum();
                logarithm((sum / square.len() as f64).max(0.0), normal[channel])
            });
            pixels.push(Seen { at, wanted, is_bound });
        }
        let ViewSetup { mesh, scene, assets, .. } = &view.setting;
        let stated = SampleSet::render_with_assets(&**mesh, scene, assets, raster(size_px));
        let is_highlight = highlights(&stated, HIGHLIGHTS);
        let places = (0..size_px.height).flat_map(|y| (0..size_px.width).map(move |x| (x, y)));
        let highlights = places.zip(is_highlight).filter(|(_, is_highlight)| *is_highlight);
        let highlights = highlights.map(|(place, _)| place).collect();
        Self { view: index, size_px, pixels, highlights, normal }
    }

    /// The logarithms to match, three per pixel.
    pub(super) fn wanted(&self) -> impl Iterator<Item = f64> + '_ {
        self.pixels.iter().flat_map(|seen| seen.wanted)
    }

    /// Samples a picture of a scene. The mesh and the assets are those of the view.
    pub(super) fn shot(&self, view: &KnownView, scene: &Scene) -> Shot {
        let (size_px, pixels) = (self.size_px, &self.highlights);
        let (mesh, assets) = (&*view.setting.mesh, &view.setting.assets);
        let all = SampleSet::render_with_assets(mesh, scene, assets, raster(size_px));
        let fine = SampleSet::render_pixels(mesh, scene, assets, (size_px, RAYS), pixels, None);
        let index = |(x, y): &(u32, u32)| (y * size_px.width + x) as usize;
        let of_fine: Vec<usize> = pixels.iter().map(index).collect();
        let (mut pairs, mut samples) = (Vec::new(), Vec::new());
        let mut add = |set: &SampleSet, place: &dyn Fn(usize) -> Option<usize>| {
            let layout = set.image().expect("the set has a picture layout");
            let scale = f64::from(layout.scale);
            for span in layout.spans() {
                let Some(pixel) = place(span.pixel as usize) else { continue };
                let range = span.radiance_start as usize..span.end as usize;
                pairs.extend_from_slice(set.pairs(range.clone()));
                samples.extend(range.map(|k| {
                    let irradiance = set.irradiance().map(|channel| scale * f64::from(channel[k]));
                    (pixel, irradiance)
                }));
            }
        };
        add(&all, &|pixel| of_fine.binary_search(&pixel).is_err().then_some(pixel));
        add(&fine, &|pixel| Some(of_fine[pixel]));
        let level = Level::best();
        let block = |pairs: &[_]| {
            let mut block = Block::new();
            block.fill(level, pairs);
            block
        };
        Shot { blocks: pairs.chunks(LANES).map(block).collect(), samples }
    }

    /// Residuals of a picture: three per pixel, in logarithms as in E_log. `f` gives the
    /// reflectance of a block, `balance` factors of brightness.
    pub(super) fn residuals(
        &self,
        shot: &Shot,
        mut f: impl FnMut(&Block<LANES>) -> [[f64; LANES]; 3],
        balance: [f64; 3],
    ) -> Vec<f64> {
        let mut radiance = vec![[0.0; 3]; self.size_px.pixels() as usize];
        for (block, samples) in shot.blocks.iter().zip(shot.samples.chunks(LANES)) {
            let f = f(block);
            for (lane, (pixel, irradiance)) in samples.iter().enumerate() {
                for channel in 0..3 {
                    let value = f[channel][lane];
                    let value = if value > 0.0 { value } else { 0.0 };
                    radiance[*pixel][channel] += value * irradiance[channel];
                }
            }
        }
        let mut residuals = Vec::with_capacity(3 * self.pixels.len());
        for seen in &self.pixels {
            for channel in 0..3 {
                let found = balance[channel] * radiance[seen.at][channel];
                let off = logarithm(found, self.normal[channel]) - seen.wanted[channel];
                residuals.push(if seen.is_bound { off.min(0.0) } else { off });
            }
        }
        residuals
    }
}

fn raster(size_px: PictureSize) -> Raster {
    Raster { size_px, sampling: Sampling::Adaptive, area: PixelArea::whole(size_px) }
}

/// ln(1 + radiance / irradiance); 0 for a channel without light.
fn logarithm(radiance: f64, irradiance: f64) -> f64 {
    if irradiance > 0.0 { libm::log1p(radiance / irradiance) } else { 0.0 }
}

/// True if the pixels around a place are all of the object.
fn is_deep(
    row: usize,
    column: usize,
    size_px: PictureSize,
    by: usize,
    is_inside: &impl Fn(usize) -> bool,
) -> bool {
    let (width, height) = (size_px.width as usize, size_px.height as usize);
    let near =
        |at: usize, side: usize| at.saturating_sub(BESIDE * by)..(at + BESIDE * by + 1).min(side);
    let columns = near(column, width);
    near(row, height).all(|row| columns.clone().all(|column| is_inside(row * width + column)))
}

/// True if the background beside the object is black, so that the outline shows where the object
/// ends.
fn has_black_background(view: &KnownView) -> bool {
    let known = &view.view;
    let size_px = view.size_px();
    let brightness = |at: usize| known.target()[at].iter().fold(0.0f64, |most, f| most.max(*f));
    let with = |status: PixelStatus| {
        let statuses = known.statuses().iter().enumerate();
        statuses.filter(move |(_, own)| **own == status).map(|(at, _)| at)
    };
    let mut lit: Vec<f64> = with(PixelStatus::Used).map(brightness).collect();
    lit.sort_by(f64::total_cmp);
    let is_outside =
        |at: usize| matches!(known.statuses()[at], PixelStatus::Background | PixelStatus::Masked);
    let width = size_px.width as usize;
    let beside: Vec<f64> = with(PixelStatus::Background)
        .filter(|at| is_deep(at / width, at % width, size_px, 1, &is_outside))
        .map(brightness)
        .collect();
    let Some(median) = lit.get(lit.len() / 2) else { return false };
    let bright = beside.iter().filter(|value| **value > BLACK * median).count();
    !beside.is_empty() && bright as f64 <= BRIGHTER * beside.len() as f64
}

/// Median irradiance at normal incidence over the points at the centres of pixels.
fn normal_irradiance(view: &KnownView) -> [f64; 3] {
    let set = view.view.set();
    let layout = set.image().expect("the set has a picture layout");
    let lit = layout.spans().filter(|span| span.centre_end > span.start);
    let lit: Vec<usize> = lit.map(|span| span.start as usize).collect();
    set.irradiance().map(|channel| {
        let mut all: Vec<f64> =
            lit.iter().map(|at| f64::from(channel[*at]) / set.pair(*at).0.cos_i()).collect();
        all.retain(|value| value.is_finite());
        all.sort_by(f64::total_cmp);
        all.get(all.len() / 2).copied().unwrap_or(0.0)
    })
}
