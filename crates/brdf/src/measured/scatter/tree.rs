//! k-d tree over points in space for nearest-neighbour queries.
//!
//! Independent of the meaning of the points.

use glam::DVec3;

/// Parts of at most this many points are searched linearly.
const LEAF: usize = 6;

/// Points in the order of the tree: the median of each part splits it.
pub(super) struct Tree {
    points: Vec<DVec3>,
    /// Split axis of each part, stored at its middle.
    axes: Vec<u8>,
}

/// The nearest points found, nearest first.
pub(super) struct Nearest<const K: usize> {
    /// Squared distances.
    pub(super) squares: [f64; K],
    /// Positions in the order of the tree.
    pub(super) positions: [usize; K],
    pub(super) count: usize,
}

impl<const K: usize> Nearest<K> {
    /// Squared distance at which a point is no longer among the nearest.
    fn limit(&self) -> f64 {
        if self.count < K { f64::INFINITY } else { self.squares[K - 1] }
    }

    /// Inserts a point in order of distance if it is among the nearest.
    fn offer(&mut self, square: f64, position: usize) {
        if square >= self.limit() {
            return;
        }
        let mut at = if self.count < K { self.count } else { K - 1 };
        self.count = (self.count + 1).min(K);
        while at > 0 && self.squares[at - 1] > square {
            (self.squares[at], self.positions[at]) = (self.squares[at - 1], self.positions[at - 1]);
            at -= 1;
        }
        (self.squares[at], self.positions[at]) = (square, position);
    }
}

impl Tree {
    /// Builds the tree. Also returns the index of the original point at each position.
    pub(super) fn new(points: &[DVec3]) -> (Self, Vec<usize>) {
        let mut order: Vec<usize> = (0..points.len()).collect();
        let mut axes = vec![0; points.len()];
        divide(points, &mut order, &mut axes);
        let points = order.iter().map(|index| points[*index]).collect();
        (Self { points, axes }, order)
    }

    pub(super) fn point(&self, position: usize) -> DVec3 {
        self.points[position]
    }

    /// Finds the nearest points to `at`. Deterministic for the same points in the same order.
    pub(super) fn nearest<const K: usize>(&self, at: DVec3) -> Nearest<K> {
        let mut found = Nearest { squares: [f64::INFINITY; K], positions: [0; K], count: 0 };
        self.search(at, (0, self.points.len()), &mut found);
        found
    }

    fn search<const K: usize>(
        &self,
        at: DVec3,
        (low, high): (usize, usize),
        found: &mut Nearest<K>,
    ) {
        if high - low <= LEAF {
            for position in low..high {
                found.offer(self.points[position].distance_squared(at), position);
            }
            return;
        }
        let middle = low.midpoint(high);
        let axis = usize::from(self.axes[middle]);
        let beyond = at[axis] - self.points[middle][axis];
        let (near, far) = if beyond < 0.0 {
            ((low, middle), (middle + 1, high))
        } else {
            ((middle + 1, high), (low, middle))
        };
        self.search(at, near, found);
        found.offer(self.points[middle].distance_squared(at), middle);
        if beyond * beyond < found.limit() {
            self.search(at, far, found);
        }
    }
}

/// Moves the median along the longest side of the bounding box to the middle, and recurses on both
/// halves.
fn divide(points: &[DVec3], order: &mut [usize], axes: &mut [u8]) {
    if order.len() <= LEAF {
        return;
    }
    let start = points[order[0]];
    let bounds = |(low, high): (DVec3, DVec3), index: &usize| {
        (low.min(points[*index]), high.max(points[*index]))
    };
    let (low, high) = order.iter().fold((start, start), bounds);
    let size = high - low;
    let longest = size.max_element();
    let axis = if size.x == longest {
        0
    } else if size.y == longest {
        1
    } else {
        2
    };
    let middle = 0_usize.midpoint(order.len());
    order.select_nth_unstable_by(middle, |a, b| {
        points[*a][axis].total_cmp(&points[*b][axis]).then(a.cmp(b))
    });
    axes[middle] = [0, 1, 2][axis];
    let (left, right) = order.split_at_mut(middle);
    let (left_axes, right_axes) = axes.split_at_mut(middle);
    divide(points, left, left_axes);
    divide(points, &mut right[1..], &mut right_axes[1..]);
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn point() -> impl Strategy<Value = DVec3> {
        // Some points share coordinates, some are equal.
        let part = prop_oneof![-1.0..1.0, Just(0.0), Just(0.5)];
        (part.clone(), part.clone(), part).prop_map(|(x, y, z)| DVec3::new(x, y, z))
    }

    proptest! {
        #[test]
                fn nearest_points_match_a_linear_search(
            points in prop::collection::vec(point(), 1..200),
            at in point(),
        ) {
            let (tree, order) = Tree::new(&points);
            let found = tree.nearest::<7>(at);
            let mut all: Vec<f64> = points.iter().map(|p| p.distance_squared(at)).collect();
            all.sort_by(f64::total_cmp);
            prop_assert_eq!(found.count, points.len().min(7));
            prop_assert_eq!(&found.squares[..found.count], &all[..found.count]);
            for k in 0..found.count {
                let point = points[order[found.positions[k]]];
                prop_assert_eq!(point, tree.point(found.positions[k]));
                prop_assert_eq!(point.distance_squared(at), found.squares[k]);
            }
        }
    }
}
