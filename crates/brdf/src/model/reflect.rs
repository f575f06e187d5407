//! The trait that every family of models implements.

use super::constants::ModelConstants;
use crate::{Block, Claims, Machine};

/// Evaluation of one model family.
pub(super) trait Reflect {
    /// Returns f of each lane, channel by channel.
    fn block<M: Machine, const N: usize>(&self, machine: M, block: &Block<N>) -> [[f64; N]; 3];

    /// Properties that hold with these parameters.
    fn claims(&self) -> Claims;

    /// Formula and constants, for exporters.
    fn constants(&self) -> ModelConstants;
}
