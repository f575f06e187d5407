//! From a mesh and a scene to its samples: rows in parallel, put together in their order.

use glam::DVec2;
use rayon::prelude::*;

use super::cluster::Groups;
use super::lighting::Lamp;
use super::point::{Gathered, Mark, Point, Surface};
use super::quadrature::{Camera, Scratch};
use super::view::{UnitFrame, View, subsample_places};
use super::{ImageLayout, PixelArea, PixelRun, Raster, SampleCounts, SampleSet, Sampling};
use crate::trace::Stack;
use crate::{LightAssets, Mesh, Scene};

/// From so many rays a pixel on, its triangles are looked up once for all of them.
const SHARED_RAYS: usize = 4;
/// A smooth pixel whose centre is off its mean by more than this, relative to the light at normal incidence, is curved.
const CURVED: f32 = 2e-4;

/// The samples of a row of the area.
#[derive(Default)]
struct Row {
    gathered: Gathered,
    runs: Vec<PixelRun>,
    coverage: Vec<f32>,
    counts: SampleCounts,
}

/// The rays through the centres of a row: of the area and a border of one pixel.
struct CentreRow {
    marks: Vec<Mark>,
    /// Samples of the area's own pixels, and how many each has.
    gathered: Gathered,
    lit: Vec<u32>,
    unlit: (u64, u64),
}

pub(super) fn render(
    mesh: &Mesh,
    scene: &Scene,
    assets: &LightAssets,
    raster: Raster,
) -> SampleSet {
    let Raster { size_px, sampling, area } = raster;
    assert!(size_px <= u32::from(u16::MAX), "size_px {size_px} is not in 1..=65535");
    assert!(area.is_within(size_px), "the area {area} is not within {size_px} pixels");
    let frame = UnitFrame::new(mesh, scene);
    let camera = Camera {
        view: View::new(&scene.camera, &frame),
        tracer: mesh.tracer(),
        surface: Surface::new(mesh, Lamp::all(scene, assets, &frame), scene),
        size_px,
    };
    let rows = match sampling {
        Sampling::Adaptive => adaptive(&camera, area),
        Sampling::Fixed(samples) => {
            let places = subsample_places(u32::from(samples));
            (0..area.height)
                .into_par_iter()
                .map_init(Scratch::default, |scratch, row| {
                    fixed_row(&camera, area, row, &places, scratch)
                })
                .collect()
        }
    };
    let scale = match sampling {
        Sampling::Adaptive => 1.0,
        Sampling::Fixed(samples) => 1.0 / f32::from(samples),
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
    put_together(rows, image)
}

/// The same rays in every pixel.
fn fixed_row(
    camera: &Camera<'_>,
    area: PixelArea,
    row: u32,
    places: &[DVec2],
    scratch: &mut Scratch,
) -> Row {
    let mut out = Row::default();
    out.counts.rays = u64::from(area.width) * places.len() as u64;
    let inverse = 1.0 / places.len() as f32;
    let (mut point, y) = (Point::default(), area.y + row);
    for column in 0..area.width {
        let x = area.x + column;
        let start = out.gathered.count();
        let (mut centre, mut covered) = (0, 0u16);
        if places.len() >= SHARED_RAYS {
            camera.enter_pixel(x, y, scratch);
        }
        for (k, place) in places.iter().enumerate() {
            let sight = camera.sight((x, y), *place, k);
            let hit = if places.len() >= SHARED_RAYS {
                camera.see_in_pixel((sight, *place), scratch, &mut point)
            } else {
                camera.see(sight, &mut scratch.stack, &mut point)
            };
            if hit {
                covered += 1;
                out.counts.add_unlit((point.skipped, point.shadowed));
                out.gathered.push_point(&point);
            }
            if k == 0 {
                centre = out.gathered.count() - start;
            }
        }
        out.counts.covered += u64::from(covered);
        let samples = out.gathered.count() - start;
        out.finish(row * area.width + column, (samples, centre, 0), f32::from(covered) * inverse);
    }
    out
}

/// One ray through each centre, more where neighbours differ.
fn adaptive(camera: &Camera<'_>, area: PixelArea) -> Vec<Row> {
    let border = area.grown(camera.size_px);
    let centres: Vec<CentreRow> = (0..border.height)
        .into_par_iter()
        .map_init(Stack::default, |stack, row| {
            centre_row(camera, area, border, border.y + row, stack)
        })
        .collect();
    (0..area.height)
        .into_par_iter()
        .map_init(
            || (Scratch::default(), Groups::default()),
            |tools, row| {
                let inside = (area.y - border.y + row) as usize;
                let last = centres.len() - 1;
                let rows = [inside.saturating_sub(1), inside, (inside + 1).min(last)];
                let neighbours = rows.map(|row| centres[row].marks.as_slice());
                adaptive_row(camera, (area, border), row, (&centres[inside], neighbours), tools)
            },
        )
        .collect()
}

fn centre_row(
    camera: &Camera<'_>,
    area: PixelArea,
    border: PixelArea,
    y: u32,
    stack: &mut Stack,
) -> CentreRow {
    let mut row = CentreRow {
        marks: Vec::with_capacity(border.width as usize),
        gathered: Gathered::default(),
        lit: Vec::with_capacity(area.width as usize),
        unlit: (0, 0),
    };
    let own_row = (area.y..area.y + area.height).contains(&y);
    let mut point = Point::default();
    for x in border.x..border.x + border.width {
        camera.see(camera.sight((x, y), DVec2::splat(0.5), 0), stack, &mut point);
        row.marks.push(point.mark);
        if own_row && (area.x..area.x + area.width).contains(&x) {
            row.gathered.push_point(&point);
            row.lit.push(u32::try_from(point.lit.len()).expect("lights have few samples"));
            row.unlit = (row.unlit.0 + point.skipped, row.unlit.1 + point.shadowed);
        }
    }
    row
}

/// What a pixel needs besides the ray through its centre.
#[derive(PartialEq)]
enum Need {
    Nothing,
    Curved,
    Edge,
}

fn need(rows: [&[Mark]; 3], x: usize) -> Need {
    let columns = x.saturating_sub(1)..(x + 2).min(rows[1].len());
    let own = &rows[1][x];
    let alike = rows.iter().all(|row| row[columns.clone()].iter().all(|mark| own.is_like(mark)));
    if !alike {
        return Need::Edge;
    }
    if own.lights == 0 {
        return Need::Nothing;
    }
    let bend = |a: &Mark, b: &Mark| (a.shade - 2.0 * own.shade + b.shade).abs();
    let level = bend(&rows[1][columns.start], &rows[1][columns.end - 1]);
    // The mean over a square differs from the value at its centre by 1/24 of the second differences.
    let off = (level + bend(&rows[0][x], &rows[2][x])) / 24.0;
    if off > CURVED { Need::Curved } else { Need::Nothing }
}

fn adaptive_row(
    camera: &Camera<'_>,
    (area, border): (PixelArea, PixelArea),
    row: u32,
    (centre, neighbours): (&CentreRow, [&[Mark]; 3]),
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
        let need = need(neighbours, at);
        out.counts.rays += 1;
        out.counts.covered += u64::from(own.covered);
        from += lit as usize;
        if need == Need::Nothing {
            out.finish(pixel, (lit, lit, 0), f32::from(u8::from(own.covered)));
            continue;
        }
        out.gathered.extend(&centre.gathered, copied..from);
        copied = from;
        if need == Need::Edge {
            camera.edge((x, area.y + row), own, scratch);
        } else {
            camera.curved((x, area.y + row), scratch);
        }
        let start = out.gathered.count();
        let coverage = groups.push_all(scratch.weighted(), &mut out.gathered);
        let added = out.gathered.count() - start;
        out.counts.rays += scratch.rays() as u64;
        out.counts.covered += scratch.covered();
        out.counts.add_unlit(scratch.unlit());
        // Weights sum to 1 but for rounding.
        let coverage = if coverage > 1.0 - 1e-9 { 1.0 } else { coverage as f32 };
        out.finish(pixel, (lit + added, lit, lit), coverage);
    }
    out.gathered.extend(&centre.gathered, copied..from);
    out
}

impl Row {
    /// Ends a pixel whose samples have been, or are about to be, added; its numbers of samples are all, those of the
    /// centre, and those that do not count.
    fn finish(&mut self, pixel: u32, (samples, centre, counted): (u32, u32, u32), coverage: f32) {
        self.coverage.push(coverage);
        if samples == 0 {
            return;
        }
        let start = self.runs.last().map_or(0, PixelRun::end);
        let run = PixelRun { pixel, pixels: 1, start, samples, centre, counted };
        if !self.runs.last_mut().is_some_and(|last| last.extend(&run)) {
            self.runs.push(run);
        }
    }
}

fn put_together(rows: Vec<Row>, mut image: ImageLayout) -> SampleSet {
    let count = rows.iter().map(|row| row.gathered.pairs.len()).sum();
    let mut all = Gathered::with_capacity(count);
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
        all.append(&mut row.gathered);
        coverage.extend(row.coverage);
        counts.rays += row.counts.rays;
        counts.covered += row.counts.covered;
        counts.add_unlit((row.counts.skipped, row.counts.shadowed));
    }
    image.coverage = coverage.into();
    counts.lit = u64::from(all.count());
    SampleSet::new(all.pairs, all.uvs, all.irradiance, Some(image), counts)
}
