//! Nodes of the half vector around the normal, and the table of a material at them.

use std::f64::consts::{FRAC_PI_2, PI, SQRT_2};
use std::sync::LazyLock;

use brood_brdf::DirectionPair;
use glam::{DVec2, DVec3};

use crate::SampleSet;

/// Distance of the half vectors of each ring of nodes from the normal, as a chord: 2 sin(theta_h /
/// 2). Rings are dense near the normal, where highlights are.
const RINGS: [f64; 24] = [
    0.0, 0.003, 0.006, 0.0113, 0.016, 0.0226, 0.032, 0.045, 0.064, 0.09, 0.128, 0.17, 0.22, 0.27,
    0.32, 0.42, 0.52, 0.62, 0.72, 0.82, 0.93, 1.06, 1.22, SQRT_2,
];
const RINGS_F32: [f32; RINGS.len()] = {
    let mut rings = [0.0; RINGS.len()];
    let mut k = 0;
    while k < RINGS.len() {
        rings[k] = RINGS[k] as f32;
        k += 1;
    }
    rings
};
const RING_BELOW: RingBelow = RingBelow::new(&RINGS_F32);
/// Nodes of a ring, at equal angles around the normal.
const SECTORS: usize = 16;
/// Number of nodes, a multiple of [`NODES_TOGETHER`].
pub const NODES: usize = RINGS.len() * SECTORS;
/// Number of nodes that are summed together.
pub const NODES_TOGETHER: usize = 64;
const _: () = assert!(NODES.is_multiple_of(NODES_TOGETHER));
/// Number of tabulated angles to the eye, at equal distances from 0 to 90 degrees.
const ROWS: usize = 33;
/// Cosine of the last angle to the eye: that of silhouettes.
pub(super) const COS_MIN: f64 = 1e-4;
/// Places of the two Gauss points of an interval of length 1.
const GAUSS: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];

/// Rings below chords, looked up by bins of chords.
pub(super) struct RingBelow([u8; 92]);

/// Bins of chords per unit.
const BINS: f32 = 64.0;

impl RingBelow {
    /// Tabulates rings of ascending chords.
    pub(super) const fn new(chords: &[f32]) -> Self {
        let mut below = [0; 92];
        let mut bin = 0;
        while bin < below.len() {
            let mut ring = 0;
            while ring + 2 < chords.len() && chords[ring + 1] <= bin as f32 / BINS {
                ring += 1;
            }
            below[bin] = ring as u8;
            bin += 1;
        }
        Self(below)
    }

    /// Returns the last ring that is not beyond a chord within [0, sqrt(2)], and not the last of
    /// all.
    #[inline(always)]
    pub(super) fn of(&self, chords: &[f32], chord: f32) -> usize {
        let mut ring = usize::from(self.0[((chord * BINS) as usize).min(self.0.len() - 1)]);
        while ring + 2 < chords.len() && chord >= chords[ring + 1] {
            ring += 1;
        }
        ring
    }
}

/// Nodes of half vectors around the normal.
pub(super) trait Nodes {
    /// Returns x, y and z of the half vectors of the nodes; the eye is in the plane of x and z.
    fn half_parts(&self) -> [&[f32]; 3];

    /// Returns the four nodes around a half vector, and the share of each.
    ///
    /// # Domain
    /// Chord between normal and half vector, and its turn about the normal from the eye, as a share
    /// of a full turn within [0, 1].
    fn around(&self, chord: f32, turn: f32) -> ([usize; 4], [f32; 4]);
}

/// Nodes of all tabulated angles to the eye, the same for every material and scene.
#[derive(Debug)]
pub struct LobeNodes {
    /// Directions at which materials are evaluated, row by row.
    set: SampleSet,
    /// One for each direction.
    points: Vec<CellPoint>,
    rows: Vec<Row>,
    /// Half vectors of the nodes: x, y and z.
    half: [[f32; NODES]; 3],
}

/// Directions and nodes of one angle to the eye.
#[derive(Debug)]
struct Row {
    /// End of its directions.
    end: usize,
    /// Number of nodes above the horizon, which come first.
    nodes: usize,
    /// Spacing of incident directions around each node, in radians.
    spacings: [f64; NODES],
    /// Integral of cos_i over the tent of each node: its value for a reflectance of 1.
    weights: [f32; NODES],
}

/// Direction at which materials are evaluated, and its cell.
#[derive(Debug)]
struct CellPoint {
    nodes: [usize; 4],
    /// cos_i times solid angle, shared among the nodes.
    weights: [f32; 4],
}

/// A material at the nodes: f cos_i times the solid angle of each node.
#[derive(Debug, Clone, PartialEq)]
pub struct LobeTable {
    /// Per row red, green and blue; per channel the nodes.
    values: Vec<f32>,
}

impl LobeNodes {
    /// Returns the nodes.
    #[must_use]
    pub fn get() -> &'static Self {
        static NODES: LazyLock<LobeNodes> = LazyLock::new(LobeNodes::new);
        &NODES
    }

    fn new() -> Self {
        let (mut pairs, mut points, mut rows) = (Vec::new(), Vec::new(), Vec::new());
        for row in 0..ROWS {
            let wo = eye(row);
            let mut nodes = 0;
            for ring in 0..RINGS.len() - 1 {
                for ((sector, place), h, area) in cell_points(ring) {
                    let along = wo.dot(h);
                    let wi = h * (2.0 * along) - wo;
                    if along <= 0.0 || wi.z <= 0.0 {
                        continue;
                    }
                    let wi = wi.normalize();
                    let Ok(pair) = DirectionPair::new(wi, wo) else { continue };
                    pairs.push(pair);
                    let weight = (4.0 * along * area * wi.z) as f32;
                    let (around, shares) = corners((ring, sector), place);
                    points.push(CellPoint {
                        nodes: around,
                        weights: shares.map(|share| share * weight),
                    });
                    nodes = (ring + 2) * SECTORS;
                }
            }
            let spacing = |node: usize| {
                let area = node_area(node / SECTORS);
                (4.0 * wo.dot(half(node)).max(0.0) * area).sqrt()
            };
            let spacings = std::array::from_fn(spacing);
            rows.push(Row { end: pairs.len(), nodes, spacings, weights: [0.0; NODES] });
        }
        let set = SampleSet::from_pairs(&pairs, &[]);
        let mut parts = [[0.0; NODES]; 3];
        for (axis, part) in parts.iter_mut().enumerate() {
            for (node, into) in part.iter_mut().enumerate() {
                *into = half(node)[axis] as f32;
            }
        }
        let mut nodes = Self { set, points, rows, half: parts };
        let even = nodes.table(&vec![1.0; 3 * nodes.set.len()]);
        for (row, into) in nodes.rows.iter_mut().enumerate() {
            into.weights = *even.channel(row, 0);
        }
        nodes
    }

    /// Returns the directions at which a material is evaluated for [`Self::table`].
    #[must_use]
    pub fn set(&self) -> &SampleSet {
        &self.set
    }

    /// Tabulates a material.
    ///
    /// # Shapes
    /// `f`: red, green and blue at each direction of [`Self::set`].
    ///
    /// # Panics
    /// If `f` has another length.
    #[must_use]
    pub fn table(&self, f: &[f32]) -> LobeTable {
        let count = self.set.len();
        assert_eq!(f.len(), 3 * count, "one reflectance for each channel and direction");
        let mut values = vec![0.0; ROWS * 3 * NODES];
        let mut start = 0;
        for (row, into) in self.rows.iter().zip(values.chunks_exact_mut(3 * NODES)) {
            for (channel, into) in into.chunks_exact_mut(NODES).enumerate() {
                let f = &f[channel * count..][start..row.end];
                for (point, f) in self.points[start..row.end].iter().zip(f) {
                    for (node, weight) in point.nodes.iter().zip(point.weights) {
                        into[*node] += weight * f;
                    }
                }
            }
            start = row.end;
        }
        LobeTable { values }
    }

    /// Returns the row below an angle to the eye, and the distance from it towards the next.
    ///
    /// # Domain
    /// `cos_o` within [0, 1].
    pub(super) fn row(cos_o: f64) -> (usize, f32) {
        let at = libm::acos(cos_o.clamp(0.0, 1.0)) / FRAC_PI_2 * (ROWS - 1) as f64;
        let row = (at as usize).min(ROWS - 2);
        (row, ((at - row as f64) as f32).clamp(0.0, 1.0))
    }

    /// Returns the number of nodes that a row and the next have, rounded up to a multiple of
    /// [`NODES_TOGETHER`].
    pub(super) fn count(&self, row: usize) -> usize {
        let nodes = self.rows[row].nodes.max(self.rows[row + 1].nodes);
        nodes.next_multiple_of(NODES_TOGETHER).min(NODES)
    }

    /// Returns the spacing of incident directions around each node of a row, in radians.
    pub(super) fn spacings(&self, row: usize) -> [f64; NODES] {
        self.rows[row].spacings
    }

    /// Returns the integral of cos_i over the tent of each node, at a distance from a row towards
    /// the next.
    #[inline(always)]
    pub(super) fn weights(&self, row: usize, distance: f32) -> [f32; NODES] {
        let (own, next) = (&self.rows[row].weights, &self.rows[row + 1].weights);
        let mut weights = [0.0; NODES];
        for k in 0..NODES {
            weights[k] = own[k] + (next[k] - own[k]) * distance;
        }
        weights
    }

    /// Number of rows.
    pub(super) const ROWS: usize = ROWS;
}

impl Nodes for LobeNodes {
    fn half_parts(&self) -> [&[f32]; 3] {
        [&self.half[0], &self.half[1], &self.half[2]]
    }

    #[inline(always)]
    fn around(&self, chord: f32, turn: f32) -> ([usize; 4], [f32; 4]) {
        let chord = chord.clamp(0.0, RINGS_F32[RINGS.len() - 1]);
        let ring = RING_BELOW.of(&RINGS_F32, chord);
        let outwards = (chord - RINGS_F32[ring]) / (RINGS_F32[ring + 1] - RINGS_F32[ring]);
        let at = turn * SECTORS as f32;
        let sector = at as usize;
        corners((ring, sector), [outwards, at - sector as f32])
    }
}

impl LobeTable {
    /// Size in memory in bytes.
    pub const BYTES: usize = ROWS * 3 * NODES * size_of::<f32>();

    /// Returns the values of a channel in a row.
    ///
    /// # Panics
    /// If there is no such row or channel.
    #[must_use]
    #[inline(always)]
    pub fn channel(&self, row: usize, channel: usize) -> &[f32; NODES] {
        let values = &self.values[(3 * row + channel) * NODES..][..NODES];
        values.try_into().expect("the slice has the length of a channel")
    }
}

/// Returns the nodes at the corners of a cell, and their bilinear shares at a place of the cell:
/// from its ring to the next, and from its sector to the next. The sector after the last is the
/// first.
#[inline(always)]
fn corners(
    (ring, sector): (usize, usize),
    [outwards, onwards]: [f32; 2],
) -> ([usize; 4], [f32; 4]) {
    let (own, next) = (sector % SECTORS, (sector + 1) % SECTORS);
    let (inner, outer) = (ring * SECTORS, (ring + 1) * SECTORS);
    let nodes = [inner + own, inner + next, outer + own, outer + next];
    let shares = [
        (1.0 - outwards) * (1.0 - onwards),
        (1.0 - outwards) * onwards,
        outwards * (1.0 - onwards),
        outwards * onwards,
    ];
    (nodes, shares)
}

/// Direction to the eye of a row.
fn eye(row: usize) -> DVec3 {
    let angle = FRAC_PI_2 * row as f64 / (ROWS - 1) as f64;
    let cos = libm::cos(angle).max(COS_MIN);
    DVec3::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos)
}

/// Half vector of a node.
fn half(node: usize) -> DVec3 {
    let turn = 2.0 * PI * (node % SECTORS) as f64 / SECTORS as f64;
    half_vector(RINGS[node / SECTORS], turn)
}

/// Half vector at a chord from the normal, turned about it from the eye by an angle in radians.
pub(super) fn half_vector(chord: f64, turn: f64) -> DVec3 {
    let level = chord * (1.0 - 0.25 * chord * chord).sqrt();
    (DVec2::new(libm::cos(turn), libm::sin(turn)) * level).extend(1.0 - 0.5 * chord * chord)
}

/// Solid angle of half vectors around a node: the area between circles of two chords is pi times
/// the difference of their squares.
fn node_area(ring: usize) -> f64 {
    let border = |a: usize, b: usize| 0.5 * (RINGS[a] + RINGS[b]);
    let inner = if ring == 0 { 0.0 } else { border(ring - 1, ring) };
    let outer = if ring + 1 == RINGS.len() { SQRT_2 } else { border(ring, ring + 1) };
    PI * (outer * outer - inner * inner) / SECTORS as f64
}

/// Points of the quadrature of all cells between a ring and the next: sector and place in the cell,
/// half vector, and solid angle. Two Gauss points outwards; the midpoint of a sector, which is as
/// good for functions that are smooth and periodic.
fn cell_points(ring: usize) -> impl Iterator<Item = ((usize, [f32; 2]), DVec3, f64)> {
    let (inner, outer) = (RINGS[ring], RINGS[ring + 1]);
    let step = 2.0 * PI / SECTORS as f64;
    (0..SECTORS).flat_map(move |sector| {
        GAUSS.into_iter().map(move |outwards| {
            let chord = inner + (outer - inner) * outwards;
            let h = half_vector(chord, (sector as f64 + 0.5) * step);
            let area = chord * (outer - inner) * step / 2.0;
            ((sector, [outwards as f32, 0.5]), h, area)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The weights of all nodes together are the integral of cos_i over the hemisphere.
    #[test]
    fn weights_of_each_row_sum_to_pi() {
        let nodes = LobeNodes::get();
        let table = nodes.table(&vec![1.0; 3 * nodes.set().len()]);
        for row in 0..ROWS {
            let sum: f32 = table.channel(row, 1).iter().sum();
            let bound = if row < ROWS - 3 { 0.02 } else { 0.15 };
            assert!((f64::from(sum) / PI - 1.0).abs() < bound, "{row} {sum}");
        }
    }
}
