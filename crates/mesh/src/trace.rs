//! Ray tracing: nearest hits and occlusion on the triangles of a mesh.
//!
//! Rays traverse a bounding volume hierarchy (BVH) with f32 boxes; triangles are tested in f64. No
//! ray passes between two triangles that share an edge. Of equally near triangles the one with the
//! lowest index is hit, so a hit does not depend on the shape of the BVH. All coordinates are in
//! the unit frame: the mesh is moved and scaled to a bounding sphere with centre 0 and radius 1.

mod frustum;
mod ray;
#[cfg(test)]
mod tests;
mod tree;
mod triangle;

use glam::{DVec2, DVec3, Vec3A};

pub use frustum::PixelFrustum;
pub use ray::Ray;

use frustum::EdgeFunctions;
use tree::{Bounds, Item, Node};
use triangle::ShearedRay;

/// Margin by which boxes are grown on each side, in the unit frame. It exceeds the rounding errors
/// of the f32 box test, for ray origins within 2.6 of the centre: at most 2.4e-7 for each of the
/// box corners, the origin, their difference, its product with the inverse direction, and the hit
/// distance.
const BOX_MARGIN: f32 = 4e-6;

/// Nearest hit of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Index of the triangle in the mesh.
    pub triangle: usize,
    /// Barycentric weights of the triangle's corners; non-negative, with sum 1.
    pub weights: [f64; 3],
    /// Distance from the origin that `approach` returns, not from the origin of the ray.
    distance: f64,
}

impl Hit {
    /// Returns a point of the plane of a triangle as a hit. Outside of the triangle, weights are
    /// negative or above 1.
    #[must_use]
    pub fn on_plane(triangle: usize, weights: [f64; 3]) -> Self {
        Self { triangle, weights, distance: 0.0 }
    }
}

/// BVH over the triangles of a mesh.
#[derive(Debug)]
pub struct Tracer {
    nodes: Vec<Node>,
    /// Triangles in the order of the leaves, so that those of a leaf are contiguous.
    triangles: Vec<Triangle>,
}

/// Triangle of a leaf. It holds copies of its corners, so that a test needs no look-up of vertices.
#[derive(Debug, Clone, Copy)]
struct Triangle {
    corners: [DVec3; 3],
    /// Index of the triangle in the mesh.
    number: u32,
}

/// Stack of BVH nodes to visit: the distance at which the ray enters the node (used only by
/// [`Tracer::trace`]) and the index of the node. Reused between rays to avoid allocation.
#[derive(Debug, Default)]
pub struct Stack(Vec<(f32, u32)>);

impl Tracer {
    /// Builds the BVH over all triangles with a nonzero area. `centre` and `radius` are those of
    /// the bounding sphere of the mesh.
    #[must_use]
    pub fn new(positions: &[DVec3], triangles: &[[u32; 3]], centre: DVec3, radius: f64) -> Self {
        let positions: Vec<DVec3> = positions.iter().map(|p| (*p - centre) / radius).collect();
        let corners = |t: &[u32; 3]| t.map(|corner| positions[corner as usize]);
        let has_area = |t: &[u32; 3]| {
            let [a, b, c] = corners(t);
            (b - a).cross(c - a) != DVec3::ZERO
        };
        let hittable = (0u32..).zip(triangles).filter(|(_, t)| has_area(t));
        let items =
            hittable.map(|(triangle, t)| Item { bounds: grown_bounds(corners(t)), triangle });
        let (nodes, order) = tree::build(items.collect());
        let ordered = order
            .into_iter()
            .map(|number| Triangle { corners: corners(&triangles[number as usize]), number });
        Self { nodes, triangles: ordered.collect() }
    }

    /// Returns the nearest hit at a positive distance.
    ///
    /// # Domain
    /// Rays with finite numbers; all others miss.
    #[must_use]
    pub fn trace(&self, ray: Ray, stack: &mut Stack) -> Option<Hit> {
        let (sheared, origin) = approach(ray)?;
        let origin = origin.as_vec3a();
        let inverse = inverse(ray.direction);
        let mut best: Option<Hit> = None;
        let mut reach = f32::INFINITY;
        let stack = &mut stack.0;
        stack.clear();
        if let Some(root) = self.nodes.first() {
            let entry = entry_distance(&root.bounds, origin, inverse);
            if entry < f32::INFINITY {
                stack.push((entry, 0));
            }
        }
        while let Some((entry, index)) = stack.pop() {
            if entry > reach {
                continue;
            }
            let node = &self.nodes[index as usize];
            if node.count > 0 {
                for triangle in &self.triangles[node.range()] {
                    test(&sheared, triangle, &mut best);
                }
                // The rounding to f32 rejects no box with a nearer hit: `BOX_MARGIN` exceeds it.
                reach = best.map_or(f32::INFINITY, |hit| hit.distance as f32);
                continue;
            }
            let (left, right) = (node.first, node.first + 1);
            let near = entry_distance(&self.nodes[left as usize].bounds, origin, inverse);
            let far = entry_distance(&self.nodes[right as usize].bounds, origin, inverse);
            let (near, far) = if near < far {
                ((near, left), (far, right))
            } else {
                ((far, right), (near, left))
            };
            // Pushed last, the nearer child is popped first.
            if far.0 <= reach && far.0 < f32::INFINITY {
                stack.push(far);
            }
            if near.0 <= reach && near.0 < f32::INFINITY {
                stack.push(near);
            }
        }
        best
    }

    /// True if a triangle is hit at a positive distance below `reach`.
    ///
    /// # Domain
    /// Rays with finite numbers; all others hit nothing. `reach` may be infinite.
    #[must_use]
    pub fn is_occluded(&self, ray: Ray, reach: f64, stack: &mut Stack) -> bool {
        let Some((sheared, origin)) = approach(ray) else { return false };
        // Hit distances are measured from the origin that `approach` returns.
        let reach = reach - (origin - ray.origin).dot(ray.direction);
        let origin = origin.as_vec3a();
        let inverse = inverse(ray.direction);
        let stack = &mut stack.0;
        stack.clear();
        if !self.nodes.is_empty() {
            stack.push((0.0, 0));
        }
        while let Some((_, index)) = stack.pop() {
            let node = &self.nodes[index as usize];
            // Infinite if the ray misses the box. Its rounding is less than `BOX_MARGIN`.
            let entry = entry_distance(&node.bounds, origin, inverse);
            if entry == f32::INFINITY || f64::from(entry) > reach {
                continue;
            }
            if node.count == 0 {
                stack.push((0.0, node.first));
                stack.push((0.0, node.first + 1));
                continue;
            }
            let hit = |triangle: &Triangle| {
                sheared.intersect(&triangle.corners).is_some_and(|(distance, _)| distance < reach)
            };
            if self.triangles[node.range()].iter().any(hit) {
                return true;
            }
        }
        false
    }

    /// Collects into `found` every triangle that a ray within the frustum may hit. Returns false if
    /// there are more than 160: `found` is then incomplete, and [`Tracer::trace`] is faster.
    /// `project` maps a point to pixel coordinates, 0 to 1 from left to right and from top to
    /// bottom, or returns `None` if it is not in front of the eye.
    #[must_use]
    pub fn gather(
        &self,
        frustum: &PixelFrustum,
        project: impl Fn(DVec3) -> Option<DVec2>,
        stack: &mut Stack,
        found: &mut Candidates,
    ) -> bool {
        found.triangles.clear();
        found.edges.clear();
        let stack = &mut stack.0;
        stack.clear();
        if !self.nodes.is_empty() {
            stack.push((0.0, 0));
        }
        while let Some((_, index)) = stack.pop() {
            let node = &self.nodes[index as usize];
            if !frustum.may_intersect(&node.bounds) {
                continue;
            }
            if node.count == 0 {
                stack.push((0.0, node.first));
                stack.push((0.0, node.first + 1));
                continue;
            }
            for triangle in &self.triangles[node.range()] {
                if let Some(edges) = EdgeFunctions::new(&triangle.corners, &project) {
                    found.triangles.push(*triangle);
                    found.edges.push(edges);
                }
            }
            if found.triangles.len() > Candidates::MAX {
                return false;
            }
        }
        true
    }
}

/// Triangles that rays of a pixel may hit, each with its edge functions: three linear functions of
/// the position in the pixel; where one is negative, no ray hits the triangle.
#[derive(Debug, Default)]
pub struct Candidates {
    triangles: Vec<Triangle>,
    edges: Vec<EdgeFunctions>,
}

impl Candidates {
    /// Largest number of triangles; above it, tracing each ray through the BVH is faster.
    const MAX: usize = 160;

    /// Returns the nearest hit among the candidates, bit-identical to [`Tracer::trace`]. `ray` is
    /// the ray through the point `in_pixel`, in pixel coordinates from 0 to 1.
    #[must_use]
    pub fn trace(&self, ray: Ray, in_pixel: DVec2) -> Option<Hit> {
        let (sheared, _) = approach(ray)?;
        let in_pixel = in_pixel.as_vec2();
        let mut best = None;
        for (edges, triangle) in self.edges.iter().zip(&self.triangles) {
            if edges.contains(in_pixel) {
                test(&sheared, triangle, &mut best);
            }
        }
        best
    }
}

/// Moves a far origin forward along the ray, close to the bounding sphere, because tests from far
/// away would lose digits. Returns the ray from there, and its origin; `None` if the ray misses the
/// sphere or has an infinite or NaN number.
fn approach(ray: Ray) -> Option<(ShearedRay, DVec3)> {
    let ahead = -ray.origin.dot(ray.direction);
    if (ray.origin + ray.direction * ahead).length_squared() > 1.01 {
        return None;
    }
    let origin = ray.origin + ray.direction * (ahead - 1.5).max(0.0);
    Some((ShearedRay::new(origin, ray.direction)?, origin))
}

/// Returns the reciprocal of a direction, for box tests.
#[inline]
fn inverse(direction: DVec3) -> Vec3A {
    let direction = direction.as_vec3a();
    // The reciprocal of 0 is infinite. Times 0, the distance of an origin that lies on a box side,
    // it would be NaN, so 1e30 replaces it.
    let tiny = direction.abs().cmplt(Vec3A::splat(1e-30));
    Vec3A::select(tiny, Vec3A::splat(1e30), direction.recip())
}

/// Tests a triangle and updates the nearest hit; of equal distances the lower index is nearest.
#[inline]
fn test(ray: &ShearedRay, triangle: &Triangle, best: &mut Option<Hit>) {
    let Some((distance, weights)) = ray.intersect(&triangle.corners) else { return };
    let number = triangle.number as usize;
    let nearer = best.is_none_or(|hit| {
        distance < hit.distance || (distance == hit.distance && number < hit.triangle)
    });
    if nearer {
        *best = Some(Hit { triangle: number, weights, distance });
    }
}

/// Returns the distance at which the ray enters the box: 0 from inside, infinite on a miss.
#[inline]
fn entry_distance(bounds: &Bounds, origin: Vec3A, inverse: Vec3A) -> f32 {
    let a = (bounds.low - origin) * inverse;
    let b = (bounds.high - origin) * inverse;
    let near = a.min(b).max_element().max(0.0);
    let far = a.max(b).min_element();
    if near <= far { near } else { f32::INFINITY }
}

/// Returns the box of a triangle, grown to contain the triangle despite rounding.
fn grown_bounds([a, b, c]: [DVec3; 3]) -> Bounds {
    let low = a.min(b).min(c).as_vec3a() - BOX_MARGIN;
    let high = a.max(b).max(c).as_vec3a() + BOX_MARGIN;
    Bounds { low, high }
}
