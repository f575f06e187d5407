//! Error and normal equations of a fit: sums over the blocks of a batch, assembled for the free
//! parameters.

use brood_eval::Level;
use brood_genome::lobes::Shape;
use rayon::prelude::*;

use super::Lobes;
use super::batch::Batch;
use super::block::Block;
use super::shape::Place;
use super::sweep::{Parameters, Sums, Sweep, Workspace, slots};
use crate::levenberg_marquardt::NormalEquations;

/// Number of blocks per task. Sums are added within a task first, then across tasks in order, so
/// that the bits do not depend on the number of threads.
const TOGETHER: usize = 4;

/// The objective that fits minimise: mean of the weighted squared differences, plus ridge and
/// albedo penalties.
///
/// # Error
/// Bit-identical for any number of threads.
pub(super) fn error(lobes: &Lobes, batch: &Batch) -> f64 {
    let sum = sum_of_blocks(lobes, batch, |squares, _| squares);
    sum / batch.total + ridge(lobes, batch) + above(lobes, batch)
}

/// E_log: root of the weighted mean squared difference of ln(1 + f cos_i), without the other terms.
/// Bounds in the batch count.
pub(super) fn e_log(lobes: &Lobes, batch: &Batch) -> f64 {
    let sum = sum_of_blocks(lobes, batch, |_, workspace| workspace.logarithmic());
    (sum / batch.total).sqrt()
}

/// Sum of a value of each block. `of` takes the block's sum of squares and the workspace after the
/// sweep.
fn sum_of_blocks(lobes: &Lobes, batch: &Batch, of: impl Fn(f64, &Workspace) -> f64 + Sync) -> f64 {
    let (parameters, level, gain) = (Parameters::new(lobes), Level::best(), batch.gain);
    let task = |blocks: &[Block]| {
        let mut workspace = Workspace::new(&parameters.shape);
        let mut sum = 0.0;
        for block in blocks {
            let squares = level.run(Sweep {
                parameters: &parameters,
                block,
                gain,
                workspace: &mut workspace,
                sums: None,
            });
            sum += of(squares, &workspace);
        }
        sum
    };
    let parts: Vec<f64> = batch.blocks.par_chunks(TOGETHER).map(task).collect();
    parts.iter().sum()
}

/// Weighted squared differences of each sample, summed over its channels; 0 for bounds that hold.
///
/// # Shapes
/// One per sample of the batch, padded to a whole number of blocks.
pub(super) fn excesses(lobes: &Lobes, batch: &Batch) -> Vec<f32> {
    let (parameters, level, gain) = (Parameters::new(lobes), Level::best(), batch.gain);
    let task = |block: &Block| {
        let mut workspace = Workspace::new(&parameters.shape);
        level.run(Sweep {
            parameters: &parameters,
            block,
            gain,
            workspace: &mut workspace,
            sums: None,
        });
        workspace.squares()
    };
    batch.blocks.par_iter().flat_map_iter(task).collect()
}

fn ridge(lobes: &Lobes, batch: &Batch) -> f64 {
    let parameters = batch.ridge.iter().zip(&lobes.parameters);
    batch.cost * parameters.map(|(ridge, value)| ridge * value * value).sum::<f64>()
}

/// Albedo penalty.
fn above(lobes: &Lobes, batch: &Batch) -> f64 {
    batch.albedos.as_ref().map_or(0.0, |albedos| albedos.cost(lobes))
}

/// Returns the normal equations and the same error as [`error`].
pub(super) fn normal_equations(lobes: &Lobes, batch: &Batch) -> (NormalEquations, f64) {
    let (parameters, level, gain) = (Parameters::new(lobes), Level::best(), batch.gain);
    let task = |blocks: &[Block]| {
        let mut workspace = Workspace::new(&parameters.shape);
        let mut sums = Sums::zero(&parameters.shape);
        for block in blocks {
            let (workspace, sums_now) = (&mut workspace, Some(&mut sums));
            let error = level.run(Sweep {
                parameters: &parameters,
                block,
                gain,
                workspace,
                sums: sums_now,
            });
            sums.error += error;
        }
        sums
    };
    let parts: Vec<Sums> = batch.blocks.par_chunks(TOGETHER).map(task).collect();
    let mut sums = Sums::zero(&parameters.shape);
    for part in &parts {
        sums.add(part);
    }
    let mut normal = assemble(lobes, &sums);
    let count = normal.gradient.len();
    let free = (0..lobes.parameters.len()).filter(|at| lobes.free[*at]);
    for (at, index) in free.enumerate() {
        let Some(ridge) = batch.ridge.get(index) else { break };
        let cost = batch.cost * batch.total * ridge;
        normal.matrix[at * count + at] += cost;
        normal.gradient[at] += cost * lobes.parameters[index];
    }
    let above = batch.albedos.as_ref().map(|albedos| albedos.add(lobes, &mut normal, batch.total));
    (normal, sums.error / batch.total + ridge(lobes, batch) + above.unwrap_or(0.0))
}

/// Normal equations of the free parameters.
fn assemble(lobes: &Lobes, sums: &Sums) -> NormalEquations {
    let shape = &lobes.shape;
    let places: Vec<Place> = Place::all(shape)
        .into_iter()
        .zip(&lobes.free)
        .filter_map(|(place, free)| free.then_some(place))
        .collect();
    let count = places.len();
    let mut normal = NormalEquations::zero(count);
    for (row, a) in places.iter().enumerate() {
        normal.gradient[row] = gradient(shape, sums, *a);
        for (column, b) in places[..=row].iter().enumerate() {
            let value = entry(shape, sums, *a, *b);
            normal.matrix[row * count + column] = value;
            normal.matrix[column * count + row] = value;
        }
    }
    normal
}

/// Entry of J^T J for two parameters. The derivative by log2 C of a term is, in its channel, that
/// by the term's slot, because both scale C e; in the other channels it is 0.
fn entry(shape: &Shape, sums: &Sums, a: Place, b: Place) -> f64 {
    let (features, slots) = (shape.features(), slots(shape));
    let one = features - 1;
    match (a, b) {
        (Place::Slot { slot: p, feature: k }, Place::Slot { slot: q, feature: l }) => {
            let row = upper(features, k.min(l), k.max(l));
            sums.slots[row * sums.widths[0] + upper(slots, p.min(q), p.max(q))]
        }
        (Place::Colour { channel, term }, Place::Slot { slot, feature })
        | (Place::Slot { slot, feature }, Place::Colour { channel, term }) => {
            sums.rest[((channel * shape.terms + term) * slots + slot) * sums.widths[1] + feature]
        }
        (Place::Colour { channel, term }, Place::Colour { channel: other, term: slot }) => {
            if channel != other {
                return 0.0;
            }
            sums.rest[((channel * shape.terms + term) * slots + slot) * sums.widths[1] + one]
        }
    }
}

/// Entry of J^T r for a parameter.
fn gradient(shape: &Shape, sums: &Sums, place: Place) -> f64 {
    let (features, slots, terms) = (shape.features(), slots(shape), shape.terms);
    match place {
        Place::Slot { slot, feature } => {
            sums.rest[(3 * terms * slots + slot) * sums.widths[1] + feature]
        }
        Place::Colour { channel, term } => {
            let row = 3 * terms * slots + slots + channel * terms + term;
            sums.rest[row * sums.widths[1] + features - 1]
        }
    }
}

/// Index of (a, b), a <= b < `count`, among the pairs (0, 0), (0, 1), ... (1, 1), ...
fn upper(count: usize, a: usize, b: usize) -> usize {
    a * count - a * (a + 1) / 2 + b
}

#[cfg(test)]
#[path = "normal_equations_tests.rs"]
mod tests;
