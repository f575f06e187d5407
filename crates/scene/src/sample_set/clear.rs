//! Clear bodies: the rays that a surface mirrors, and the ways of the eye through a body.
//!
//! All rays are in the unit frame of the body and start just beside its surface.

use brood_mesh::trace::{Ray, Stack};
use brood_mesh::{Mesh, MeshParts};
use glam::DVec3;
use rayon::prelude::*;

use super::frame::ShadedPoint;
use super::point::START_ABOVE;
use super::render::ROWS;
use super::seen_point::{LeavingRay, SeenPoint};
use super::set::SampleSet;
use crate::description::Tangents;
use crate::stage::{Other, Stage};

/// Largest number of walls that a way meets in a body before it leaves.
const WALLS_MAX: usize = 64;
/// Largest number of times that a way is followed where it meets its body again.
const MEETINGS_MAX: usize = 4;
/// Number of rays that a thread follows at a time.
const TOGETHER: usize = 256;

/// Way of an eye ray that leaves a body, mirrored at its surface or refracted through it.
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
    /// Returns the way of the mirrored eye ray of each sample, for a body with an index of
    /// refraction relative to its surroundings. A ray that meets the body again is followed as in
    /// [`SampleSet::ways_out`].
    ///
    /// # Panics
    /// If the set was not made by [`SampleSet::render_clear_points`].
    #[must_use]
    pub fn mirrored_ways(&self, stage: &Stage<'_>, index: f64) -> Vec<WayOut> {
        self.followed(stage, index, |body, point, stack| {
            let wall = point.wall();
            body.way_out((wall.mirrored(-point.eye), point.seed), (0.0, 1.0), stack)
        })
    }

    /// Returns at most two ways out of the body for each sample, of a body with an index of
    /// refraction relative to its surroundings. If nothing enters the body, there is none.
    ///
    /// At each wall inside, light leaves by Fresnel's equations for a dielectric; the rest stays
    /// inside. A way that leaves and meets the body again, before any other part of the stage,
    /// follows the stronger of mirrored and refracted ray at each wall.
    ///
    /// # Domain
    /// The stage shows the part whose samples these are, with a closed mesh; an index above 0.
    /// Through a gap of an open mesh, a way leaves without being bent.
    ///
    /// # Panics
    /// As [`SampleSet::mirrored_ways`].
    #[must_use]
    pub fn ways_out(&self, stage: &Stage<'_>, index: f64) -> Vec<[Option<WayOut>; 2]> {
        self.followed(stage, index, |body, point, stack| body.ways_out(point, stack))
    }

    fn followed<T: Send>(
        &self,
        stage: &Stage<'_>,
        index: f64,
        follow: impl Fn(&Body<'_>, &SeenPoint, &mut Stack) -> T + Sync,
    ) -> Vec<T> {
        let chunks = self.seen_points().par_chunks(TOGETHER);
        let body = Body { mesh: stage.mesh(), others: stage.others(), index };
        let chunks = chunks.with_max_len(ROWS).map_init(Stack::default, |stack, points| {
            points.iter().map(|point| follow(&body, point, stack)).collect::<Vec<_>>()
        });
        chunks.flatten_iter().collect()
    }

    fn seen_points(&self) -> &[SeenPoint] {
        assert!(self.seen.len() == self.len, "the set keeps no points of the surface");
        &self.seen
    }
}

impl SeenPoint {
    fn wall(&self) -> Wall {
        Wall { position: self.position, n: self.n, face: self.face, distance: 0.0 }
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

/// Clear body among other parts.
struct Body<'a> {
    mesh: &'a Mesh,
    others: Vec<Other<'a>>,
    index: f64,
}

impl Body<'_> {
    fn ways_out(&self, point: &SeenPoint, stack: &mut Stack) -> [Option<WayOut>; 2] {
        let mut ways = [None; 2];
        let entering = point.wall().crossed(-point.eye, 1.0 / self.index);
        let Some(mut ray) = entering else { return ways };
        let (mut found, mut length, mut left) = (0, 0.0, 1.0);
        for _ in 0..WALLS_MAX {
            let Some(wall) = self.wall(ray, stack) else {
                ways[found] = Some(self.way_out((ray, point.seed), (length, left), stack));
                break;
            };
            length += wall.distance;
            let share = wall.mirrored_share(ray, self.index);
            let out = wall.crossed(ray.direction, self.index).filter(|_| share < 1.0);
            if let Some(out) = out {
                let share = left * (1.0 - share);
                ways[found] = Some(self.way_out((out, point.seed), (length, share), stack));
                found += 1;
                if found == ways.len() {
                    break;
                }
            }
            left *= share;
            ray = wall.mirrored(ray.direction);
        }
        let all: f64 = ways.iter().flatten().map(|way| way.share).sum();
        for way in ways.iter_mut().flatten() {
            way.share = if all > 0.0 { way.share / all } else { 0.0 };
        }
        ways
    }

    /// Returns the way of a ray that has left the body, with the length of its way inside and its
    /// share. Where the ray meets the body again, the stronger ray at each wall is followed.
    fn way_out(
        &self,
        (mut ray, seed): (Ray, u64),
        (mut length, share): (f64, f64),
        stack: &mut Stack,
    ) -> WayOut {
        for _ in 0..MEETINGS_MAX {
            let Some(wall) = self.wall(ray, stack) else { break };
            let reach = wall.distance;
            if self.others.iter().any(|other| other.is_hit(ray, reach, stack)) {
                break;
            }
            if wall.mirrored_share(ray, 1.0 / self.index) > 0.5 {
                ray = wall.mirrored(ray.direction);
                continue;
            }
            let inside = wall.crossed(ray.direction, 1.0 / self.index);
            let out = inside.and_then(|inside| self.strongest_out(inside, stack));
            let Some((out, inside)) = out else { break };
            (ray, length) = (out, length + inside);
        }
        WayOut { leaving: LeavingRay { ray, seed }, length, share }
    }

    /// Follows a ray inside the body by the stronger ray at each wall. Returns the ray that leaves
    /// and the length inside; `None` if it does not leave.
    fn strongest_out(&self, mut ray: Ray, stack: &mut Stack) -> Option<(Ray, f64)> {
        let mut length = 0.0;
        for _ in 0..WALLS_MAX {
            let Some(wall) = self.wall(ray, stack) else { return Some((ray, length)) };
            length += wall.distance;
            if wall.mirrored_share(ray, self.index) <= 0.5 {
                return wall.crossed(ray.direction, self.index).map(|out| (out, length));
            }
            ray = wall.mirrored(ray.direction);
        }
        None
    }

    /// Returns the wall that a ray meets.
    fn wall(&self, ray: Ray, stack: &mut Stack) -> Option<Wall> {
        let parts: &MeshParts = self.mesh.parts();
        let hit = self.mesh.tracer().trace(ray, stack)?;
        let shaded = ShadedPoint::new(parts, &hit, -ray.direction, Tangents::Vertex);
        let position = (shaded.position - self.mesh.centre()) / self.mesh.radius();
        let (n, face) = (shaded.frame.n(), shaded.face());
        let n = if n.dot(ray.direction) < 0.0 { n } else { face };
        Some(Wall { position, n, face, distance: (position - ray.origin).dot(ray.direction) })
    }
}

/// Point of the surface of a body, on one of its sides.
struct Wall {
    position: DVec3,
    /// Shading normal and normal of the triangle, on the side of the ray that meets it.
    n: DVec3,
    face: DVec3,
    /// Distance from the origin of the ray.
    distance: f64,
}

impl Wall {
    /// Returns the ray behind the wall; `None` if all is mirrored. `ratio`: index before the wall
    /// over that behind it. If the shading normal sends it back, it is bent at the triangle.
    fn crossed(&self, direction: DVec3, ratio: f64) -> Option<Ray> {
        let bent = |n: DVec3| refracted(direction, n, ratio);
        let by_shading = bent(self.n)?;
        let is_behind = by_shading.dot(self.face) < 0.0;
        let direction = if is_behind { by_shading } else { bent(self.face)? };
        Some(Ray { origin: self.position - self.face * START_ABOVE, direction })
    }

    /// Returns the mirrored ray. If the shading normal sends it behind the wall, it is mirrored at
    /// the triangle.
    fn mirrored(&self, direction: DVec3) -> Ray {
        let at = |n: DVec3| direction - 2.0 * n.dot(direction) * n;
        let by_shading = at(self.n);
        let is_before = by_shading.dot(self.face) > 0.0;
        let direction = if is_before { by_shading } else { at(self.face) };
        let origin = self.position + self.face * START_ABOVE;
        Ray { origin, direction: direction.normalize() }
    }

    /// Returns the share of light that is mirrored.
    fn mirrored_share(&self, ray: Ray, ratio: f64) -> f64 {
        mirrored_share(-ray.direction.dot(self.n), ratio)
    }
}

#[cfg(test)]
#[path = "clear_tests.rs"]
mod tests;
