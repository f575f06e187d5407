//! Inputs of models for the samples of a set, computed quarter by quarter at the first use and
//! shared by all programs.

use std::sync::OnceLock;

use brood_brdf::{Block, Level};
use brood_scene::SampleSet;

use crate::lanes::LANES;

/// The quarters of a set, 88 bytes per sample of a computed quarter.
#[derive(Debug)]
pub(crate) struct SharedBlocks<'a> {
    set: &'a SampleSet,
    level: Level,
    quarters: Vec<OnceLock<Box<Block<LANES>>>>,
}

impl<'a> SharedBlocks<'a> {
    /// Creates the table; no quarter is computed yet.
    pub(crate) fn new(set: &'a SampleSet, level: Level) -> Self {
        let mut quarters = Vec::new();
        quarters.resize_with(set.len().div_ceil(LANES), OnceLock::new);
        Self { set, level, quarters }
    }

    /// Returns the quarter that begins at the sample `start`.
    ///
    /// # Panics
    /// If the set has no such sample, or was picked without directions.
    pub(crate) fn quarter(&self, start: usize) -> &Block<LANES> {
        self.quarters[start / LANES].get_or_init(|| {
            let mut block = Box::new(Block::new());
            block.fill(self.level, self.set.pairs(start..self.set.len().min(start + LANES)));
            block
        })
    }

    /// Number of computed quarters.
    #[cfg(test)]
    pub(crate) fn computed(&self) -> usize {
        self.quarters.iter().filter(|quarter| quarter.get().is_some()).count()
    }
}
