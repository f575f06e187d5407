//! Construction of the BVH, top down with a binned surface area heuristic.
//!
//! Own code, to bound the build time for any input file: builders that merge neighbours bottom up
//! take quadratic time if triangles are nested or coincide. Here each level costs one pass, and
//! from `MEDIAN_DEPTH` on (deeper than real models reach) nodes are split at the median.

use std::ops::Range;

use glam::Vec3A;

/// Largest number of triangles per leaf.
const LEAF_MAX: usize = 4;
/// Number of bins per split.
const BINS: usize = 16;
/// Depth from which nodes are split at the median. The depth of the tree is at most this plus the
/// binary logarithm of the count.
const MEDIAN_DEPTH: u32 = 48;

/// Axis-aligned box.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bounds {
    pub low: Vec3A,
    pub high: Vec3A,
}

impl Bounds {
    const EMPTY: Self = Self { low: Vec3A::INFINITY, high: Vec3A::NEG_INFINITY };

    fn extend(&mut self, other: &Self) {
        self.low = self.low.min(other.low);
        self.high = self.high.max(other.high);
    }

    /// Returns half the surface area; 0 if empty.
    fn area(&self) -> f32 {
        let size = (self.high - self.low).max(Vec3A::ZERO);
        size.dot(Vec3A::new(size.y, size.z, size.x))
    }

    /// Returns twice the centroid.
    fn double_centroid(&self) -> Vec3A {
        self.low + self.high
    }
}

/// Node of the BVH: a leaf of `count` triangles from `first` on in leaf order, or, if `count` is 0,
/// an inner node whose children are the nodes `first` and `first + 1`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node {
    pub bounds: Bounds,
    pub first: u32,
    pub count: u32,
}

impl Node {
    /// Returns the range of triangles of a leaf, in leaf order.
    pub fn range(&self) -> Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }
}

/// Triangle and its box, as input of the build.
#[derive(Debug, Clone, Copy)]
pub(super) struct Item {
    pub bounds: Bounds,
    pub triangle: u32,
}

/// Builds the BVH. Returns the nodes, root first (empty without items), and the triangles in leaf
/// order.
///
/// # Domain
/// Fewer than 2^31 items with finite boxes.
pub(super) fn build(mut items: Vec<Item>) -> (Vec<Node>, Vec<u32>) {
    let mut nodes = Vec::new();
    let mut open = Vec::new();
    if !items.is_empty() {
        nodes.push(node(Bounds::EMPTY, 0, 0));
        open.push((0, 0..items.len(), 0));
    }
    while let Some((index, range, depth)) = open.pop() {
        let part = &mut items[range.clone()];
        let mut bounds = Bounds::EMPTY;
        part.iter().for_each(|item| bounds.extend(&item.bounds));
        if part.len() <= LEAF_MAX {
            nodes[index] = node(bounds, range.start, part.len());
            continue;
        }
        let middle = range.start + split(part, depth);
        let first = nodes.len();
        nodes[index] = node(bounds, first, 0);
        nodes.extend([node(Bounds::EMPTY, 0, 0); 2]);
        open.push((first, range.start..middle, depth + 1));
        open.push((first + 1, middle..range.end, depth + 1));
    }
    (nodes, items.into_iter().map(|item| item.triangle).collect())
}

fn node(bounds: Bounds, first: usize, count: usize) -> Node {
    let index = |k: usize| u32::try_from(k).expect("a mesh has fewer than 2^31 triangles");
    Node { bounds, first: index(first), count: index(count) }
}

/// Partitions the items in two non-empty parts and returns the start of the second.
fn split(part: &mut [Item], depth: u32) -> usize {
    let (mut low, mut high) = (Vec3A::INFINITY, Vec3A::NEG_INFINITY);
    for item in part.iter() {
        let centroid = item.bounds.double_centroid();
        low = low.min(centroid);
        high = high.max(centroid);
    }
    let extent = high - low;
    let axis = if extent[0] >= extent[1] && extent[0] >= extent[2] {
        0
    } else if extent[1] >= extent[2] {
        1
    } else {
        2
    };
    let half = part.len() / 2;
    if depth >= MEDIAN_DEPTH {
        let key = |item: &Item| item.bounds.double_centroid()[axis];
        part.select_nth_unstable_by(half, |a, b| {
            key(a).total_cmp(&key(b)).then(a.triangle.cmp(&b.triangle))
        });
        return half;
    }
    let scale = BINS as f32 / extent[axis];
    if !scale.is_finite() {
        return half;
    }
    let bin = |item: &Item| {
        // Without `min` the highest centroid would get bin BINS.
        (((item.bounds.double_centroid()[axis] - low[axis]) * scale) as usize).min(BINS - 1)
    };
    let mut bins = [(Bounds::EMPTY, 0usize); BINS];
    for item in part.iter() {
        let (bounds, count) = &mut bins[bin(item)];
        bounds.extend(&item.bounds);
        *count += 1;
    }
    let cut = cheapest_cut(&bins);
    let mut middle = 0;
    for k in 0..part.len() {
        if bin(&part[k]) < cut {
            part.swap(k, middle);
            middle += 1;
        }
    }
    if middle == 0 || middle == part.len() { half } else { middle }
}

/// Returns the first bin of the second part for the split of least cost: area times count, summed
/// over both parts.
fn cheapest_cut(bins: &[(Bounds, usize); BINS]) -> usize {
    let mut costs = [f32::INFINITY; BINS];
    let (mut bounds, mut count) = (Bounds::EMPTY, 0);
    for cut in (1..BINS).rev() {
        bounds.extend(&bins[cut].0);
        count += bins[cut].1;
        if count > 0 {
            costs[cut] = bounds.area() * count as f32;
        }
    }
    let (mut bounds, mut count) = (Bounds::EMPTY, 0);
    let mut best = (f32::INFINITY, 1);
    for cut in 1..BINS {
        bounds.extend(&bins[cut - 1].0);
        count += bins[cut - 1].1;
        let cost = costs[cut] + bounds.area() * count as f32;
        if count > 0 && cost < best.0 {
            best = (cost, cut);
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the depth of the BVH. Asserts that boxes contain their children and that the leaves
    /// contain every item once.
    fn check(items: &[Item]) -> usize {
        let (nodes, order) = build(items.to_vec());
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, (0..items.len() as u32).collect::<Vec<_>>());
        let (mut max_depth, mut leaf_items) = (0, 0);
        let mut open = vec![(0usize, 1)];
        while let Some((index, depth)) = open.pop() {
            max_depth = max_depth.max(depth);
            let Node { bounds, first, count } = nodes[index];
            let inside: Vec<Bounds> = if count > 0 {
                leaf_items += count as usize;
                let leaf = &order[first as usize..(first + count) as usize];
                leaf.iter().map(|triangle| items[*triangle as usize].bounds).collect()
            } else {
                let children = [first as usize, first as usize + 1];
                open.extend(children.map(|child| (child, depth + 1)));
                children.map(|child| nodes[child].bounds).to_vec()
            };
            for part in inside {
                for axis in 0..3 {
                    assert!(bounds.low[axis] <= part.low[axis]);
                    assert!(bounds.high[axis] >= part.high[axis]);
                }
            }
        }
        assert_eq!(leaf_items, items.len());
        max_depth
    }

    fn items(count: u32, bounds: impl Fn(f32) -> ([f32; 3], [f32; 3])) -> Vec<Item> {
        (0..count)
            .map(|triangle| {
                let (low, high) = bounds(triangle as f32);
                let bounds = Bounds { low: low.into(), high: high.into() };
                Item { bounds, triangle }
            })
            .collect()
    }

    #[test]
    fn depth_is_bounded_when_boxes_are_equal_nested_or_clustered() {
        let cases = [
            items(1, |_| ([0.0; 3], [1.0; 3])),
            items(5000, |_| ([0.0; 3], [1.0; 3])),
            items(5000, |k| ([0.0; 3], [1.0 + k * 1e-4; 3])),
            items(5000, |k| ([k.sin(), k.cos(), 0.0], [1.0 + k.sin(), 1.0, 1.0])),
            // Each at half the distance of the previous: binning splits off one item at a time.
            items(5000, |k| ([(-k).exp2(), 0.0, 0.0], [(-k).exp2(), 0.1, 0.1])),
        ];
        for (case, items) in cases.iter().enumerate() {
            let depth = check(items);
            assert!(depth <= MEDIAN_DEPTH as usize + 14, "case {case}: {depth}");
        }
        assert!(build(Vec::new()).0.is_empty());
    }
}
