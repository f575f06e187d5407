//! The rays of one pixel within which something changes.
//!
//! A half-plane that cuts a pixel is integrated by n scattered rays to about n^-3/4; a picture's error is then the error of
//! its silhouettes. Here rays lie on parallel lines, across the edge; on each, the place where neighbouring rays stop being
//! alike is found by halving, and every ray stands for its piece of the line. That costs a tenth of the rays for the same
//! error (docs/maths/film.md).

use glam::DVec2;

use super::point::{Mark, Point, Sight, Surface};
use super::sequence::ray_seed;
use super::view::View;
use crate::trace::{Beam, Candidates, Hit, Ray, Stack, Tracer};

/// Lines of a pixel with an edge, and rays on each before halving.
const EDGE_LINES: usize = 10;
/// How often the distance between two unlike rays is halved.
const HALVINGS: usize = 4;
/// Lines, and rays on each, of a pixel that is smooth but curved.
const CURVED_LINES: usize = 3;

/// The corners of a pixel, one after the other around it.
const CORNERS: [DVec2; 4] = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];

/// How the rays of a picture are made and followed.
pub(super) struct Camera<'a> {
    pub view: View,
    pub tracer: &'a Tracer,
    pub surface: Surface<'a>,
    pub size_px: u32,
}

/// Memory that rays use again and again.
#[derive(Default)]
pub(super) struct Scratch {
    pub stack: Stack,
    candidates: Candidates,
    use_candidates: bool,
    points: Vec<Point>,
    /// As many as the pixel has rays; the other points are of pixels before.
    weights: Vec<f64>,
    line: Vec<(f64, usize)>,
    corner: Point,
}

impl Camera<'_> {
    /// The ray through a place of a pixel, within [0, 1]^2 from its upper left corner.
    pub fn ray(&self, x: u32, y: u32, place: DVec2) -> Ray {
        let at = (DVec2::new(f64::from(x), f64::from(y)) + place) * (2.0 / f64::from(self.size_px))
            - DVec2::ONE;
        self.view.ray(DVec2::new(at.x, -at.y))
    }

    /// The same for the ray of that number in the pixel.
    pub fn sight(&self, (x, y): (u32, u32), place: DVec2, number: usize) -> Sight {
        Sight { ray: self.ray(x, y, place), seed: ray_seed(x, y, number) }
    }

    /// The place of a pixel that is at a place of the picture.
    fn in_pixel(&self, x: u32, y: u32, at: DVec2) -> DVec2 {
        let half = 0.5 * f64::from(self.size_px);
        DVec2::new((at.x + 1.0) * half - f64::from(x), (1.0 - at.y) * half - f64::from(y))
    }

    /// Makes `point` what the ray sees; says whether it sees anything.
    pub fn see(&self, sight: Sight, stack: &mut Stack, point: &mut Point) -> bool {
        let hit = self.tracer.trace(sight.ray, stack);
        self.take(hit.as_ref(), sight, stack, point)
    }

    /// Looks up the triangles that matter to a pixel, before [`Camera::see_in_pixel`].
    pub fn enter_pixel(&self, x: u32, y: u32, scratch: &mut Scratch) {
        let beam = Beam::new(CORNERS.map(|place| self.ray(x, y, place)));
        scratch.use_candidates = beam.is_some_and(|beam| {
            let project = |p| self.view.project(p).map(|at| self.in_pixel(x, y, at));
            self.tracer.gather(&beam, project, &mut scratch.stack, &mut scratch.candidates)
        });
    }

    /// The same as [`Camera::see`] for a ray of the pixel that was entered.
    pub fn see_in_pixel(
        &self,
        (sight, place): (Sight, DVec2),
        scratch: &mut Scratch,
        point: &mut Point,
    ) -> bool {
        let hit = if scratch.use_candidates {
            scratch.candidates.trace(sight.ray, place)
        } else {
            self.tracer.trace(sight.ray, &mut scratch.stack)
        };
        self.take(hit.as_ref(), sight, &mut scratch.stack, point)
    }

    /// Follows one more ray of the pixel that was entered, and keeps its point.
    fn add(&self, pixel: (u32, u32), place: DVec2, weight: f64, scratch: &mut Scratch) -> usize {
        let index = scratch.weights.len();
        if scratch.points.len() <= index {
            scratch.points.push(Point::default());
        }
        let mut point = std::mem::take(&mut scratch.points[index]);
        self.see_in_pixel((self.sight(pixel, place, 0), place), scratch, &mut point);
        scratch.points[index] = point;
        scratch.weights.push(weight);
        index
    }

    fn take(&self, hit: Option<&Hit>, sight: Sight, stack: &mut Stack, point: &mut Point) -> bool {
        match hit {
            Some(hit) => self.surface.look(hit, sight, stack, point),
            None => {
                point.mark = Mark::default();
                point.lit.clear();
                (point.skipped, point.shadowed) = (0, 0);
            }
        }
        hit.is_some()
    }

    /// Rays of a pixel whose neighbours see something else than `own`.
    pub fn edge(&self, (x, y): (u32, u32), own: &Mark, scratch: &mut Scratch) {
        scratch.use_candidates = false;
        if self.corners_are_like((x, y), own, scratch) {
            return self.grid(x, y, CURVED_LINES, scratch);
        }
        self.enter_pixel(x, y, scratch);
        self.grid(x, y, EDGE_LINES, scratch);
        let unlike = |a: usize, b: usize| !scratch.points[a].mark.is_like(&scratch.points[b].mark);
        let (mut along_rows, mut along_columns) = (0, 0);
        for line in 0..EDGE_LINES {
            for k in 1..EDGE_LINES {
                let at = line * EDGE_LINES + k;
                along_rows += usize::from(unlike(at - 1, at));
                let at = k * EDGE_LINES + line;
                along_columns += usize::from(unlike(at - EDGE_LINES, at));
            }
        }
        if along_rows + along_columns == 0 {
            return;
        }
        // Across the edge: along it, whole lines would be in or out.
        let rows = along_rows >= along_columns;
        for line in 0..EDGE_LINES {
            self.halve(x, y, (line, rows), scratch);
        }
    }

    /// Whether the corners of a pixel see what its centre does: then no edge of any length is in it.
    fn corners_are_like(&self, pixel: (u32, u32), own: &Mark, scratch: &mut Scratch) -> bool {
        let mut point = std::mem::take(&mut scratch.corner);
        let alike = CORNERS.iter().all(|place| {
            self.see_in_pixel((self.sight(pixel, *place, 0), *place), scratch, &mut point);
            point.mark.is_like(own)
        });
        scratch.corner = point;
        alike
    }

    /// Rays of a pixel that is smooth and curved.
    pub fn curved(&self, (x, y): (u32, u32), scratch: &mut Scratch) {
        // So few rays that looking up what they may hit would cost more than they do.
        scratch.use_candidates = false;
        self.grid(x, y, CURVED_LINES, scratch);
    }

    /// Rays at the middles of n x n cells, all of one weight.
    fn grid(&self, x: u32, y: u32, lines: usize, scratch: &mut Scratch) {
        scratch.weights.clear();
        let weight = 1.0 / (lines * lines) as f64;
        for row in 0..lines {
            for column in 0..lines {
                let place = DVec2::new(middle(column, lines), middle(row, lines));
                self.add((x, y), place, weight, scratch);
            }
        }
    }

    /// Adds rays on a line where neighbours differ, and weighs all of the line by the piece that each stands for.
    fn halve(&self, x: u32, y: u32, (number, rows): (usize, bool), scratch: &mut Scratch) {
        let across = middle(number, EDGE_LINES);
        let place = |t: f64| if rows { DVec2::new(t, across) } else { DVec2::new(across, t) };
        let index = |k: usize| {
            if rows { number * EDGE_LINES + k } else { k * EDGE_LINES + number }
        };
        let mut line = std::mem::take(&mut scratch.line);
        line.clear();
        line.extend((0..EDGE_LINES).map(|k| (middle(k, EDGE_LINES), index(k))));
        for k in 1..EDGE_LINES {
            let (mut low, mut high) = (line[k - 1], line[k]);
            if scratch.is_like(low.1, high.1) {
                continue;
            }
            for _ in 0..HALVINGS {
                let t = 0.5 * (low.0 + high.0);
                let between = (t, self.add((x, y), place(t), 0.0, scratch));
                line.push(between);
                if scratch.is_like(low.1, between.1) {
                    low = between;
                } else {
                    high = between;
                }
            }
        }
        line.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut border = 0.0;
        for (k, (t, point)) in line.iter().enumerate() {
            let next = line.get(k + 1).map_or(1.0, |next| 0.5 * (t + next.0));
            scratch.weights[*point] = (next - border) / EDGE_LINES as f64;
            border = next;
        }
        scratch.line = line;
    }
}

fn middle(cell: usize, cells: usize) -> f64 {
    (cell as f64 + 0.5) / cells as f64
}

impl Scratch {
    /// The points of the pixel's rays and the share of the pixel that each stands for.
    pub fn weighted(&self) -> impl Iterator<Item = (&Point, f64)> {
        self.points.iter().zip(self.weights.iter().copied())
    }

    /// Rays of the pixel.
    pub fn rays(&self) -> usize {
        self.weights.len()
    }

    /// Rays of the pixel that hit the mesh.
    pub fn covered(&self) -> u64 {
        self.weighted().map(|(point, _)| u64::from(point.mark.covered)).sum()
    }

    /// Samples of lights that were not made: for want of light, and in shadow.
    pub fn unlit(&self) -> (u64, u64) {
        let unlit = self.weighted().map(|(point, _)| (point.skipped, point.shadowed));
        unlit.fold((0, 0), |sum, own| (sum.0 + own.0, sum.1 + own.1))
    }

    fn is_like(&self, a: usize, b: usize) -> bool {
        self.points[a].mark.is_like(&self.points[b].mark)
    }
}
