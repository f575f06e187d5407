//! One pass over a block of samples: values of the lobes, residuals, and products for the normal
//! equations.

use brood_eval::SimdKernel;
use brood_genome::Functions;
use brood_genome::lobes::Shape;

use super::Lobes;
use super::block::{Block, LANES, Row};
use super::product::{Transposed, add_products, sum};

/// Parameters as f32, as the machine has them.
pub(super) struct Parameters {
    pub(super) shape: Shape,
    values: Vec<f32>,
    /// [term][channel]: C.
    pub(super) factors: Vec<[f32; 3]>,
}

impl Parameters {
    #[expect(clippy::cast_possible_truncation, reason = "the machine is of f32")]
    pub(super) fn new(lobes: &Lobes) -> Self {
        let (shape, parameters) = (lobes.shape.clone(), &lobes.parameters);
        let factor = |term, channel| libm::exp2(parameters[shape.colour(term, channel)]) as f32;
        let factors = (0..shape.terms).map(|term| [0, 1, 2].map(|c| factor(term, c))).collect();
        let values = parameters.iter().map(|number| *number as f32).collect();
        Self { shape, values, factors }
    }
}

/// Sums over samples from which the normal equations are assembled.
pub(super) struct Sums {
    /// Sum of squared differences.
    pub(super) error: f64,
    /// [pair of features k <= k'][pair of slots p <= p']: products of slots.
    pub(super) slots: Vec<f64>,
    /// [row][feature]: sums of a product times the feature. Rows: for every channel and term the
    /// derivative by the colour times that by each slot; then for each slot the gradient, summed
    /// over channels; then for every channel and term the gradient of the colour (at feature 1).
    pub(super) rest: Vec<f64>,
    /// Row lengths of `slots` and `rest`: the pairs of slots and the features, padded.
    pub(super) widths: [usize; 2],
}

impl Sums {
    pub(super) fn zero(shape: &Shape) -> Self {
        let (slots, features, terms) = (slots(shape), shape.features(), shape.terms);
        let rows = 3 * terms * slots + slots + 3 * terms;
        let widths = [triangle(slots), features].map(|rows| Transposed::new(rows).width());
        Self {
            error: 0.0,
            slots: vec![0.0; widths[0] * triangle(features)],
            rest: vec![0.0; rows * widths[1]],
            widths,
        }
    }

    pub(super) fn add(&mut self, other: &Self) {
        self.error += other.error;
        for (sum, value) in self.slots.iter_mut().zip(&other.slots) {
            *sum += value;
        }
        for (sum, value) in self.rest.iter_mut().zip(&other.rest) {
            *sum += value;
        }
    }
}

/// Number of slots: the arguments of terms, then those of units.
pub(super) fn slots(shape: &Shape) -> usize {
    shape.terms + shape.units
}

/// Number of pairs (a, b), a <= b < `count`.
pub(super) fn triangle(count: usize) -> usize {
    count * (count + 1) / 2
}

/// Buffers for one block, reused for the next.
pub(super) struct Workspace {
    /// (u, x, 1).
    pub(super) features: Vec<Row>,
    /// Derivative of each unit by its argument.
    derivatives: Vec<Row>,
    pub(super) terms: Vec<Row>,
    /// [channel]: one residual that stands for both differences, with the same gradient products.
    pub(super) residuals: [Row; 3],
    /// [channel]: derivative of the residual by S.
    pub(super) by_result: [Row; 3],
    /// Squared differences, summed over channels.
    squares: Row,
    /// Squared differences of ln(1 + f cos_i) only.
    logarithmic: Row,
    /// [channel][slot]: derivative of the residual by the slot.
    pub(super) by_slot: Vec<Row>,
    /// Operands of [`add_products`].
    left: Vec<Row>,
    pairs: Transposed,
    transposed: Transposed,
    sums: Vec<f32>,
}

impl Workspace {
    pub(super) fn new(shape: &Shape) -> Self {
        let rows = |count: usize| vec![Row::ZERO; count];
        Self {
            features: rows(shape.features()),
            derivatives: rows(shape.units),
            terms: rows(shape.terms),
            residuals: [Row::ZERO; 3],
            by_result: [Row::ZERO; 3],
            squares: Row::ZERO,
            logarithmic: Row::ZERO,
            by_slot: rows(3 * slots(shape)),
            left: Vec::new(),
            pairs: Transposed::new(triangle(slots(shape))),
            transposed: Transposed::new(shape.features()),
            sums: Vec::new(),
        }
    }
}

impl Workspace {
    /// Squared differences of each sample, summed over its channels.
    pub(super) fn squares(&self) -> Vec<f32> {
        self.squares.0.to_vec()
    }

    /// Sum of the squared differences of ln(1 + f cos_i) only.
    pub(super) fn logarithmic(&self) -> f64 {
        sum(&self.logarithmic)
    }
}

/// Computes the sum of squared differences of a block, and adds to `sums` if present.
pub(super) struct Sweep<'a> {
    pub(super) parameters: &'a Parameters,
    pub(super) block: &'a Block,
    /// 1 / m of the batch.
    pub(super) gain: f32,
    pub(super) workspace: &'a mut Workspace,
    pub(super) sums: Option<&'a mut Sums>,
}

impl SimdKernel for Sweep<'_> {
    type Output = f64;

    #[inline(always)]
    fn run(mut self) -> f64 {
        self.forwards();
        self.residuals();
        if self.sums.is_some() {
            self.slots();
            self.products();
        }
        sum(&self.workspace.squares)
    }
}

impl Sweep<'_> {
    /// Evaluates units, then terms.
    #[inline(always)]
    pub(super) fn forwards(&mut self) {
        // Hidden from the compiler, which would otherwise rebuild the constants in every iteration.
        let functions = std::hint::black_box(Functions::KNOWN);
        let Parameters { shape, values, .. } = self.parameters;
        let Workspace { features, derivatives, terms, .. } = &mut *self.workspace;
        let (own, given) = features.split_at_mut(shape.units);
        given[..shape.inputs.len()].copy_from_slice(&self.block.inputs);
        given[shape.inputs.len()] = Row([1.0; LANES]);
        for (unit, (u, derivative)) in own.iter_mut().zip(derivatives).enumerate() {
            combine(u, &values[shape.unit(unit, 0)..][..given.len()], given);
            for lane in 0..LANES {
                let value = functions.spl(u.0[lane]);
                u.0[lane] = value;
                // 2^a / (1 + 2^a), where 1 + 2^a is 2^u.
                derivative.0[lane] = 1.0 - functions.ex2::<true>(-value);
            }
        }
        for (term, e) in terms.iter_mut().enumerate() {
            let weights = &values[shape.term(term, 0)..][..shape.features() - 1];
            combine(e, weights, &features[..weights.len()]);
            for value in &mut e.0 {
                *value = functions.ex2::<true>(*value);
            }
        }
    }

    /// Computes residuals, their derivatives by S, and squared differences.
    #[inline(always)]
    fn residuals(&mut self) {
        let functions = std::hint::black_box(Functions::KNOWN);
        let Block { weight, target, relative, importance, share, side, .. } = self.block;
        let Workspace { terms, residuals, by_result, squares, logarithmic, .. } =
            &mut *self.workspace;
        (*squares, *logarithmic) = (Row::ZERO, Row::ZERO);
        let gain = self.gain;
        for channel in 0..3 {
            let mut result = Row::ZERO;
            for (e, factors) in terms.iter().zip(&self.parameters.factors) {
                for lane in 0..LANES {
                    result.0[lane] += factors[channel] * e.0[lane];
                }
            }
            for lane in 0..LANES {
                let (s, w, counts) = (result.0[lane], weight.0[lane], importance.0[lane]);
                let whole = 1.0 + (s * s) * w;
                let found = std::f32::consts::LN_2 * functions.log2(whole);
                let difference = found - target[channel].0[lane];
                // An upper bound holds if the difference is negative, a lower bound if it is
                // positive. A bound that holds has no residual.
                let counts = if difference * side.0[lane] < 0.0 { 0.0 } else { counts };
                let (first, by_first) = (counts * difference, counts * (2.0 * (s * w)) / whole);
                let share = share.0[lane];
                let whole = 1.0 + gain * ((s * s) * w);
                let found = std::f32::consts::LN_2 * functions.log2(whole);
                let second = share * (found - relative[channel].0[lane]);
                let by_second = share * (gain * (2.0 * (s * w))) / whole;
                // One residual r with derivative j, such that j^2 and j r are the sums over both
                // differences. r is 0 where j is.
                let derivative = (by_first * by_first + by_second * by_second).sqrt();
                let both = by_first * first + by_second * second;
                residuals[channel].0[lane] = both / derivative.max(f32::MIN_POSITIVE);
                by_result[channel].0[lane] = derivative;
                squares.0[lane] += first * first + second * second;
                logarithmic.0[lane] += first * first;
            }
        }
    }

    /// Computes the derivatives of the residuals by the slots, by the chain rule through S.
    #[inline(always)]
    pub(super) fn slots(&mut self) {
        let Parameters { shape, values, factors } = self.parameters;
        let Workspace { derivatives, terms, by_result, by_slot, .. } = &mut *self.workspace;
        for (by_slot, (channel, by_result)) in
            by_slot.chunks_exact_mut(slots(shape)).zip(by_result.iter().enumerate())
        {
            let (by_term, by_unit) = by_slot.split_at_mut(shape.terms);
            for ((row, e), factors) in by_term.iter_mut().zip(terms.iter()).zip(factors) {
                let factor = std::f32::consts::LN_2 * factors[channel];
                for lane in 0..LANES {
                    row.0[lane] = by_result.0[lane] * (factor * e.0[lane]);
                }
            }
            for (unit, (row, derivative)) in by_unit.iter_mut().zip(derivatives.iter()).enumerate()
            {
                *row = Row::ZERO;
                for (term, by_term) in by_term.iter().enumerate() {
                    let weight = values[shape.term(term, unit)];
                    for lane in 0..LANES {
                        row.0[lane] += weight * by_term.0[lane];
                    }
                }
                for lane in 0..LANES {
                    row.0[lane] *= derivative.0[lane];
                }
            }
        }
    }

    /// Adds the products of derivatives, residuals and features to `sums`.
    #[inline(always)]
    fn products(&mut self) {
        let Some(sums) = &mut self.sums else { return };
        let shape = &self.parameters.shape;
        let (slots, terms) = (slots(shape), shape.terms);
        let Workspace {
            features, residuals, by_slot, left, pairs, transposed, sums: buffer, ..
        } = &mut *self.workspace;
        let by_slot = |channel: usize, slot: usize| &by_slot[channel * slots + slot];
        let mut at = 0;
        for a in 0..slots {
            for b in a..slots {
                pairs.set(at, &dot([0, 1, 2].map(|c| (by_slot(c, a), by_slot(c, b)))));
                at += 1;
            }
        }
        left.clear();
        for (k, a) in features.iter().enumerate() {
            left.extend(features[k..].iter().map(|b| product(a, b)));
            transposed.set(k, a);
        }
        add_products(left, pairs, &mut sums.slots, buffer);
        left.clear();
        for channel in 0..3 {
            for term in 0..terms {
                let colour = by_slot(channel, term);
                left.extend((0..slots).map(|slot| product(colour, by_slot(channel, slot))));
            }
        }
        for slot in 0..slots {
            left.push(dot([0, 1, 2].map(|c| (by_slot(c, slot), &residuals[c]))));
        }
        for (channel, residual) in residuals.iter().enumerate() {
            left.extend((0..terms).map(|term| product(by_slot(channel, term), residual)));
        }
        add_products(left, transposed, &mut sums.rest, buffer);
    }
}

/// Weighted sum of rows.
#[inline(always)]
fn combine(out: &mut Row, weights: &[f32], rows: &[Row]) {
    *out = Row::ZERO;
    for (weight, row) in weights.iter().zip(rows) {
        for lane in 0..LANES {
            out.0[lane] += weight * row.0[lane];
        }
    }
}

/// Lane-wise product of two rows.
#[inline(always)]
pub(super) fn product(a: &Row, b: &Row) -> Row {
    let mut out = Row::ZERO;
    for lane in 0..LANES {
        out.0[lane] = a.0[lane] * b.0[lane];
    }
    out
}

/// Lane-wise sum of the products of three pairs of rows, one per channel.
#[inline(always)]
fn dot(pairs: [(&Row, &Row); 3]) -> Row {
    let mut out = Row::ZERO;
    for (a, b) in pairs {
        for lane in 0..LANES {
            out.0[lane] += a.0[lane] * b.0[lane];
        }
    }
    out
}
