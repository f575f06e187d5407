//! Sampling of a picture: rows in parallel, concatenated in order.

use brood_brdf::Lighting;
use brood_light::{LightAssets, LightSampler};
use brood_mesh::Mesh;
use brood_mesh::trace::Stack;
use glam::DVec2;
use rayon::prelude::*;

use super::cluster::Groups;
use super::fixed::{Row, fixed_pixel, fixed_row};
use super::layout::{ImageLayout, PixelRun, SampleCounts};
use super::normal_map::MappedNormals;
use super::paint::push_groups;
use super::paint_point::PaintBuffer;
use super::point::{PixelFeatures, SampleBuffer, Surface, SurfacePoint};
use super::quadrature::{PixelSampler, Scratch};
use super::sampling::{PixelArea, Raster, Sampling};
use super::set::SampleSet;
use super::size::PictureSize;
use super::view::{View, subpixel_offsets};
use crate::description::Scene;
use crate::prefiltered::{
    DirectLight, Facing, LitPoint, LobeShape, PrefilteredLight, groups as similar_points,
};
use crate::stage::Stage;

/// Number of rays of listed pixels that a thread traces at a time.
const RAYS_TOGETHER: usize = 512;
/// Largest number of rows, or of chunks of rays, that a thread takes at once. Rows differ in cost,
/// so a larger number lets threads wait.
pub(super) const ROWS: usize = 4;
/// Difference of `shade` between a pixel's mean and its centre above which a smooth pixel is
/// curved.
const CURVED_THRESHOLD: f32 = 2e-4;

/// Rays through the pixel centres of a row of the area with a border of one pixel.
struct CentreRow {
    features: Vec<PixelFeatures>,
    /// Samples of the pixels in the area.
    buffer: SampleBuffer,
    /// Number of samples of each pixel in the area.
    lit: Vec<u32>,
    unlit: (u64, u64),
    /// Surface points of the pixels in the area, if they are kept.
    facing: Vec<Option<Facing>>,
}

impl SampleSet {
    /// Samples a picture of `mesh` in `scene`. The mesh reference in `scene` is ignored.
    ///
    /// # Domain
    /// A scene that [`Scene::validate`] accepts; otherwise the set is meaningless. Lights that
    /// refer to assets emit nothing.
    ///
    /// # Panics
    /// If a side is not in 1..=65535, the fixed number of samples is 0, or the set would have
    /// 2^32 samples.
    ///
    /// # Error
    /// Bit-identical for any number of threads.
    #[must_use]
    pub fn render(
        mesh: &Mesh,
        scene: &Scene,
        size_px: impl Into<PictureSize>,
        sampling: impl Into<Sampling>,
    ) -> Self {
        let size_px = size_px.into();
        Self::render_area(mesh, scene, size_px, sampling, PixelArea::whole(size_px))
    }

    /// Samples a part of that picture, bit-identical to these pixels of the whole picture.
    ///
    /// # Panics
    /// As [`SampleSet::render`], and if the area is empty or not within the picture.
    #[must_use]
    pub fn render_area(
        mesh: &Mesh,
        scene: &Scene,
        size_px: impl Into<PictureSize>,
        sampling: impl Into<Sampling>,
        area: PixelArea,
    ) -> Self {
        let raster = Raster { size_px: size_px.into(), sampling: sampling.into(), area };
        Self::render_with_assets(mesh, scene, &LightAssets::default(), raster)
    }

    /// Samples a scene whose lights refer to assets. A light whose asset is missing emits nothing.
    ///
    /// # Panics
    /// As [`SampleSet::render_area`].
    #[must_use]
    pub fn render_with_assets<'a>(
        stage: impl Into<Stage<'a>>,
        scene: &Scene,
        assets: &LightAssets,
        raster: Raster,
    ) -> Self {
        let sampler = pixel_sampler(&stage.into(), scene, assets, raster.size_px);
        Self::render_with(&sampler, raster).0
    }

    /// Samples a scene, but replaces the samples of environments by at most [`LobeShape::samples`]
    /// directions of mean radiance per surface point, which have no noise.
    ///
    /// # Domain
    /// Scenes with [`Scene::is_prefilterable`]; materials whose lobes have the shape.
    ///
    /// # Panics
    /// As [`SampleSet::render_area`].
    #[must_use]
    pub fn render_direct<'a>(
        stage: impl Into<Stage<'a>>,
        scene: &Scene,
        assets: &LightAssets,
        raster: Raster,
        lobes: LobeShape,
    ) -> Self {
        let sampler = direct_sampler((&stage.into(), scene, assets), raster.size_px, Some(lobes));
        Self::render_with(&sampler, raster).0
    }

    /// Samples a scene without its environments, whose light is prefiltered instead.
    ///
    /// # Domain
    /// Adaptive sampling, and scenes with [`Scene::is_prefilterable`]. Only for isotropic
    /// homogeneous materials.
    ///
    /// # Panics
    /// As [`SampleSet::render_area`], and if the sampling is fixed.
    #[must_use]
    pub fn render_prefiltered<'a>(
        stage: impl Into<Stage<'a>>,
        scene: &Scene,
        assets: &LightAssets,
        raster: Raster,
    ) -> (Self, PrefilteredLight) {
        assert!(raster.sampling == Sampling::Adaptive, "fixed sampling samples all lights");
        let mut sampler = pixel_sampler(&stage.into(), scene, assets, raster.size_px);
        sampler.keeps_points = true;
        let environments = sampler.surface.take_environments();
        let (set, points) = Self::render_with(&sampler, raster);
        let points_of = |area: PixelArea| match area == raster.area {
            true => points,
            false => Self::render_with(&sampler, Raster { area, ..raster }).1,
        };
        (set, PrefilteredLight::of_picture(raster, environments, points_of))
    }

    pub(super) fn render_with(sampler: &PixelSampler<'_>, raster: Raster) -> (Self, Vec<LitPoint>) {
        let Raster { size_px, sampling, area } = raster;
        assert!(
            size_px.longer() <= u32::from(u16::MAX),
            "`size_px` must be in 1..=65535, got {size_px}"
        );
        assert!(
            area.is_within(size_px),
            "the area {area} must be non-empty and within {} x {} pixels",
            size_px.width,
            size_px.height
        );
        let (mut rows, scale) = match sampling {
            Sampling::Adaptive => (adaptive(sampler, area), 1.0),
            Sampling::Fixed(samples) => {
                let offsets = subpixel_offsets(u32::from(samples));
                let rows = (0..area.height)
                    .into_par_iter()
                    .with_max_len(ROWS)
                    .map_init(Scratch::default, |scratch, row| {
                        fixed_row(sampler, area, row, &offsets, scratch)
                    })
                    .collect();
                (rows, 1.0 / offsets.len() as f32)
            }
        };
        let image = ImageLayout {
            width: area.width,
            height: area.height,
            size_px,
            area,
            sampling,
            scale,
            runs: Vec::new(),
            coverage: Vec::new().into(),
        };
        let points = rows.iter_mut().flat_map(|row| std::mem::take(&mut row.points)).collect();
        let (set, painted) = concatenate(rows, image);
        let set = match &sampler.painted {
            Some(_) => {
                let lights = sampler.surface.lights.len();
                let lighting = Lighting { lights, has_shadows: sampler.surface.has_shadows() };
                let mut set = set.with_lights(lighting, painted.columns(lighting));
                set.footprints = painted.footprints;
                set.seen = painted.seen;
                set
            }
            None => set,
        };
        (set, points)
    }

    /// Samples some pixels of that picture, columns and rows, each with at least `samples` rays, as
    /// an image of one row. With `lobes`, environments are as in [`SampleSet::render_direct`].
    ///
    /// # Panics
    /// As [`SampleSet::render`], and if a pixel is not in the picture.
    #[must_use]
    pub fn render_pixels<'a>(
        stage: impl Into<Stage<'a>>,
        scene: &Scene,
        assets: &LightAssets,
        (size_px, samples): (PictureSize, u16),
        pixels: &[(u32, u32)],
        lobes: Option<LobeShape>,
    ) -> Self {
        size_px.assert_holds(pixels);
        let sampler = direct_sampler((&stage.into(), scene, assets), size_px, lobes);
        let offsets = subpixel_offsets(u32::from(samples));
        let together = (RAYS_TOGETHER / offsets.len()).max(1);
        let width = u32::try_from(pixels.len()).expect("a picture has fewer than 2^32 pixels");
        let rows = pixels
            .par_chunks(together)
            .zip((0..width).into_par_iter().step_by(together))
            .with_max_len(ROWS)
            .map_init(Scratch::default, |scratch, (pixels, first)| {
                let mut out = Row::default();
                for (index, pixel) in (first..).zip(pixels) {
                    fixed_pixel(&sampler, *pixel, &offsets, scratch, (index, &mut out));
                }
                out
            })
            .collect();
        let image = ImageLayout {
            width,
            height: 1,
            size_px,
            area: PixelArea { x: 0, y: 0, width, height: 1 },
            sampling: Sampling::Fixed(samples),
            scale: 1.0 / offsets.len() as f32,
            runs: Vec::new(),
            coverage: Vec::new().into(),
        };
        concatenate(rows, image).0
    }
}

/// Returns the sampler of a part of a scene.
pub(super) fn pixel_sampler<'a>(
    stage: &Stage<'a>,
    scene: &Scene,
    assets: &LightAssets,
    size_px: PictureSize,
) -> PixelSampler<'a> {
    let frame = stage.frame(scene);
    let lights = LightSampler::all(&scene.lights, scene.light_deg, assets, &frame);
    let view = View::new(&scene.camera, &frame, size_px);
    let mut surface = Surface::new(stage, lights, scene);
    let map = scene.normal_map_of(stage.part());
    surface.mapped = MappedNormals::new(map, (stage.mesh(), assets), (view, size_px));
    PixelSampler {
        view,
        tracer: stage.mesh().tracer(),
        others: stage.others(),
        surface,
        size_px,
        keeps_points: false,
        environments: None,
        painted: None,
    }
}

/// Returns the sampler of a picture with samples of the mean radiance of environments for `lobes`.
pub(super) fn direct_sampler<'a>(
    (stage, scene, assets): (&Stage<'a>, &Scene, &LightAssets),
    size_px: PictureSize,
    lobes: Option<LobeShape>,
) -> PixelSampler<'a> {
    let mut sampler = pixel_sampler(stage, scene, assets, size_px);
    if let Some(lobes) = lobes {
        let environments = sampler.surface.take_environments();
        sampler.environments = Some(DirectLight::new(environments, lobes));
    }
    sampler
}

/// Samples with one ray through each centre, and more rays in edge and curved pixels.
fn adaptive(sampler: &PixelSampler<'_>, area: PixelArea) -> Vec<Row> {
    let border = area.with_border(sampler.size_px);
    let centres: Vec<CentreRow> = (0..border.height)
        .into_par_iter()
        .with_max_len(ROWS)
        .map_init(Stack::default, |stack, row| {
            centre_row(sampler, area, border, border.y + row, stack)
        })
        .collect();
    (0..area.height)
        .into_par_iter()
        .with_max_len(ROWS)
        .map_init(
            || (Scratch::default(), Groups::default()),
            |tools, row| {
                let inside = (area.y - border.y + row) as usize;
                let last = centres.len() - 1;
                let rows = [inside.saturating_sub(1), inside, (inside + 1).min(last)];
                let neighbours = rows.map(|row| centres[row].features.as_slice());
                adaptive_row(sampler, (area, border), row, (&centres[inside], neighbours), tools)
            },
        )
        .collect()
}

fn centre_row(
    sampler: &PixelSampler<'_>,
    area: PixelArea,
    border: PixelArea,
    y: u32,
    stack: &mut Stack,
) -> CentreRow {
    let mut row = CentreRow {
        features: Vec::with_capacity(border.width as usize),
        buffer: SampleBuffer::default(),
        lit: Vec::with_capacity(area.width as usize),
        unlit: (0, 0),
        facing: Vec::new(),
    };
    let own_row = (area.y..area.y + area.height).contains(&y);
    let mut point = SurfacePoint::default();
    for x in border.x..border.x + border.width {
        sampler.trace(sampler.camera_ray((x, y), DVec2::splat(0.5), 0), stack, &mut point);
        row.features.push(point.features);
        if own_row && (area.x..area.x + area.width).contains(&x) {
            let start = row.buffer.count();
            row.buffer.push_point(&point);
            if let (Some(light), Some(facing)) = (&sampler.environments, &point.facing) {
                row.buffer.push_environments(&light.at(facing), facing, 1.0);
            }
            row.lit.push(row.buffer.count() - start);
            row.unlit = (row.unlit.0 + point.skipped, row.unlit.1 + point.shadowed);
            if sampler.keeps_points {
                row.facing.push(point.facing);
            }
        }
    }
    row
}

/// Class of a pixel, which decides its rays besides the one through the centre.
#[derive(PartialEq)]
enum PixelClass {
    /// No more rays.
    Smooth,
    Curved,
    /// Dissimilar to a neighbour.
    Edge,
}

/// Classifies the pixel at column `x` of the middle row.
fn classify(rows: [&[PixelFeatures]; 3], x: usize) -> PixelClass {
    let columns = x.saturating_sub(1)..(x + 2).min(rows[1].len());
    let own = &rows[1][x];
    let similar =
        rows.iter().all(|row| row[columns.clone()].iter().all(|features| own.is_similar(features)));
    if !similar {
        return PixelClass::Edge;
    }
    if own.lights == 0 {
        return PixelClass::Smooth;
    }
    let second_difference =
        |a: &PixelFeatures, b: &PixelFeatures| (a.shade - 2.0 * own.shade + b.shade).abs();
    let horizontal = second_difference(&rows[1][columns.start], &rows[1][columns.end - 1]);
    // The mean over a square differs from the value at its centre by 1/24 of the second
    // differences.
    let error = (horizontal + second_difference(&rows[0][x], &rows[2][x])) / 24.0;
    if error > CURVED_THRESHOLD { PixelClass::Curved } else { PixelClass::Smooth }
}

/// Returns the angle between the shading normals at opposite edges of the pixel at column `x` of
/// the middle row, in radians: the root of the mean square of both axes.
fn normal_spread(rows: [&[PixelFeatures]; 3], x: usize) -> f64 {
    let own = rows[1][x].shading_n;
    let columns = [x.saturating_sub(1), (x + 1).min(rows[1].len() - 1)];
    let step = |neighbour: &PixelFeatures| f64::from((neighbour.shading_n - own).length());
    let across = step(&rows[1][columns[0]]).max(step(&rows[1][columns[1]]));
    let down = step(&rows[0][x]).max(step(&rows[2][x]));
    (0.5 * (across * across + down * down)).sqrt()
}

fn adaptive_row(
    sampler: &PixelSampler<'_>,
    (area, border): (PixelArea, PixelArea),
    row: u32,
    (centre, neighbours): (&CentreRow, [&[PixelFeatures]; 3]),
    (scratch, groups): &mut (Scratch, Groups),
) -> Row {
    let mut out = Row::default();
    out.counts.add_unlit(centre.unlit);
    let (mut from, mut copied) = (0, 0);
    for column in 0..area.width {
        let x = area.x + column;
        let at = (x - border.x) as usize;
        let pixel = row * area.width + column;
        let own = &neighbours[1][at];
        let lit = centre.lit[column as usize];
        let class = classify(neighbours, at);
        out.counts.rays += 1;
        out.counts.covered += u64::from(own.covered);
        from += lit as usize;
        if class == PixelClass::Smooth {
            if let Some(Some(facing)) = centre.facing.get(column as usize) {
                let spread = normal_spread(neighbours, at);
                let facing = (facing.frame.n(), facing.eye);
                out.points.push(LitPoint::new((pixel, 1.0), facing, spread));
            }
            out.finish_pixel(pixel, (lit, lit, 0), f32::from(u8::from(own.covered)));
            continue;
        }
        out.buffer.extend(&centre.buffer, copied..from);
        copied = from;
        if class == PixelClass::Edge {
            sampler.edge((x, area.y + row), own, scratch);
        } else {
            sampler.curved((x, area.y + row), scratch);
        }
        if sampler.keeps_points {
            let facing = scratch.weighted().map(|(point, weight)| (point.facing, weight));
            LitPoint::push_groups(pixel, facing, &mut out.points);
        }
        let start = out.buffer.count();
        let coverage = match sampler.painted {
            None => groups.push_all(scratch.weighted(), &mut out.buffer),
            Some(_) => push_groups(scratch.weighted(), &mut out.buffer),
        };
        if let Some(light) = &sampler.environments {
            let facing = scratch.weighted().map(|(point, weight)| (point.facing, weight));
            for group in similar_points(facing) {
                out.buffer.push_environments(&light.at(&group.facing), &group.facing, group.weight);
            }
        }
        let added = out.buffer.count() - start;
        out.counts.rays += scratch.rays() as u64;
        out.counts.covered += scratch.covered();
        out.counts.add_unlit(scratch.unlit());
        // Weights sum to 1 up to rounding.
        let coverage = if coverage > 1.0 - 1e-9 { 1.0 } else { coverage as f32 };
        out.finish_pixel(pixel, (lit + added, lit, lit), coverage);
    }
    out.buffer.extend(&centre.buffer, copied..from);
    out
}

/// Concatenates the rows into one set, and the points of painted materials.
pub(super) fn concatenate(rows: Vec<Row>, mut image: ImageLayout) -> (SampleSet, PaintBuffer) {
    let count = rows.iter().map(|row| row.buffer.pairs.len()).sum();
    let mut all = SampleBuffer::with_capacity(count);
    let mut coverage = Vec::with_capacity((image.width * image.height) as usize);
    let mut counts = SampleCounts::default();
    for mut row in rows {
        let first = all.count();
        for run in row.runs {
            let run = PixelRun { start: first + run.start, ..run };
            if !image.runs.last_mut().is_some_and(|last| last.extend(&run)) {
                image.runs.push(run);
            }
        }
        all.append(&mut row.buffer);
        coverage.extend(row.coverage);
        counts.rays += row.counts.rays;
        counts.covered += row.counts.covered;
        counts.add_unlit((row.counts.skipped, row.counts.shadowed));
    }
    image.coverage = coverage.into();
    counts.lit = u64::from(all.count());
    (SampleSet::new(all.pairs, all.uvs, all.irradiance, Some(image), counts), all.paint)
}
