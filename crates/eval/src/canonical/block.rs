//! Blocks: the values of one block of samples, and the instructions run over them.

#![allow(unsafe_code, reason = "rows are read and written by place, see kernel.rs")]

use super::code::{Code, Instruction};
use super::kernel::{self, BLOCK, QUARTERS, Quarter, View};

/// The rows that the instructions of a block read and write.
pub(crate) struct Workspace {
    /// Registers, then inputs of blocks that cannot be read where they are.
    rows: Vec<Quarter>,
    /// Where each operand of the code is in the present block: registers, inputs, constants.
    views: Vec<View>,
}

/// Where a block stands in its set.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Span {
    pub(crate) start: usize,
    /// Samples; fewer than a block only at the end of the set.
    pub(crate) length: usize,
}

impl Span {
    /// The block that begins at `start` in a set of `samples`.
    pub(crate) fn of(start: usize, samples: usize) -> Self {
        Self { start, length: BLOCK.min(samples - start) }
    }
}

/// The results of a block before they are squared.
pub(crate) struct Results<'a> {
    views: [View; 3],
    quarters: usize,
    /// What the views look at lives as long as this and is not written to.
    _rows: std::marker::PhantomData<&'a [Quarter]>,
}

impl Results<'_> {
    /// g of red, green and blue.
    ///
    /// # Panics
    /// Where the block has no such quarter.
    #[inline(always)]
    pub(crate) fn quarter(&self, index: usize) -> [&[f32; kernel::LANES]; 3] {
        assert!(index < self.quarters, "a block has {} quarters", self.quarters);
        let [red, green, blue] = self.views;
        // SAFETY: the views are rows of that many quarters, borrowed for the life of this.
        unsafe { [red.quarter(index), green.quarter(index), blue.quarter(index)] }
    }
}

impl Workspace {
    pub(crate) fn new() -> Self {
        Self { rows: Vec::new(), views: Vec::new() }
    }
}

impl Code<'_> {
    /// Runs a block. Beyond the span's length the values are those of its last sample.
    #[inline(always)]
    pub(crate) fn block<'w>(&'w self, workspace: &'w mut Workspace, span: Span) -> Results<'w> {
        let Workspace { rows, views } = workspace;
        let wanted = (self.registers + self.inputs.len()) * QUARTERS;
        if rows.len() < wanted {
            rows.resize(wanted, Quarter([0.0; kernel::LANES]));
        }
        let (registers, tail) = rows.split_at_mut(self.registers * QUARTERS);
        views.clear();
        let first = registers.as_mut_ptr();
        // SAFETY: each begins within the registers.
        views.extend((0..self.registers).map(|row| View::at(unsafe { first.add(row * QUARTERS) })));
        for (input, row) in self.inputs.iter().zip(tail.chunks_exact_mut(QUARTERS)) {
            let values = &input[span.start..span.start + span.length];
            // Whole blocks are read where they are, if they begin on the border of a cache line.
            views.push(View::row(match bytemuck::try_cast_slice(values) {
                Ok(quarters) if span.length == BLOCK => quarters,
                _ => fill(row, values),
            }));
        }
        views.extend(self.constants.iter().map(View::constant));
        let quarters = span.length.div_ceil(kernel::LANES);
        for Instruction { pass, dst, operands: [a, b, c] } in &self.instructions {
            let operands = [views[usize::from(*a)], views[usize::from(*b)], views[usize::from(*c)]];
            // SAFETY: translation names only registers that there are, none as a destination that the same instruction
            // reads, and loops of the level it was given; every view is a row of a block or one quarter for all of it.
            unsafe {
                let out = first.add(usize::from(*dst) * QUARTERS);
                pass(std::slice::from_raw_parts_mut(out, quarters), &operands);
            }
        }
        let [red, green, blue] = self.results;
        let views = [views[usize::from(red)], views[usize::from(green)], views[usize::from(blue)]];
        Results { views, quarters, _rows: std::marker::PhantomData }
    }
}

/// Copies values and repeats the last, which stays in the range that clamps were left out for.
fn fill<'a>(row: &'a mut [Quarter], values: &[f32]) -> &'a [Quarter] {
    let places: &mut [f32] = bytemuck::cast_slice_mut(row);
    let (filled, rest) = places.split_at_mut(values.len());
    filled.copy_from_slice(values);
    rest.fill(values.last().copied().unwrap_or(0.0));
    row
}
