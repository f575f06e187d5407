//! Nearest hits of rays on the triangles of a mesh.
//!
//! Owns the tree over f32 boxes and the exact decision which triangle is hit: f64, watertight along shared edges, ties
//! to the lowest triangle, so that a hit does not depend on the shape of the tree. Works in the unit frame of the mesh:
//! centre of the bounding sphere 0, radius 1.

mod beam;
#[cfg(test)]
mod tests;
mod tree;
mod triangle;

use glam::{DVec2, DVec3, Vec3A};

pub(crate) use beam::Beam;
use beam::Window;
use tree::{Bounds, Item, Node};
use triangle::ShearedRay;

/// Boxes are grown by this much in the unit frame. Boxes are tested in f32, against origins within 2.6 of the centre:
/// the corners, the origin, their difference, the product and the hit distance are rounded by at most 2.4e-7 each.
const BOX_MARGIN: f32 = 4e-6;

/// A ray in the unit frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ray {
    /// Where it starts.
    pub origin: DVec3,
    /// Its unit direction.
    pub direction: DVec3,
}

/// The nearest hit of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Hit {
    /// Number of the triangle.
    pub triangle: usize,
    /// Weights of its corners; they sum to 1 and none is negative.
    pub weights: [f64; 3],
    /// Distance from the point where the ray came within reach of the mesh.
    distance: f64,
}

/// What rays are traced against.
#[derive(Debug)]
pub(crate) struct Tracer {
    nodes: Vec<Node>,
    /// Triangles in the order of the leaves.
    triangles: Vec<Triangle>,
}

/// A triangle with its corners at hand: what is tested together lies together.
#[derive(Debug, Clone, Copy)]
struct Triangle {
    corners: [DVec3; 3],
    number: u32,
}

/// Nodes that wait for their visit, kept between rays. Reused so that no ray allocates.
#[derive(Debug, Default)]
pub(crate) struct Stack(Vec<(f32, u32)>);

impl Tracer {
    /// Builds the tree over all triangles that can be hit.
    pub fn new(positions: &[DVec3], triangles: &[[u32; 3]], centre: DVec3, radius: f64) -> Self {
        let positions: Vec<DVec3> = positions.iter().map(|p| (*p - centre) / radius).collect();
        let corners = |t: &[u32; 3]| t.map(|corner| positions[corner as usize]);
        let has_area = |t: &[u32; 3]| {
            let [a, b, c] = corners(t);
            (b - a).cross(c - a) != DVec3::ZERO
        };
        let solid = (0u32..).zip(triangles).filter(|(_, t)| has_area(t));
        let items = solid.map(|(triangle, t)| Item { bounds: grown_bounds(corners(t)), triangle });
        let (nodes, order) = tree::build(items.collect());
        let ordered = order
            .into_iter()
            .map(|number| Triangle { corners: corners(&triangles[number as usize]), number });
        Self { nodes, triangles: ordered.collect() }
    }

    /// The nearest hit at a positive distance.
    ///
    /// # Domain
    /// Any ray with finite numbers; another one misses.
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
                // Rounded, which the margin of the boxes allows for.
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
            // The nearer child is popped first.
            if far.0 <= reach && far.0 < f32::INFINITY {
                stack.push(far);
            }
            if near.0 <= reach && near.0 < f32::INFINITY {
                stack.push(near);
            }
        }
        best
    }

    /// Whether anything is hit at a positive distance below `reach`.
    ///
    /// # Domain
    /// Any ray with finite numbers; another one hits nothing. An infinite reach is allowed.
    pub fn is_occluded(&self, ray: Ray, reach: f64, stack: &mut Stack) -> bool {
        let Some((sheared, origin)) = approach(ray) else { return false };
        // Hits count from where the ray came within reach of the mesh.
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
            // Infinite where the ray passes by; the margin of the boxes allows for what is rounded.
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

    /// Looks up every triangle that a ray within the beam may hit; `false` where they are so many that rays are better
    /// traced one by one. `project` says where in the pixel a place is seen.
    pub fn gather(
        &self,
        beam: &Beam,
        project: impl Fn(DVec3) -> Option<DVec2>,
        stack: &mut Stack,
        found: &mut Candidates,
    ) -> bool {
        found.triangles.clear();
        found.windows.clear();
        let stack = &mut stack.0;
        stack.clear();
        if !self.nodes.is_empty() {
            stack.push((0.0, 0));
        }
        while let Some((_, index)) = stack.pop() {
            let node = &self.nodes[index as usize];
            if !beam.may_meet(&node.bounds) {
                continue;
            }
            if node.count == 0 {
                stack.push((0.0, node.first));
                stack.push((0.0, node.first + 1));
                continue;
            }
            for triangle in &self.triangles[node.range()] {
                if let Some(window) = Window::around(&triangle.corners, &project) {
                    found.triangles.push(*triangle);
                    found.windows.push(window);
                }
            }
            if found.triangles.len() > Candidates::MOST {
                return false;
            }
        }
        true
    }
}

/// The triangles that matter to the rays of a pixel, and where in the pixel they may be seen.
#[derive(Debug, Default)]
pub(crate) struct Candidates {
    triangles: Vec<Triangle>,
    windows: Vec<Window>,
}

impl Candidates {
    /// Above this, the tree is faster.
    const MOST: usize = 160;

    /// The nearest hit among them: what [`Tracer::trace`] finds, to the bit, for the ray through a place of the beam.
    pub fn trace(&self, ray: Ray, place: DVec2) -> Option<Hit> {
        let (sheared, _) = approach(ray)?;
        let place = place.as_vec2();
        let mut best = None;
        for (window, triangle) in self.windows.iter().zip(&self.triangles) {
            if window.holds(place) {
                test(&sheared, triangle, &mut best);
            }
        }
        best
    }
}

/// The ray from where it comes within reach of the bounding sphere: far origins would cost digits. `None` where it
/// passes by or is not finite.
fn approach(ray: Ray) -> Option<(ShearedRay, DVec3)> {
    let ahead = -ray.origin.dot(ray.direction);
    if (ray.origin + ray.direction * ahead).length_squared() > 1.01 {
        return None;
    }
    let origin = ray.origin + ray.direction * (ahead - 1.5).max(0.0);
    Some((ShearedRay::new(origin, ray.direction)?, origin))
}

/// One over a direction, for boxes.
#[inline]
fn inverse(direction: DVec3) -> Vec3A {
    let direction = direction.as_vec3a();
    // An infinity would make NaN of a box side that the origin lies on.
    let tiny = direction.abs().cmplt(Vec3A::splat(1e-30));
    Vec3A::select(tiny, Vec3A::splat(1e30), direction.recip())
}

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

/// Distance at which the ray enters the box (0 inside), infinite where it passes by.
#[inline]
fn entry_distance(bounds: &Bounds, origin: Vec3A, inverse: Vec3A) -> f32 {
    let a = (bounds.low - origin) * inverse;
    let b = (bounds.high - origin) * inverse;
    let near = a.min(b).max_element().max(0.0);
    let far = a.max(b).min_element();
    if near <= far { near } else { f32::INFINITY }
}

/// The box of a triangle, grown so that it holds the triangle after all rounding.
fn grown_bounds([a, b, c]: [DVec3; 3]) -> Bounds {
    let low = a.min(b).min(c).as_vec3a() - BOX_MARGIN;
    let high = a.max(b).max(c).as_vec3a() + BOX_MARGIN;
    Bounds { low, high }
}
