//! One pass over a block of quadrature nodes: their part of the albedo of lobes, per channel, and
//! its gradient.

use brood_eval::SimdKernel;

use super::block::{LANES, Row};
use super::product::sum;
use super::shape::Place;
use super::sweep::{Sweep, Workspace, product, slots};

/// Sum over a block of f times the weight of each node.
pub(super) struct Flux<'a> {
    /// Sweep over the nodes as samples; their importance is the quadrature weight.
    pub(super) sweep: Sweep<'a>,
    /// [channel]: gradient by all parameters, added to if present.
    pub(super) gradients: Option<&'a mut [Vec<f64>; 3]>,
}

impl SimdKernel for Flux<'_> {
    type Output = [f64; 3];

    #[inline(always)]
    fn run(mut self) -> [f64; 3] {
        self.sweep.forwards();
        let reflected = self.results();
        if self.gradients.is_some() {
            self.sweep.slots();
            self.add_gradients();
        }
        reflected
    }
}

impl Flux<'_> {
    /// Sums q f over the nodes, q being the quadrature weight. Stores 2 q S, the derivative of
    /// q f = q S^2 by S, in `residuals`; and 1 in `by_result`, so that [`Sweep::slots`] computes
    /// derivatives of S.
    #[inline(always)]
    fn results(&mut self) -> [f64; 3] {
        let Sweep { parameters, block, workspace, .. } = &mut self.sweep;
        let Workspace { terms, residuals, by_result, .. } = &mut **workspace;
        [0, 1, 2].map(|channel| {
            let mut result = Row::ZERO;
            for (e, factors) in terms.iter().zip(&parameters.factors) {
                for lane in 0..LANES {
                    result.0[lane] += factors[channel] * e.0[lane];
                }
            }
            let mut reflected = Row::ZERO;
            for lane in 0..LANES {
                let counts = block.importance.0[lane] * result.0[lane];
                reflected.0[lane] = counts * result.0[lane];
                residuals[channel].0[lane] = 2.0 * counts;
            }
            by_result[channel] = Row([1.0; LANES]);
            sum(&reflected)
        })
    }

    #[inline(always)]
    fn add_gradients(&mut self) {
        let Some(gradients) = &mut self.gradients else { return };
        let shape = &self.sweep.parameters.shape;
        let Workspace { features, residuals, by_slot, .. } = &*self.sweep.workspace;
        let count = slots(shape);
        for (channel, gradient) in gradients.iter_mut().enumerate() {
            let rows: Vec<Row> = by_slot[channel * count..][..count]
                .iter()
                .map(|row| product(row, &residuals[channel]))
                .collect();
            for (derivative, place) in gradient.iter_mut().zip(Place::all(shape)) {
                *derivative += match place {
                    Place::Slot { slot, feature } => sum(&product(&rows[slot], &features[feature])),
                    Place::Colour { channel: own, term } if own == channel => sum(&rows[term]),
                    Place::Colour { .. } => 0.0,
                };
            }
        }
    }
}
