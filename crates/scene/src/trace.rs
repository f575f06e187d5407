//! Nearest hits of rays on the triangles of a mesh.
//!
//! Owns the tree over f32 boxes and the exact decision which triangle is hit: f64, watertight along shared edges, ties
//! to the lowest triangle, so that a hit does not depend on the shape of the tree. Works in the unit frame of the mesh:
//! centre of the bounding sphere 0, radius 1.

#[cfg(test)]
mod tests;
mod tree;
mod triangle;

use glam::DVec3;

use tree::{Bounds, Item, Node};
use triangle::ShearedRay;

/// Boxes are grown by this much in the unit frame: rounding of the corners to f32 (6e-8), of the box test and of the
/// hit distance (1e-15 each) stay far below it.
const BOX_MARGIN: f32 = 1e-6;

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
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    nodes: Vec<Node>,
    /// Triangles in the order of the leaves.
    order: Vec<u32>,
}

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
        Self { positions, triangles: triangles.to_vec(), nodes, order }
    }

    /// The nearest hit at a positive distance.
    ///
    /// # Domain
    /// Any ray with finite numbers; another one misses.
    pub fn trace(&self, ray: Ray, stack: &mut Vec<(f64, u32)>) -> Option<Hit> {
        // Far origins would cost digits: start where the ray comes within reach of the bounding sphere.
        let ahead = -ray.origin.dot(ray.direction);
        if (ray.origin + ray.direction * ahead).length_squared() > 1.01 {
            return None;
        }
        let origin = ray.origin + ray.direction * (ahead - 1.5).max(0.0);
        let sheared = ShearedRay::new(origin, ray.direction)?;
        let inverse = ray.direction.to_array().map(|d| {
            // An infinity would make NaN of a box side that the origin lies on.
            1.0 / if d.abs() < 1e-300 { 1e-300 } else { d }
        });
        let mut best: Option<Hit> = None;
        stack.clear();
        if let Some(root) = self.nodes.first()
            && let Some(entry) = entry_distance(&root.bounds, origin, inverse)
        {
            stack.push((entry, 0));
        }
        while let Some((entry, index)) = stack.pop() {
            if best.is_some_and(|hit| entry > hit.distance) {
                continue;
            }
            let node = &self.nodes[index as usize];
            if node.count > 0 {
                let leaf = node.first as usize..(node.first + node.count) as usize;
                for &triangle in &self.order[leaf] {
                    self.test(&sheared, triangle as usize, &mut best);
                }
                continue;
            }
            let mut children = [node.first, node.first + 1].map(|child| {
                let entry = entry_distance(&self.nodes[child as usize].bounds, origin, inverse);
                (entry.unwrap_or(f64::INFINITY), child)
            });
            // The nearer child is popped first.
            if children[0].0 < children[1].0 {
                children.swap(0, 1);
            }
            stack.extend(children.into_iter().filter(|child| child.0 < f64::INFINITY));
        }
        best
    }

    fn test(&self, ray: &ShearedRay, triangle: usize, best: &mut Option<Hit>) {
        let corners = self.triangles[triangle].map(|corner| self.positions[corner as usize]);
        let Some((distance, weights)) = ray.intersect(corners) else { return };
        let nearer = best.is_none_or(|hit| {
            distance < hit.distance || (distance == hit.distance && triangle < hit.triangle)
        });
        if nearer {
            *best = Some(Hit { triangle, weights, distance });
        }
    }
}

/// Distance at which the ray enters the box (0 inside), `None` where it passes by.
fn entry_distance(bounds: &Bounds, origin: DVec3, inverse: [f64; 3]) -> Option<f64> {
    let (mut near, mut far) = (0.0f64, f64::INFINITY);
    for (axis, o) in origin.to_array().into_iter().enumerate() {
        let a = (f64::from(bounds.low[axis]) - o) * inverse[axis];
        let b = (f64::from(bounds.high[axis]) - o) * inverse[axis];
        near = near.max(a.min(b));
        far = far.min(a.max(b));
    }
    (near <= far).then_some(near)
}

/// The box of a triangle, grown so that it holds the triangle after all rounding.
fn grown_bounds([a, b, c]: [DVec3; 3]) -> Bounds {
    let low = a.min(b).min(c).as_vec3() - BOX_MARGIN;
    let high = a.max(b).max(c).as_vec3() + BOX_MARGIN;
    Bounds { low: low.to_array(), high: high.to_array() }
}
