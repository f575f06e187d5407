//! Sums over the samples of a block of products of rows: every row of one set with every row of
//! another. Fits spend most of their time here.
//!
//! Loops run along contiguous memory and never add across lanes, so that compilers vectorise them.

use super::block::{LANES, Row};

/// Number of samples whose products are added before a sum is stored.
const TOGETHER: usize = 8;
/// Widths are multiples of this.
const CHUNK: usize = 8;

/// Transposed rows: for each sample the values of all rows, zero-padded to a whole number of
/// chunks.
pub(super) struct Transposed {
    width: usize,
    /// [sample][row].
    values: Vec<f32>,
}

impl Transposed {
    pub(super) fn new(rows: usize) -> Self {
        let width = rows.next_multiple_of(CHUNK);
        Self { width, values: vec![0.0; width * LANES] }
    }

    /// Stores a row at this index.
    #[inline(always)]
    pub(super) fn set(&mut self, at: usize, row: &Row) {
        for (values, value) in self.values.chunks_exact_mut(self.width).zip(&row.0) {
            values[at] = *value;
        }
    }

    /// Number of values per sample.
    pub(super) fn width(&self) -> usize {
        self.width
    }
}

/// Adds to `sums`, which has [`Transposed::width`] entries for each row of `left`, the sum over
/// samples of left times right.
///
/// # Error
/// Sums over a block are f32, eight products first; sums over blocks are f64.
#[inline(always)]
pub(super) fn add_products(
    left: &[Row],
    right: &Transposed,
    sums: &mut [f64],
    buffer: &mut Vec<f32>,
) {
    let width = right.width;
    for (row, sums) in left.iter().zip(sums.chunks_exact_mut(width)) {
        buffer.clear();
        buffer.resize(width, 0.0);
        let parts = right.values.chunks_exact(TOGETHER * width);
        for (factors, part) in row.0.chunks_exact(TOGETHER).zip(parts) {
            let factors: &[f32; TOGETHER] = factors.try_into().expect("chunks have that length");
            add_part(buffer, factors, part);
        }
        for (sum, value) in sums.iter_mut().zip(&*buffer) {
            *sum += f64::from(*value);
        }
    }
}

#[inline(always)]
fn add_part(sums: &mut [f32], factors: &[f32; TOGETHER], part: &[f32]) {
    let width = sums.len();
    let [a, b, c, d, e, f, g, h] = *factors;
    let (part_a, rest) = part.split_at(width);
    let (part_b, rest) = rest.split_at(width);
    let (part_c, rest) = rest.split_at(width);
    let (part_d, rest) = rest.split_at(width);
    let (part_e, rest) = rest.split_at(width);
    let (part_f, rest) = rest.split_at(width);
    let (part_g, part_h) = rest.split_at(width);
    let part_h = &part_h[..width];
    for at in 0..width {
        let first = (a * part_a[at] + b * part_b[at]) + (c * part_c[at] + d * part_d[at]);
        let second = (e * part_e[at] + f * part_f[at]) + (g * part_g[at] + h * part_h[at]);
        sums[at] += first + second;
    }
}

/// Sum of a row.
#[inline(always)]
pub(super) fn sum(row: &Row) -> f64 {
    let mut sums = row.0;
    let mut count = LANES;
    while count > 1 {
        count /= 2;
        let (low, high) = sums.split_at_mut(count);
        for (sum, value) in low.iter_mut().zip(high) {
            *sum += *value;
        }
    }
    f64::from(sums[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn add_products_sums_over_all_samples() {
        let row = |k: usize| Row(std::array::from_fn(|lane| ((lane * 7 + k * 13) % 11) as f32));
        let left: Vec<Row> = (0..3).map(row).collect();
        let mut right = Transposed::new(5);
        for at in 0..5 {
            right.set(at, &row(at + 20));
        }
        assert_eq!(right.width(), 8);
        let mut sums = vec![1.0; 3 * 8];
        add_products(&left, &right, &mut sums, &mut Vec::new());
        for (i, left) in left.iter().enumerate() {
            for j in 0..8 {
                let other = if j < 5 { row(j + 20) } else { Row::ZERO };
                let expected: f32 = left.0.iter().zip(&other.0).map(|(a, b)| a * b).sum();
                assert_eq!(sums[8 * i + j], f64::from(1.0 + expected));
            }
        }
        let all: f32 = left[0].0.iter().sum();
        assert_eq!(sum(&left[0]), f64::from(all));
    }
}
