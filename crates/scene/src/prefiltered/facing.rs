//! Surface points that face the eye, and groups of similar points of a pixel.

use brood_mesh::LocalFrame;
use glam::{DVec2, DVec3};

/// Distance of normals from the first of a group, up to which points are similar.
const MAX_DISTANCE: f64 = 0.12;
/// The same for tangents. Means of tangents that differ more represent none of them.
const MAX_TANGENT_DISTANCE: f64 = 0.25;
/// The same for texture positions; separates the sides of a seam.
const MAX_UV_DISTANCE: f64 = 0.05;
/// Largest number of groups of a pixel; further points join the nearest.
const MAX_GROUPS: usize = 6;
/// Length below which the mean of tangents is treated as zero.
const MIN_LENGTH: f64 = 1e-6;

/// Surface point on the side that faces the eye.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Facing {
    pub frame: LocalFrame,
    /// Unit vector to the eye, in the frame of the mesh.
    pub eye: DVec3,
    /// Texture position.
    pub uv: DVec2,
}

/// Mean of similar points of a pixel.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FacingGroup {
    pub facing: Facing,
    /// Share of the pixel.
    pub weight: f64,
    /// Largest distance of normals from the first of the group.
    pub spread: f64,
}

/// Weighted sums of similar points.
struct Sums {
    first: Facing,
    n: DVec3,
    u: DVec3,
    eye: DVec3,
    uv: DVec2,
    weight: f64,
    spread: f64,
}

impl Sums {
    fn new(first: Facing) -> Self {
        let (zero, uv) = (DVec3::ZERO, DVec2::ZERO);
        Self { first, n: zero, u: zero, eye: zero, uv, weight: 0.0, spread: 0.0 }
    }

    /// Returns the distance of a point from the first of the group; similar points are within 1.
    fn distance(&self, point: &Facing) -> f64 {
        let first = &self.first;
        let normals = (first.frame.n() - point.frame.n()).length() / MAX_DISTANCE;
        let tangents = (first.frame.u() - point.frame.u()).length() / MAX_TANGENT_DISTANCE;
        let texture = (first.uv - point.uv).abs().max_element() / MAX_UV_DISTANCE;
        normals.max(tangents).max(texture)
    }

    fn add(&mut self, point: &Facing, weight: f64) {
        self.spread = self.spread.max((self.first.frame.n() - point.frame.n()).length());
        self.n += point.frame.n() * weight;
        self.u += point.frame.u() * weight;
        self.eye += point.eye * weight;
        self.uv += point.uv * weight;
        self.weight += weight;
    }

    fn mean(&self) -> FacingGroup {
        let n = self.n.try_normalize().unwrap_or(self.first.frame.n());
        let along = |u: DVec3| u - n * u.dot(n);
        let mean = along(self.u);
        let u = if mean.length() > MIN_LENGTH { mean } else { along(self.first.frame.u()) };
        let u = u.try_normalize().unwrap_or_else(|| n.any_orthonormal_vector());
        let eye = self.eye.try_normalize().unwrap_or(self.first.eye);
        let facing = Facing { frame: LocalFrame::new(n, u), eye, uv: self.uv / self.weight };
        FacingGroup { facing, weight: self.weight, spread: self.spread }
    }
}

/// Groups the weighted points of a pixel by their normals, tangents and texture positions.
pub(crate) fn groups(
    points: impl Iterator<Item = (Option<Facing>, f64)>,
) -> impl Iterator<Item = FacingGroup> {
    let mut groups: Vec<Sums> = Vec::with_capacity(MAX_GROUPS);
    for (facing, weight) in points {
        let Some(point) = facing.filter(|_| weight > 0.0) else { continue };
        let distances = groups.iter().map(|group| group.distance(&point));
        let nearest = distances.enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
        let joins = nearest.filter(|(_, distance)| *distance <= 1.0 || groups.len() == MAX_GROUPS);
        let k = joins.map_or(groups.len(), |(k, _)| k);
        if k == groups.len() {
            groups.push(Sums::new(point));
        }
        groups[k].add(&point, weight);
    }
    groups.into_iter().map(|group| group.mean())
}
