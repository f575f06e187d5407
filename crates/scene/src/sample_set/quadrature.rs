//! Rays of one pixel: tracing, and the quadrature of edge and curved pixels.
//!
//! The error of n scattered rays over a half-plane that cuts a pixel is about n^-3/4, and
//! silhouettes then dominate the error of a picture. Here rays lie on parallel lines across the
//! edge. On each line the crossing between dissimilar neighbours is found by bisection, and every
//! ray represents its segment of the line. The same error needs a tenth of the rays
//! (docs/maths/film.md).

use brood_light::ray_seed;
use brood_mesh::trace::{Candidates, Hit, PixelFrustum, Ray, Stack, Tracer};
use glam::DVec2;

use super::paint::{NextRays, Painted};
use super::point::{CameraRay, PixelFeatures, Surface, SurfacePoint};
use super::size::PictureSize;
use super::view::View;
use crate::prefiltered::DirectLight;
use crate::stage::Other;

/// Number of lines in an edge pixel, and of rays per line before bisection.
const EDGE_LINES: usize = 10;
/// Number of bisections between two dissimilar rays.
const BISECTIONS: usize = 4;
/// Number of lines in a curved pixel, and of rays per line.
const CURVED_LINES: usize = 3;

/// Corners of a pixel, in circular order.
const CORNERS: [DVec2; 4] = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];

/// Traces and shades the rays of a picture's pixels.
pub(super) struct PixelSampler<'a> {
    pub view: View,
    pub tracer: &'a Tracer,
    /// Other objects, which may hide the mesh.
    pub others: Vec<Other<'a>>,
    pub surface: Surface<'a>,
    pub size_px: PictureSize,
    /// True to keep the surface points of adaptive sampling, for light that is not sampled.
    pub keeps_points: bool,
    /// Environments that are not among the lights of the surface.
    pub environments: Option<DirectLight>,
    /// Present for painted materials.
    pub painted: Option<Painted>,
}

/// Buffers reused between pixels, to avoid allocation.
#[derive(Default)]
pub(super) struct Scratch {
    pub stack: Stack,
    candidates: Candidates,
    use_candidates: bool,
    points: Vec<SurfacePoint>,
    /// One per ray of the pixel. `points` may be longer: the rest belong to earlier pixels.
    weights: Vec<f64>,
    line: Vec<(f64, usize)>,
    corner: SurfacePoint,
    /// Point of fixed sampling, reused for its memory.
    pub fixed: SurfacePoint,
}

impl PixelSampler<'_> {
    /// Returns the ray through a point of a pixel, within [0, 1]^2 from its upper left corner.
    pub fn ray(&self, x: u32, y: u32, offset: DVec2) -> Ray {
        self.view.pixel_ray(self.size_px, (x, y), offset)
    }

    /// Returns that ray with the seed for its index in the pixel.
    pub fn camera_ray(&self, (x, y): (u32, u32), offset: DVec2, index: usize) -> CameraRay {
        CameraRay { ray: self.ray(x, y, offset), seed: ray_seed(x, y, index) }
    }

    /// Converts a point of the picture to coordinates of a pixel.
    fn in_pixel(&self, x: u32, y: u32, at: DVec2) -> DVec2 {
        let half = 0.5 * f64::from(self.size_px.height);
        let left = self.size_px.aspect();
        DVec2::new((at.x + left) * half - f64::from(x), (1.0 - at.y) * half - f64::from(y))
    }

    /// Traces and shades a ray, and returns true if it hits. `point` receives the result.
    pub fn trace(&self, ray: CameraRay, stack: &mut Stack, point: &mut SurfacePoint) -> bool {
        let hit = self.tracer.trace(ray.ray, stack);
        self.shade(hit.as_ref(), ray, stack, point)
    }

    /// Returns the hit of a ray; `None` if it misses, or if another object is in front of it.
    pub fn visible_hit(&self, ray: Ray, stack: &mut Stack) -> Option<Hit> {
        let hit = self.tracer.trace(ray, stack)?;
        (!self.is_hidden(&hit, ray, stack)).then_some(hit)
    }

    /// Gathers the triangles that rays of a pixel may hit, for [`PixelSampler::trace_in_pixel`].
    pub fn gather_candidates(&self, x: u32, y: u32, scratch: &mut Scratch) {
        let frustum = PixelFrustum::new(CORNERS.map(|corner| self.ray(x, y, corner)));
        scratch.use_candidates = frustum.is_some_and(|frustum| {
            let project = |p| self.view.project(p).map(|at| self.in_pixel(x, y, at));
            self.tracer.gather(&frustum, project, &mut scratch.stack, &mut scratch.candidates)
        });
    }

    /// As [`PixelSampler::trace`], for a ray of the pixel whose candidates were gathered.
    pub fn trace_in_pixel(
        &self,
        (ray, offset): (CameraRay, DVec2),
        scratch: &mut Scratch,
        point: &mut SurfacePoint,
    ) -> bool {
        let hit = if scratch.use_candidates {
            scratch.candidates.trace(ray.ray, offset)
        } else {
            self.tracer.trace(ray.ray, &mut scratch.stack)
        };
        self.shade(hit.as_ref(), ray, &mut scratch.stack, point)
    }

    /// Traces one more ray of the pixel, stores its point and returns the point's index.
    fn add(&self, pixel: (u32, u32), offset: DVec2, weight: f64, scratch: &mut Scratch) -> usize {
        let index = scratch.weights.len();
        if scratch.points.len() <= index {
            scratch.points.push(SurfacePoint::default());
        }
        let mut point = std::mem::take(&mut scratch.points[index]);
        self.trace_in_pixel((self.camera_ray(pixel, offset, 0), offset), scratch, &mut point);
        scratch.points[index] = point;
        scratch.weights.push(weight);
        index
    }

    fn shade(
        &self,
        hit: Option<&Hit>,
        ray: CameraRay,
        stack: &mut Stack,
        point: &mut SurfacePoint,
    ) -> bool {
        self.shade_beside(hit, (ray, None), stack, point)
    }

    /// Traces and shades any ray; `next` are those beside it.
    pub fn trace_beside(
        &self,
        (ray, next): (CameraRay, NextRays),
        stack: &mut Stack,
        point: &mut SurfacePoint,
    ) -> bool {
        let hit = self.tracer.trace(ray.ray, stack);
        self.shade_beside(hit.as_ref(), (ray, Some(next)), stack, point)
    }

    /// As [`PixelSampler::shade`]; the rays beside a camera ray are found from the picture.
    fn shade_beside(
        &self,
        hit: Option<&Hit>,
        (ray, next): (CameraRay, Option<NextRays>),
        stack: &mut Stack,
        point: &mut SurfacePoint,
    ) -> bool {
        let hit = hit.filter(|hit| !self.is_hidden(hit, ray.ray, stack));
        match hit {
            Some(hit) => match &self.painted {
                None => self.surface.shade(hit, ray, stack, point),
                Some(painted) => {
                    let next =
                        next.unwrap_or_else(|| self.next_rays(ray.ray, hit, painted.spacing));
                    self.surface.paint(hit, (ray, next), (painted, stack), point);
                }
            },
            None => {
                point.features = PixelFeatures::default();
                point.lit.clear();
                point.facing = None;
                (point.skipped, point.shadowed) = (0, 0);
            }
        }
        hit.is_some()
    }

    /// True if another object is in front of a hit.
    fn is_hidden(&self, hit: &Hit, ray: Ray, stack: &mut Stack) -> bool {
        if self.others.is_empty() {
            return false;
        }
        let distance = (self.surface.position(hit) - ray.origin).dot(ray.direction);
        self.others.iter().any(|other| other.is_hit(ray, distance, stack))
    }

    /// Returns the rays to the right of and below the ray of a hit, `spacing` pixels away.
    fn next_rays(&self, ray: Ray, hit: &Hit, spacing: f64) -> NextRays {
        let step = spacing * 2.0 / f64::from(self.size_px.height);
        match self.view.project(self.surface.position(hit)) {
            Some(at) => NextRays(
                [DVec2::new(step, 0.0), DVec2::new(0.0, -step)]
                    .map(|offset| self.view.ray(at + offset)),
            ),
            // Too close to the eye for a gradient.
            None => NextRays([ray; 2]),
        }
    }

    /// Traces the rays of a pixel with a neighbour dissimilar to `own`, the features of its centre.
    pub fn edge(&self, (x, y): (u32, u32), own: &PixelFeatures, scratch: &mut Scratch) {
        scratch.use_candidates = false;
        if self.corners_are_similar((x, y), own, scratch) {
            return self.grid(x, y, CURVED_LINES, scratch);
        }
        self.gather_candidates(x, y, scratch);
        self.grid(x, y, EDGE_LINES, scratch);
        let differ = |a: usize, b: usize| {
            !scratch.points[a].features.is_similar(&scratch.points[b].features)
        };
        let (mut along_rows, mut along_columns) = (0, 0);
        for line in 0..EDGE_LINES {
            for k in 1..EDGE_LINES {
                let at = line * EDGE_LINES + k;
                along_rows += usize::from(differ(at - 1, at));
                let at = k * EDGE_LINES + line;
                along_columns += usize::from(differ(at - EDGE_LINES, at));
            }
        }
        if along_rows + along_columns == 0 {
            return;
        }
        // Lines across the edge; lines along it would be wholly on one side.
        let rows = along_rows >= along_columns;
        for line in 0..EDGE_LINES {
            self.bisect_line(x, y, (line, rows), scratch);
        }
    }

    /// True if the corners of a pixel are similar to its centre. An edge inside is then short and
    /// is ignored.
    fn corners_are_similar(
        &self,
        pixel: (u32, u32),
        own: &PixelFeatures,
        scratch: &mut Scratch,
    ) -> bool {
        let mut point = std::mem::take(&mut scratch.corner);
        let similar = CORNERS.iter().all(|corner| {
            self.trace_in_pixel((self.camera_ray(pixel, *corner, 0), *corner), scratch, &mut point);
            point.features.is_similar(own)
        });
        scratch.corner = point;
        similar
    }

    /// Traces the rays of a curved pixel.
    pub fn curved(&self, (x, y): (u32, u32), scratch: &mut Scratch) {
        // Gathering candidates would cost more than it saves for so few rays.
        scratch.use_candidates = false;
        self.grid(x, y, CURVED_LINES, scratch);
    }

    /// Traces rays at the centres of n x n cells, with equal weights.
    fn grid(&self, x: u32, y: u32, lines: usize, scratch: &mut Scratch) {
        scratch.weights.clear();
        let weight = 1.0 / (lines * lines) as f64;
        for row in 0..lines {
            for column in 0..lines {
                let offset = DVec2::new(cell_centre(column, lines), cell_centre(row, lines));
                self.add((x, y), offset, weight, scratch);
            }
        }
    }

    /// Bisects between dissimilar neighbours of a line, and weights each ray of the line by its
    /// segment. `rows` is true if lines are rows.
    fn bisect_line(
        &self,
        x: u32,
        y: u32,
        (line_index, rows): (usize, bool),
        scratch: &mut Scratch,
    ) {
        let across = cell_centre(line_index, EDGE_LINES);
        let offset = |t: f64| if rows { DVec2::new(t, across) } else { DVec2::new(across, t) };
        let index = |k: usize| {
            if rows { line_index * EDGE_LINES + k } else { k * EDGE_LINES + line_index }
        };
        let mut line = std::mem::take(&mut scratch.line);
        line.clear();
        line.extend((0..EDGE_LINES).map(|k| (cell_centre(k, EDGE_LINES), index(k))));
        for k in 1..EDGE_LINES {
            let (mut low, mut high) = (line[k - 1], line[k]);
            if scratch.is_similar(low.1, high.1) {
                continue;
            }
            for _ in 0..BISECTIONS {
                let t = 0.5 * (low.0 + high.0);
                let middle = (t, self.add((x, y), offset(t), 0.0, scratch));
                line.push(middle);
                if scratch.is_similar(low.1, middle.1) {
                    low = middle;
                } else {
                    high = middle;
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

/// Returns the centre of a cell of [0, 1].
fn cell_centre(cell: usize, cells: usize) -> f64 {
    (cell as f64 + 0.5) / cells as f64
}

impl Scratch {
    /// Iterates over the points of the pixel's rays and the fraction of the pixel that each
    /// represents.
    pub fn weighted(&self) -> impl Iterator<Item = (&SurfacePoint, f64)> {
        self.points.iter().zip(self.weights.iter().copied())
    }

    /// Number of rays of the pixel.
    pub fn rays(&self) -> usize {
        self.weights.len()
    }

    /// Number of rays of the pixel that hit the mesh.
    pub fn covered(&self) -> u64 {
        self.weighted().map(|(point, _)| u64::from(point.features.covered)).sum()
    }

    /// Numbers of light samples of the pixel that were skipped and shadowed.
    pub fn unlit(&self) -> (u64, u64) {
        let unlit = self.weighted().map(|(point, _)| (point.skipped, point.shadowed));
        unlit.fold((0, 0), |sum, own| (sum.0 + own.0, sum.1 + own.1))
    }

    fn is_similar(&self, a: usize, b: usize) -> bool {
        self.points[a].features.is_similar(&self.points[b].features)
    }
}
