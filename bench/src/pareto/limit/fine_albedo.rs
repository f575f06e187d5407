//! Directional albedo by quadratures that share nothing with the search of the energy limit.
//!
//! A program is summed over a Fibonacci lattice of outgoing directions, distributed as cos_o. A
//! layer is integrated by adaptive subdivision over the slopes of the half vector, cut off exactly
//! at the horizon, without any knowledge of the layer.

use std::f64::consts::{PI, TAU};

use brood_brdf::{Block, DirectionPair, PreparedModel};
use brood_eval::{CanonicalEvaluator, Evaluator, Level, direction_pair};
use brood_program::Program;
use brood_scene::SampleSet;
use glam::{DVec2, DVec3};

/// Number of nodes along each axis of a cell; their product is the number of lanes of a block.
const SIDE: usize = 8;
/// Nodes and weights of the Gauss-Legendre rule of order 8 on [0, 1].
const GAUSS: [(f64, f64); SIDE] = [
    (0.019_855_071_751_231_884, 0.050_614_268_145_188_13),
    (0.101_666_761_293_186_63, 0.111_190_517_226_687_24),
    (0.237_233_795_041_835_5, 0.156_853_322_938_943_64),
    (0.408_282_678_752_175_1, 0.181_341_891_689_181),
    (0.591_717_321_247_825, 0.181_341_891_689_181),
    (0.762_766_204_958_164_5, 0.156_853_322_938_943_64),
    (0.898_333_238_706_813_4, 0.111_190_517_226_687_24),
    (0.980_144_928_248_768_1, 0.050_614_268_145_188_13),
];
/// Scale below which slopes of the half vector have equal steps, above it equal ratios.
const SCALE: f64 = 1e-7;
/// Largest slope of the half vector.
const STEEPEST: f64 = 2e3;
/// Cells along each axis before the first subdivision.
const CELLS: usize = 6;
/// Largest number of halvings of a cell.
const HALVINGS: u32 = 16;

/// The golden ratio less 1.
const GOLDEN: f64 = 0.618_033_988_749_894_9;
/// Range of ln tan theta_h of the half vectors of a lattice.
const HALF_SPAN: (f64, f64) = (-11.5, 3.5);

/// Directions for programs: a Fibonacci lattice distributed as cos_o, and another one of half
/// vectors distributed evenly in ln tan theta_h. Both are weighted by the balance heuristic.
pub struct Lattice {
    even: Vec<DVec3>,
    halves: Vec<DVec3>,
}

impl Lattice {
    /// Creates `count` directions of each kind.
    pub fn new(count: usize) -> Self {
        let turn = |index: usize| libm::sincos(TAU * (index as f64 * GOLDEN).fract());
        let even = |index: usize| {
            let height = (1.0 - (index as f64 + 0.5) / count as f64).sqrt();
            let across = ((1.0 - height) * (1.0 + height)).sqrt();
            let (sin, cos) = turn(index);
            DVec3::new(across * cos, across * sin, height)
        };
        let half = |index: usize| {
            let (low, high) = HALF_SPAN;
            let tan = libm::exp(low + (high - low) * (index as f64 + 0.5) / count as f64);
            let (sin, cos) = turn(index);
            DVec3::new(tan * cos, tan * sin, 1.0).normalize()
        };
        Self { even: (0..count).map(even).collect(), halves: (0..count).map(half).collect() }
    }

    /// Pairs and weights of f for light from `wi`; half vectors only with `highlights`.
    fn nodes(&self, wi: DVec3, highlights: bool) -> impl Iterator<Item = (DirectionPair, f64)> {
        let count = self.even.len() as f64;
        let of_halves = self.halves.iter().take(if highlights { usize::MAX } else { 0 });
        let mirrored = of_halves.map(move |half| 2.0 * wi.dot(*half) * *half - wi);
        let all = self.even.iter().copied().chain(mirrored);
        all.filter(|wo| wo.z > 0.0).map(move |wo| {
            let sum = wi + wo;
            let cos_d = 0.5 * sum.length();
            let half = sum / (2.0 * cos_d);
            let sin2 = half.x * half.x + half.y * half.y;
            let tan2 = sin2 / (half.z * half.z);
            let (low, high) = HALF_SPAN;
            let is_within = (2.0 * low..2.0 * high).contains(&libm::log(tan2));
            let of_half = 1.0 / (TAU * (high - low) * sin2 * half.z * 4.0 * cos_d);
            let density = wo.z / PI + if highlights && is_within { of_half } else { 0.0 };
            (direction_pair(wi, wo), wo.z / (count * density))
        })
    }
}

/// Samples of a lattice for some incident directions, each at a texture position.
pub struct LatticeSamples {
    set: SampleSet,
    weights: Vec<f64>,
    ends: Vec<usize>,
}

impl LatticeSamples {
    /// Creates the samples.
    pub fn new(incident: &[(DVec3, DVec2)], lattice: &Lattice, highlights: bool) -> Self {
        let (mut pairs, mut uvs, mut weights) = (Vec::new(), Vec::new(), Vec::new());
        let mut ends = Vec::new();
        for (wi, uv) in incident {
            for (pair, weight) in lattice.nodes(*wi, highlights) {
                pairs.push(pair);
                weights.push(weight);
            }
            uvs.resize(pairs.len(), *uv);
            ends.push(pairs.len());
        }
        Self { set: SampleSet::from_pairs(&pairs, &uvs), weights, ends }
    }

    /// Albedo of each channel of a program for each incident direction.
    pub fn albedos(&self, program: &Program) -> Vec<DVec3> {
        let mut f = Vec::new();
        CanonicalEvaluator::default()
            .eval(&[program], &self.set, &mut f)
            .expect("the CPU runs every program");
        let mut start = 0;
        let mut next = |end: &usize| {
            let range = start..*end;
            start = *end;
            DVec3::from([0, 1, 2].map(|channel| {
                let f = &f[channel * self.weights.len()..][range.clone()];
                f.iter().zip(&self.weights[range.clone()]).map(|(f, w)| f64::from(*f) * w).sum()
            }))
        };
        self.ends.iter().map(&mut next).collect()
    }
}

/// A rectangle of shares of the ranges of both slopes.
#[derive(Clone, Copy)]
struct Cell {
    low: DVec2,
    size: DVec2,
}

/// Adaptive integral of one layer over the slopes of the half vector.
pub struct Adaptive<'a> {
    model: &'a PreparedModel,
    level: Level,
    wi: DVec3,
    /// Absolute error allowed in a cell.
    tolerance: f64,
    block: Block<{ SIDE * SIDE }>,
}

impl<'a> Adaptive<'a> {
    /// Albedo of each channel for light from `wi`; negative values of f count as 0. Cells are split
    /// until that changes their integral by less than `tolerance` times the albedo.
    pub fn albedo(model: &'a PreparedModel, level: Level, wi: DVec3, tolerance: f64) -> DVec3 {
        let mut own = Self { model, level, wi, tolerance: f64::INFINITY, block: Block::new() };
        let size = DVec2::splat(1.0 / CELLS as f64);
        let cell = |index: usize| {
            let corner = DVec2::new((index / CELLS) as f64, (index % CELLS) as f64);
            Cell { low: corner * size, size }
        };
        let first: Vec<DVec3> = (0..CELLS * CELLS).map(|index| own.estimate(cell(index))).collect();
        let total: DVec3 = first.iter().sum();
        own.tolerance = tolerance * total.max_element().max(f64::MIN_POSITIVE);
        let cells = first.into_iter().enumerate();
        cells.map(|(index, whole)| own.refined(cell(index), whole, HALVINGS)).sum()
    }

    /// Integral over a cell, given its estimate: quarters are refined until they agree with it.
    fn refined(&mut self, cell: Cell, whole: DVec3, halvings: u32) -> DVec3 {
        let size = 0.5 * cell.size;
        let quarters = [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE]
            .map(|corner| Cell { low: cell.low + corner * size, size });
        let parts = quarters.map(|quarter| self.estimate(quarter));
        let sum: DVec3 = parts.iter().sum();
        if (sum - whole).abs().max_element() <= self.tolerance || halvings == 0 {
            return sum;
        }
        let parts = quarters.into_iter().zip(parts);
        parts.map(|(quarter, part)| self.refined(quarter, part, halvings - 1)).sum()
    }

    fn upright(&self) -> DirectionPair {
        direction_pair(self.wi, DVec3::Z)
    }

    /// Range of asinh(y / SCALE) above the horizon for a slope along x, or of x for `None`.
    fn range(&self, x: Option<f64>) -> (f64, f64) {
        let wi = self.wi;
        // wo_z > 0 where (1 - s^2) wi_z + 2 (wi_x s_x + wi_y s_y) > 0; rows are solved for s_y, the
        // whole for the least and largest s_x of any row.
        let (low, high) = match x {
            Some(x) => {
                let (half_sum, product) = (wi.y / wi.z, x * x - 2.0 * (wi.x / wi.z) * x - 1.0);
                let root = (half_sum * half_sum - product).max(0.0).sqrt();
                match half_sum >= 0.0 {
                    true => (product / (half_sum + root), half_sum + root),
                    false => (half_sum - root, product / (half_sum - root)),
                }
            }
            None => {
                let side = (wi.y * wi.y + wi.z * wi.z) / (wi.z * wi.z);
                let (plus, minus) = ((1.0 + wi.x) / wi.z, (1.0 - wi.x) / wi.z);
                match wi.x >= 0.0 {
                    true => (-side / plus, plus),
                    false => (-minus, side / minus),
                }
            }
        };
        let place = |slope: f64| libm::asinh(slope.clamp(-STEEPEST, STEEPEST) / SCALE);
        (place(low), place(high).max(place(low)))
    }

    /// Estimates the integral over a cell.
    fn estimate(&mut self, cell: Cell) -> DVec3 {
        let mut pairs = [self.upright(); SIDE * SIDE];
        let mut weights = [0.0; SIDE * SIDE];
        let (left, right) = self.range(None);
        let slope = |t: f64| {
            let (up, down) = (libm::exp(t), libm::exp(-t));
            (0.5 * SCALE * (up - down), 0.5 * SCALE * (up + down))
        };
        for (row, (across, by_across)) in GAUSS.into_iter().enumerate() {
            let t = left + (right - left) * (cell.low.x + cell.size.x * across);
            let (x, step_x) = slope(t);
            let (low, high) = self.range(Some(x));
            for (column, (along, by_along)) in GAUSS.into_iter().enumerate() {
                let t = low + (high - low) * (cell.low.y + cell.size.y * along);
                let (y, step_y) = slope(t);
                let half = DVec3::new(x, y, 1.0).normalize();
                let cos_d = self.wi.dot(half);
                let wo = 2.0 * cos_d * half - self.wi;
                let steps = step_x * step_y * (right - left) * (high - low);
                let area = steps * cell.size.x * cell.size.y * by_across * by_along;
                let weight = 4.0 * cos_d.max(0.0) * wo.z.max(0.0) * area * half.z.powi(3);
                let pair = DirectionPair::new(self.wi, wo);
                pairs[row * SIDE + column] = pair.expect("a mirrored unit vector has length 1");
                weights[row * SIDE + column] = weight;
            }
        }
        self.block.fill(self.level, &pairs);
        let f = self.model.f_block(self.level, &self.block);
        let mut sum = DVec3::ZERO;
        for (index, weight) in weights.iter().enumerate() {
            let value = DVec3::new(f[0][index], f[1][index], f[2][index]);
            sum += value.clamp(DVec3::ZERO, DVec3::splat(65504.0 * 65504.0)) * *weight;
        }
        sum
    }
}
