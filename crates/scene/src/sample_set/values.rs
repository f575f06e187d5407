//! One input of every sample, laid out for vector loads.

use std::ops::{Deref, Range};

use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;

/// As many values as a cache line takes.
const LINE: usize = 16;

/// A line of the nearest cache: vectors that straddle two lines cost twice.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C, align(64))]
struct Line([f32; LINE]);

/// Values that begin on the border of a cache line, and the least and the largest of them.
#[derive(Debug)]
pub(super) struct Values {
    lines: Vec<Line>,
    len: usize,
    range: (f32, f32),
}

impl Values {
    /// `len` values, in parallel; the same whatever the number of threads.
    pub(super) fn compute(len: usize, value: impl Fn(usize) -> f32 + Sync) -> Self {
        let mut lines = vec![Line([0.0; LINE]); len.div_ceil(LINE)];
        lines.par_iter_mut().enumerate().with_min_len(64).for_each(|(index, line)| {
            let first = index * LINE;
            for (offset, place) in line.0.iter_mut().take(len - first).enumerate() {
                *place = value(first + offset);
            }
        });
        let mut values = Self { lines, len, range: (0.0, 0.0) };
        values.range = range(&values);
        values
    }

    /// `len` values that are there already, piece after piece, all of them within `range`.
    pub(super) fn joined<'a>(
        len: usize,
        range: (f32, f32),
        pieces: impl Iterator<Item = (&'a [f32], Range<usize>)>,
    ) -> Self {
        let mut lines = vec![Line([0.0; LINE]); len.div_ceil(LINE)];
        join(&mut bytemuck::cast_slice_mut(&mut lines)[..len], pieces);
        Self { lines, len, range }
    }

    pub(super) fn range(&self) -> (f32, f32) {
        self.range
    }
}

impl Deref for Values {
    type Target = [f32];

    fn deref(&self) -> &[f32] {
        &bytemuck::cast_slice(&self.lines)[..self.len]
    }
}

/// Copies pieces of slices one after the other. Most are short: so eight at a time, also where a piece has fewer and the
/// next piece takes the place of what was too much.
pub(super) fn join<'a>(
    joined: &mut [f32],
    pieces: impl Iterator<Item = (&'a [f32], Range<usize>)>,
) {
    let mut done = 0;
    for (source, piece) in pieces {
        let mut at = piece.start;
        while at < piece.end {
            let left = piece.end - at;
            let (place, values) = (&mut joined[done..], &source[at..]);
            let copied = match (place.first_chunk_mut::<8>(), values.first_chunk::<8>()) {
                (Some(place), Some(values)) => {
                    *place = *values;
                    left.min(8)
                }
                _ => {
                    place[..left].copy_from_slice(&values[..left]);
                    left
                }
            };
            (at, done) = (at + copied, done + copied);
        }
    }
}

fn range(values: &[f32]) -> (f32, f32) {
    let Some(first) = values.first() else { return (0.0, 0.0) };
    values.iter().fold((*first, *first), |(low, high), value| (low.min(*value), high.max(*value)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_in_order_and_aligned_for_any_length() {
        for len in [0usize, 1, 15, 16, 17, 1000, 5003] {
            let values = Values::compute(len, |index| index as f32 - 7.0);
            assert_eq!(values.len(), len);
            assert!((0..len).all(|index| values[index] == index as f32 - 7.0));
            assert_eq!(values.as_ptr() as usize % 64, 0);
            let high = if len == 0 { 0.0 } else { len as f32 - 8.0 };
            assert_eq!(values.range(), (if len == 0 { 0.0 } else { -7.0 }, high));
        }
    }
}
