//! Execution of translated code on one block of samples.
//!
//! A row holds the values of one input, constant or register for a block: four quarters, or one
//! quarter that stands for all if the value is constant. An instruction names a row by its slot, an
//! index into a table of views.

#![allow(unsafe_code, reason = "rows are read and written through pointers, see kernel.rs")]

use std::marker::PhantomData;

use super::code::{Code, Instruction};
use super::kernel::View;
use crate::lanes::{BLOCK, LANES, QUARTERS, Quarter};

/// Memory for running code, kept per thread: the rows that instructions read and write.
pub(crate) struct Workspace {
    /// Constants, one quarter each, then whole rows: registers, and copies of the inputs of blocks
    /// that cannot be read in place.
    rows: Vec<Quarter>,
    /// View of each row, by slot: registers, inputs, constants. Views of inputs change with each
    /// block.
    views: Vec<View>,
}

/// Samples of a block.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Span {
    /// Index of the first sample.
    pub(crate) start: usize,
    /// Number of samples; less than a block only at the end of the set.
    pub(crate) length: usize,
}

impl Span {
    /// Returns the block that begins at `start` in a set of `samples`.
    pub(crate) fn of(start: usize, samples: usize) -> Self {
        Self { start, length: BLOCK.min(samples - start) }
    }
}

/// The results g of a block, before squaring.
pub(crate) struct Results<'a> {
    views: [View; 3],
    quarters: usize,
    /// The rows that the views point to live as long as this and are not written to.
    _rows: PhantomData<&'a [Quarter]>,
}

impl Results<'_> {
    /// Returns g of red, green and blue in one quarter.
    ///
    /// # Panics
    /// If the block has no such quarter.
    #[inline(always)]
    pub(crate) fn quarter(&self, index: usize) -> [&[f32; LANES]; 3] {
        assert!(index < self.quarters, "a block has {} quarters", self.quarters);
        let [red, green, blue] = self.views;
        // SAFETY: the views are rows of that many quarters, or one quarter that stands for all,
        // borrowed for the life of this.
        unsafe { [red.quarter(index), green.quarter(index), blue.quarter(index)] }
    }
}

impl Workspace {
    pub(crate) fn new() -> Self {
        Self { rows: Vec::new(), views: Vec::new() }
    }
}

/// Code together with a workspace that is prepared for it.
pub(crate) struct BoundCode<'w> {
    code: &'w Code<'w>,
    /// Pointer to the first row of the registers. A pointer, because an instruction writes one
    /// register while it reads others.
    first: *mut Quarter,
    /// Rows for copies of inputs that cannot be read in place.
    inputs: &'w mut [Quarter],
    views: &'w mut [View],
    /// The rows that the pointer and the views point to live as long as this and are written to
    /// only by this.
    _rows: PhantomData<&'w mut [Quarter]>,
}

impl<'w> BoundCode<'w> {
    /// Lays out the rows in the workspace and fills those of the constants.
    #[inline(always)]
    pub(crate) fn new(code: &'w Code<'w>, workspace: &'w mut Workspace) -> Self {
        let Workspace { rows, views } = workspace;
        let (constants, inputs) = (code.program().constants(), code.inputs.len());
        let needed = constants.len() + (code.registers + inputs) * QUARTERS;
        if rows.len() < needed {
            rows.resize(needed, Quarter([0.0; LANES]));
        }
        let (constant_rows, rest) = rows.split_at_mut(constants.len());
        let (registers, rest) = rest.split_at_mut(code.registers * QUARTERS);
        let first = registers.as_mut_ptr();
        views.clear();
        // SAFETY: each row begins within the registers.
        views.extend((0..code.registers).map(|row| View::at(unsafe { first.add(row * QUARTERS) })));
        // Views of inputs are set for each block.
        views.extend((0..inputs).map(|_| View::at(first)));
        for (row, constant) in constant_rows.iter_mut().zip(constants) {
            row.0.fill(constant.canonical);
            views.push(View::constant(row));
        }
        let inputs = &mut rest[..inputs * QUARTERS];
        Self { code, first, inputs, views, _rows: PhantomData }
    }

    /// Runs a block. Lanes beyond the length of the span contain the values of its last sample.
    #[inline(always)]
    pub(crate) fn block(&mut self, span: Span) -> Results<'_> {
        let Self { code, first, inputs, views, .. } = self;
        let rows = inputs.chunks_exact_mut(QUARTERS);
        for ((input, row), view) in code.inputs.iter().zip(rows).zip(&mut views[code.registers..]) {
            let values = &code.set.input(input)[span.start..span.start + span.length];
            // Whole blocks are read in place if they begin on the border of a cache line.
            *view = View::row(match bytemuck::try_cast_slice(values) {
                Ok(quarters) if span.length == BLOCK => quarters,
                _ => fill(row, values),
            });
        }
        let quarters = span.length.div_ceil(LANES);
        for Instruction { pass, dst, operands: [a, b, c] } in &code.instructions {
            let operands = [views[usize::from(*a)], views[usize::from(*b)], views[usize::from(*c)]];
            // SAFETY: translation emits only existing registers, never a destination that the same
            // instruction reads, and only loops of the level it was given; every view is a row of a
            // block, or one quarter that stands for all of it.
            unsafe {
                let out = first.add(usize::from(*dst) * QUARTERS);
                pass(std::slice::from_raw_parts_mut(out, quarters), &operands);
            }
        }
        let [red, green, blue] = code.results;
        let views = [views[usize::from(red)], views[usize::from(green)], views[usize::from(blue)]];
        Results { views, quarters, _rows: PhantomData }
    }
}

/// Copies values and repeats the last one up to the end of the row: it is within the range of the
/// input for which translation left out clamps.
fn fill<'a>(row: &'a mut [Quarter], values: &[f32]) -> &'a [Quarter] {
    let places: &mut [f32] = bytemuck::cast_slice_mut(row);
    let (filled, rest) = places.split_at_mut(values.len());
    filled.copy_from_slice(values);
    rest.fill(values.last().copied().unwrap_or(0.0));
    row
}
