//! Values of one input for every sample, aligned for vector loads.

use std::ops::{Deref, Range};

use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;

/// Number of f32 values per cache line.
const LINE: usize = 16;

/// Values of one cache line. Aligned, because a vector load across two lines costs twice.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C, align(64))]
struct Line([f32; LINE]);

/// Values aligned to cache lines, and bounds of them.
#[derive(Debug, Clone)]
pub(super) struct Values {
    lines: Vec<Line>,
    len: usize,
    range: (f32, f32),
}

impl Values {
    /// Computes `len` values in parallel; bit-identical for any number of threads.
    pub(super) fn compute(len: usize, value: impl Fn(usize) -> f32 + Sync) -> Self {
        let mut lines = vec![Line([0.0; LINE]); len.div_ceil(LINE)];
        lines.par_iter_mut().enumerate().with_min_len(64).for_each(|(index, line)| {
            let first = index * LINE;
            for (offset, slot) in line.0.iter_mut().take(len - first).enumerate() {
                *slot = value(first + offset);
            }
        });
        let mut values = Self { lines, len, range: (0.0, 0.0) };
        values.range = range(&values);
        values
    }

    /// Concatenates slices of existing values, `len` in all, each within `range`.
    pub(super) fn concatenated<'a>(
        len: usize,
        range: (f32, f32),
        pieces: impl Iterator<Item = (&'a [f32], Range<usize>)>,
    ) -> Self {
        let mut lines = vec![Line([0.0; LINE]); len.div_ceil(LINE)];
        concatenate(&mut bytemuck::cast_slice_mut(&mut lines)[..len], pieces);
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

/// Concatenates pieces of slices. Most pieces are short, so eight values are copied at a time, even
/// if the piece has fewer: the next piece overwrites the excess.
pub(super) fn concatenate<'a>(
    target: &mut [f32],
    pieces: impl Iterator<Item = (&'a [f32], Range<usize>)>,
) {
    let mut done = 0;
    for (source, piece) in pieces {
        let mut at = piece.start;
        while at < piece.end {
            let left = piece.end - at;
            let (slots, values) = (&mut target[done..], &source[at..]);
            let copied = match (slots.first_chunk_mut::<8>(), values.first_chunk::<8>()) {
                (Some(slots), Some(values)) => {
                    *slots = *values;
                    left.min(8)
                }
                _ => {
                    slots[..left].copy_from_slice(&values[..left]);
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

/// Rounds to the nearest f32; values out of range become the largest finite f32 of that sign.
pub(super) fn round_to_f32(value: f64) -> f32 {
    (value as f32).clamp(f32::MIN, f32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_ordered_and_aligned_for_any_length() {
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
