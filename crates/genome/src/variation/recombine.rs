//! Recombination: blocks of the second parent replace those of the first at corresponding positions.

use super::{Draft, layer};
use crate::locks::Held;
use crate::random::{Operator, Stream};
use crate::{BirthKey, Dialect, Genome};

/// Inverse of the mean length of a block where both parents have equal shares.
const SWITCH_RATE: f32 = 1.0 / 24.0;

/// Walks along the positions, switching between the parents so that the second has the share `recombination`.
///
/// A constant comes from the parent whose instructions read it; where both do, it is drawn with the same share; where
/// neither does, it stays the first's. The child's dialect, output stage and limit are the first's, and so is what is held.
/// Layers are crossed for themselves.
pub(super) fn draft(
    first: &Genome,
    second: &Genome,
    recombination: f32,
    key: BirthKey,
    held: &Held,
) -> Draft {
    let mut draft = program(first, second, recombination, key, held);
    let may_lose = !draft.instructions.is_empty();
    let parents = (first.layers(), second.layers());
    draft.layers = layer::recombine(parents, recombination, key, (held.layers(), may_lose));
    draft
}

/// The first parent's program with blocks of the second's; where one has none, the other's or none.
fn program(
    first: &Genome,
    second: &Genome,
    recombination: f32,
    key: BirthKey,
    held: &Held,
) -> Draft {
    let mut stream = Stream::new(key, Operator::Recombine);
    if second.instructions().is_empty() {
        return Draft::copy(first);
    }
    if first.instructions().is_empty() {
        let mut draft = Draft::copy(first);
        if !held.layers().is_closed() && stream.chance(recombination) {
            let Dialect { isotropic, homogeneous, .. } = draft.dialect;
            draft.dialect = Dialect { isotropic, homogeneous, ..*second.dialect() };
            draft.instructions = second.instructions().to_vec();
            draft.constants = Box::new(*second.constants());
        }
        return draft;
    }
    let mut from_second = choose_blocks(first.instructions().len(), recombination, &mut stream);
    force_exchange(&mut from_second, recombination, &mut stream);
    let mut draft = Draft::copy(first);
    let (mut read_by_first, mut read_by_second) = ([false; 128], [false; 128]);
    for (position, taken) in from_second.iter_mut().enumerate() {
        *taken &= held.allows(position, &second.instructions()[position]);
        if *taken {
            draft.instructions[position] = second.instructions()[position];
        }
        if let Some(constant) = draft.instructions[position].constant() {
            let readers = if *taken { &mut read_by_second } else { &mut read_by_first };
            readers[usize::from(constant)] = true;
        }
    }
    for (index, constant) in draft.constants.iter_mut().enumerate() {
        let draw = stream.chance(recombination);
        if !held.constant(index) && read_by_second[index] && (!read_by_first[index] || draw) {
            *constant = second.constants()[index];
        }
    }
    draft
}

/// A two-state walk whose stationary share of `true` is `share`.
fn choose_blocks(length: usize, share: f32, stream: &mut Stream) -> Vec<bool> {
    let mut inside = stream.chance(share);
    let mut blocks = Vec::with_capacity(length);
    for _ in 0..length {
        blocks.push(inside);
        let leave = SWITCH_RATE * 2.0 * if inside { 1.0 - share } else { share };
        if stream.chance(leave) {
            inside = !inside;
        }
    }
    blocks
}

/// Where the walk took nothing from one of the parents although the share says otherwise, one block is exchanged, in the mean as
/// long as that share is.
fn force_exchange(from_second: &mut [bool], share: f32, stream: &mut Stream) {
    let all_same = from_second.iter().all(|taken| *taken == from_second[0]);
    if !all_same || share <= 0.0 || share >= 1.0 {
        return;
    }
    let length = from_second.len() as u32;
    let start = stream.below(length) as usize;
    // As long as the smaller share is, at most.
    let longest = (2.0 * share.min(1.0 - share) * length as f32) as u32;
    let end = (start + 1 + stream.below(longest.max(1)) as usize).min(from_second.len());
    for taken in &mut from_second[start..end] {
        *taken = !*taken;
    }
}
