//! Clear bodies: the rays that a surface mirrors, and the ways of the eye through a body.
//!
//! All rays are in the unit frame of the body and start just beside its surface.

use brood_mesh::trace::{Hit, Ray, Stack};
use brood_mesh::{Mesh, MeshParts};
use glam::DVec3;
use rayon::prelude::*;

use super::frame::ShadedPoint;
use super::point::START_ABOVE;
use super::seen_point::{LeavingRay, SeenPoint};
use super::set::SampleSet;
use crate::description::Tangents;

/// Largest number of walls inside a body that a way meets.
const WALLS_MAX: usize = 6;
/// Number of rays that a thread follows at a time.
const TOGETHER: usize = 256;

/// Way of the eye through a body: it enters, passes walls inside and leaves.
#[derive(Debug, Clone, Copy)]
pub struct WayOut {
    /// Ray that leaves.
    pub leaving: LeavingRay,
    /// Length inside the body, in its radii.
    pub length: f64,
    /// Share of the light of all ways that are followed, in [0, 1].
    pub share: f64,
}

impl SampleSet {
    /// Returns the mirrored eye ray of each sample.
    ///
    /// # Panics
    /// If the set was not made by [`SampleSet::render_clear_points`].
    #[must_use]
    pub fn mirrored_rays(&self) -> Vec<LeavingRay> {
        self.seen_points().iter().map(SeenPoint::mirrored).collect()
    }

    /// Returns at most two ways out of the body for each sample, of a body with an index of
    /// refraction relative to its surroundings. If nothing enters the body, there is none.
    ///
    /// A way turns at up to six walls. At each, light leaves by Fresnel's equations for a
    /// dielectric; the rest stays inside. `mesh` is that of the part of the stage.
    ///
    /// # Domain
    /// A closed mesh and an index above 0. Through a gap of an open mesh, a way leaves without
    /// being bent.
    ///
    /// # Panics
    /// As [`SampleSet::mirrored_rays`].
    #[must_use]
    pub fn ways_out(&self, mesh: &Mesh, index: f64) -> Vec<[Option<WayOut>; 2]> {
        let points = self.seen_points();
        let chunks = points.par_chunks(TOGETHER);
        let chunks = chunks.map_init(Stack::default, |stack, points| {
            let ways = points.iter().map(|point| ways_out(mesh, point, index, stack));
            ways.collect::<Vec<_>>()
        });
        chunks.flatten_iter().collect()
    }

    fn seen_points(&self) -> &[SeenPoint] {
        assert!(self.seen.len() == self.len, "the set keeps no points of the surface");
        &self.seen
    }
}

impl SeenPoint {
    /// Returns the mirrored eye ray. If the shading normal sends it into the body, it is mirrored
    /// at the triangle.
    fn mirrored(&self) -> LeavingRay {
        let at = |n: DVec3| 2.0 * n.dot(self.eye) * n - self.eye;
        let by_shading = at(self.n);
        let outwards = by_shading.dot(self.face) > 0.0;
        let direction = if outwards { by_shading } else { at(self.face) };
        let origin = self.position + self.face * START_ABOVE;
        LeavingRay { ray: Ray { origin, direction: direction.normalize() }, seed: self.seed }
    }

    /// Returns the ray that enters a body with an index of refraction; `None` if all is mirrored.
    fn entering(&self, index: f64) -> Option<Ray> {
        let bent = |n: DVec3| refracted(-self.eye, n, 1.0 / index);
        let direction = bent(self.n)?;
        let inwards = direction.dot(self.face) < 0.0;
        let direction = if inwards { direction } else { bent(self.face)? };
        Some(Ray { origin: self.position - self.face * START_ABOVE, direction })
    }
}

/// Direction of light behind a surface with normal `n` on the side that `towards` comes from;
/// `None` if all of it is mirrored. `ratio`: index before the surface over that behind it.
///
/// # Source
/// Snell's law in vectors.
fn refracted(towards: DVec3, n: DVec3, ratio: f64) -> Option<DVec3> {
    let cosine = -towards.dot(n);
    let squared = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
    let bent = ratio * towards + (ratio * cosine - squared.max(0.0).sqrt()) * n;
    (cosine > 0.0 && squared >= 0.0).then(|| bent.normalize())
}

/// Share of unpolarised light that a smooth wall mirrors; 1 if nothing passes. `ratio`: index
/// before the wall over that behind it.
///
/// # Source
/// Fresnel's equations for dielectrics.
fn mirrored_share(cosine: f64, ratio: f64) -> f64 {
    let squared = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
    if squared <= 0.0 {
        return 1.0;
    }
    let behind = squared.sqrt();
    let across = (ratio * cosine - behind) / (ratio * cosine + behind);
    let along = (cosine - ratio * behind) / (cosine + ratio * behind);
    0.5 * (across * across + along * along)
}

fn ways_out(mesh: &Mesh, point: &SeenPoint, index: f64, stack: &mut Stack) -> [Option<WayOut>; 2] {
    let mut ways = [None; 2];
    let Some(mut ray) = point.entering(index) else { return ways };
    let (mut found, mut length, mut left) = (0, 0.0, 1.0);
    let leaving = |ray| LeavingRay { ray, seed: point.seed };
    for _ in 0..WALLS_MAX {
        let Some(hit) = mesh.tracer().trace(ray, stack) else {
            ways[found] = Some(WayOut { leaving: leaving(ray), length, share: left });
            break;
        };
        let wall = Wall::new(mesh, &hit, ray);
        length += wall.distance;
        let share = mirrored_share(-ray.direction.dot(wall.n), index);
        let out = refracted(ray.direction, wall.n, index).filter(|_| share < 1.0);
        if let Some(direction) = out {
            let inwards = direction.dot(wall.face) >= 0.0;
            let bent = refracted(ray.direction, wall.face, index).filter(|_| inwards);
            let direction = bent.unwrap_or(direction);
            let origin = wall.position - wall.face * START_ABOVE;
            let leaving = leaving(Ray { origin, direction });
            ways[found] = Some(WayOut { leaving, length, share: left * (1.0 - share) });
            found += 1;
            if found == ways.len() {
                break;
            }
            left *= share;
        }
        ray = wall.mirrored(ray);
    }
    let all: f64 = ways.iter().flatten().map(|way| way.share).sum();
    for way in ways.iter_mut().flatten() {
        way.share = if all > 0.0 { way.share / all } else { 0.0 };
    }
    ways
}

/// Wall of a body, seen from inside.
struct Wall {
    position: DVec3,
    /// Shading normal and normal of the triangle, inwards.
    n: DVec3,
    face: DVec3,
    distance: f64,
}

impl Wall {
    fn new(mesh: &Mesh, hit: &Hit, ray: Ray) -> Self {
        let parts: &MeshParts = mesh.parts();
        let shaded = ShadedPoint::new(parts, hit, -ray.direction, Tangents::Vertex);
        let position = (shaded.position - mesh.centre()) / mesh.radius();
        let (n, face) = (shaded.frame.n(), shaded.face());
        let n = if n.dot(ray.direction) < 0.0 { n } else { face };
        Self { position, n, face, distance: (position - ray.origin).dot(ray.direction) }
    }

    fn mirrored(&self, ray: Ray) -> Ray {
        let at = |n: DVec3| ray.direction - 2.0 * n.dot(ray.direction) * n;
        let by_shading = at(self.n);
        let inwards = by_shading.dot(self.face) > 0.0;
        let direction = if inwards { by_shading } else { at(self.face) };
        let origin = self.position + self.face * START_ABOVE;
        Ray { origin, direction: direction.normalize() }
    }
}

#[cfg(test)]
#[path = "clear_tests.rs"]
mod tests;
