//! One pass over the nodes of a quadrature: what lobes reflect of each channel, and how that changes with the numbers.

use brood_eval::Work;

use super::batch::{LANES, Row};
use super::normal::{Place, places};
use super::product::sum;
use super::sweep::{Room, Sweep, product, slots};

/// The sum over a block of f times what each node counts.
pub(super) struct Flux<'a> {
    /// Its samples are the nodes; what each counts is their importance.
    pub(super) sweep: Sweep<'a>,
    /// [channel]: the slopes by all numbers, added to these where they are asked for.
    pub(super) slopes: Option<&'a mut [Vec<f64>; 3]>,
}

impl Work for Flux<'_> {
    type Done = [f64; 3];

    #[inline(always)]
    fn run(mut self) -> [f64; 3] {
        self.sweep.forwards();
        let reflected = self.results();
        if self.slopes.is_some() {
            self.sweep.slots();
            self.slopes();
        }
        reflected
    }
}

impl Flux<'_> {
    /// f = S^2 changes by 2 S for each S.
    #[inline(always)]
    fn results(&mut self) -> [f64; 3] {
        let Sweep { numbers, block, room, .. } = &mut self.sweep;
        let Room { terms, residuals, by_result, .. } = &mut **room;
        [0, 1, 2].map(|channel| {
            let mut result = Row::ZERO;
            for (e, factors) in terms.iter().zip(&numbers.factors) {
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
    fn slopes(&mut self) {
        let Some(slopes) = &mut self.slopes else { return };
        let shape = &self.sweep.numbers.shape;
        let Room { features, residuals, by_slot, .. } = &*self.sweep.room;
        let count = slots(shape);
        for (channel, slopes) in slopes.iter_mut().enumerate() {
            let rows: Vec<Row> = by_slot[channel * count..][..count]
                .iter()
                .map(|row| product(row, &residuals[channel]))
                .collect();
            for (slope, place) in slopes.iter_mut().zip(places(shape)) {
                *slope += match place {
                    Place::Slot { slot, feature } => sum(&product(&rows[slot], &features[feature])),
                    Place::Colour { channel: own, term } if own == channel => sum(&rows[term]),
                    Place::Colour { .. } => 0.0,
                };
            }
        }
    }
}
