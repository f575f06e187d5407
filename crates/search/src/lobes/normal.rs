//! The normal equations of a fit: sums over blocks, put together for the numbers that are fitted.

use brood_eval::Level;
use rayon::prelude::*;

use super::batch::{Batch, Block};
use super::sweep::{Numbers, Room, Sums, Sweep, slots};
use super::{Lobes, Shape};

/// Blocks that one task takes, and whose sums are added before those of other tasks.
const TOGETHER: usize = 4;

/// J^T J and J^T r of the numbers that are fitted, in their order.
pub(super) struct Normal {
    /// Row by row, symmetric.
    pub(super) matrix: Vec<f64>,
    pub(super) gradient: Vec<f64>,
}

/// The mean of the squared differences, each times what it counts.
///
/// # Error
/// The same to the bit for any number of threads.
pub(super) fn error(lobes: &Lobes, batch: &Batch) -> f64 {
    let (numbers, level, gain) = (Numbers::new(lobes), Level::best(), batch.gain);
    let task = |blocks: &[Block]| {
        let mut room = Room::new(&numbers.shape);
        let mut sum = 0.0;
        for block in blocks {
            sum += level.run(Sweep { numbers: &numbers, block, gain, room: &mut room, sums: None });
        }
        sum
    };
    let parts: Vec<f64> = batch.blocks.par_chunks(TOGETHER).map(task).collect();
    parts.iter().sum::<f64>() / batch.total + ridge(lobes, batch) + above(lobes, batch)
}

/// E_log: the root of the mean of the squared differences of ln(1 + f cos_i) alone.
pub(super) fn e_log(lobes: &Lobes, batch: &Batch) -> f64 {
    let (numbers, level, gain) = (Numbers::new(lobes), Level::best(), batch.gain);
    let task = |blocks: &[Block]| {
        let mut room = Room::new(&numbers.shape);
        let mut sum = 0.0;
        for block in blocks {
            level.run(Sweep { numbers: &numbers, block, gain, room: &mut room, sums: None });
            sum += room.logarithmic();
        }
        sum
    };
    let parts: Vec<f64> = batch.blocks.par_chunks(TOGETHER).map(task).collect();
    (parts.iter().sum::<f64>() / batch.total).sqrt()
}

/// The squared differences of each sample, each times what it counts, summed over its channels.
///
/// # Shapes
/// One for each sample of the batch and as many as there are until its last block is full.
pub(super) fn excesses(lobes: &Lobes, batch: &Batch) -> Vec<f32> {
    let (numbers, level, gain) = (Numbers::new(lobes), Level::best(), batch.gain);
    let task = |block: &Block| {
        let mut room = Room::new(&numbers.shape);
        level.run(Sweep { numbers: &numbers, block, gain, room: &mut room, sums: None });
        room.squares()
    };
    batch.blocks.par_iter().flat_map_iter(task).collect()
}

fn ridge(lobes: &Lobes, batch: &Batch) -> f64 {
    let numbers = batch.ridge.iter().zip(&lobes.numbers);
    batch.cost * numbers.map(|(ridge, number)| ridge * number * number).sum::<f64>()
}

/// What reflecting more than there is costs.
fn above(lobes: &Lobes, batch: &Batch) -> f64 {
    batch.albedos.as_ref().map_or(0.0, |albedos| albedos.cost(lobes))
}

/// The normal equations, and the same error.
pub(super) fn normal(lobes: &Lobes, batch: &Batch) -> (Normal, f64) {
    let (numbers, level, gain) = (Numbers::new(lobes), Level::best(), batch.gain);
    let task = |blocks: &[Block]| {
        let mut room = Room::new(&numbers.shape);
        let mut sums = Sums::zero(&numbers.shape);
        for block in blocks {
            let (room, sums_now) = (&mut room, Some(&mut sums));
            let error = level.run(Sweep { numbers: &numbers, block, gain, room, sums: sums_now });
            sums.error += error;
        }
        sums
    };
    let parts: Vec<Sums> = batch.blocks.par_chunks(TOGETHER).map(task).collect();
    let mut sums = Sums::zero(&numbers.shape);
    for part in &parts {
        sums.add(part);
    }
    let mut normal = assemble(lobes, &sums);
    let count = normal.gradient.len();
    let free = (0..lobes.numbers.len()).filter(|at| lobes.free[*at]);
    for (at, number) in free.enumerate() {
        let Some(ridge) = batch.ridge.get(number) else { break };
        let cost = batch.cost * batch.total * ridge;
        normal.matrix[at * count + at] += cost;
        normal.gradient[at] += cost * lobes.numbers[number];
    }
    let above = batch.albedos.as_ref().map(|albedos| albedos.add(lobes, &mut normal, batch.total));
    (normal, sums.error / batch.total + ridge(lobes, batch) + above.unwrap_or(0.0))
}

/// Where a number stands: a slot's feature, or a colour.
#[derive(Clone, Copy)]
pub(super) enum Place {
    Slot { slot: usize, feature: usize },
    Colour { channel: usize, term: usize },
}

fn assemble(lobes: &Lobes, sums: &Sums) -> Normal {
    let shape = &lobes.shape;
    let places: Vec<Place> = places(shape)
        .into_iter()
        .zip(&lobes.free)
        .filter_map(|(place, free)| free.then_some(place))
        .collect();
    let count = places.len();
    let mut normal = Normal { matrix: vec![0.0; count * count], gradient: vec![0.0; count] };
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

/// In the order of the numbers.
pub(super) fn places(shape: &Shape) -> Vec<Place> {
    let mut places = Vec::with_capacity(shape.len());
    for unit in 0..shape.units {
        // Of the features (u, x, 1) a unit takes x and 1.
        let features = shape.units..shape.features();
        let slot = shape.terms + unit;
        places.extend(features.map(|feature| Place::Slot { slot, feature }));
    }
    for slot in 0..shape.terms {
        places.extend((0..shape.features() - 1).map(|feature| Place::Slot { slot, feature }));
    }
    for term in 0..shape.terms {
        places.extend((0..3).map(|channel| Place::Colour { channel, term }));
    }
    places
}

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

/// Place of (a, b), a <= b, among the pairs (0, 0), (0, 1), ... (1, 1), ...
fn upper(count: usize, a: usize, b: usize) -> usize {
    a * count - a * (a + 1) / 2 + b
}

#[cfg(test)]
#[path = "normal_tests.rs"]
mod tests;
