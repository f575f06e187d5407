//! Crossover of programs: blocks of the second parent replace those of the first at the same
//! positions.

use super::draft::Draft;
use super::layer;
use super::mutate::How;
use super::paint;
use crate::believable;
use crate::locks::ResolvedLocks;
use crate::random::{Operator, Stream};
use crate::{BirthKey, Dialect, Genome};

/// Inverse of the mean block length if both parents have equal shares.
const SWITCH_RATE: f32 = 1.0 / 24.0;

/// Walks along the positions and switches between the parents so that the expected share of the
/// second is `recombination`.
///
/// A constant comes from the parent whose instructions read it. If both do, it is drawn with the
/// same share; if neither does, it stays the first's. The child's dialect, output stage and energy
/// limit are the first's, as is everything locked. Layers are crossed separately. Beside a painted
/// parent by another source (light or a BRDF), all but the effects is the first's.
pub(super) fn draft(
    (first, second): (&Genome, &Genome),
    recombination: f32,
    key: BirthKey,
    (how, locked): (How, &ResolvedLocks),
) -> Draft {
    let believable = || parameters((first, second), recombination, key, (how, locked));
    let program = || program((first, second), recombination, key, locked);
    let mut draft = match first.is_by_brdf() == second.is_by_brdf() {
        true => believable().unwrap_or_else(program),
        false => Draft::copy(first),
    };
    if first.is_painted() {
        let parents = (first.effects(), second.effects());
        draft.effects = paint::recombine(parents, recombination, key, locked.effects());
    }
    if first.is_painted() && !(first.is_by_brdf() && second.is_by_brdf()) {
        return draft;
    }
    let may_lose = !draft.instructions.is_empty();
    let parents = (first.layers(), second.layers());
    draft.layers = layer::recombine(parents, recombination, key, (locked.layers(), may_lose));
    draft
}

/// Crosses the parameters of two believable programs, except locked ones; `None` if one of
/// them is not believable, or the lineage has another start.
fn parameters(
    (first, second): (&Genome, &Genome),
    recombination: f32,
    key: BirthKey,
    (how, locked): (How, &ResolvedLocks),
) -> Option<Draft> {
    let rules = how.rules(locked)?;
    let mut draft = Draft::copy(first);
    let own = (&mut draft.instructions, &mut *draft.constants);
    let other = (second.instructions(), second.constants());
    if !believable::recombine(own, other, (recombination, rules), key) {
        return None;
    }
    locked.restore_named(&mut draft.constants, first.constants());
    draft.open_switches(first);
    Some(draft)
}

/// Returns the first parent's program with blocks of the second's. If only the second has a
/// program, the child takes all of it or none.
fn program(
    (first, second): (&Genome, &Genome),
    recombination: f32,
    key: BirthKey,
    locked: &ResolvedLocks,
) -> Draft {
    let mut stream = Stream::new(key, Operator::Recombine);
    if second.instructions().is_empty() {
        return Draft::copy(first);
    }
    if first.instructions().is_empty() {
        let mut draft = Draft::copy(first);
        if !locked.layers().is_closed() && stream.chance(recombination) {
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
        *taken &= locked.allows(position, &second.instructions()[position]);
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
        if !locked.locks_constant(index) && read_by_second[index] && (!read_by_first[index] || draw)
        {
            *constant = second.constants()[index];
        }
    }
    draft
}

/// Returns true for each position taken from the second parent, by a two-state Markov chain in
/// which a share of `share` is true on average.
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

/// Exchanges one block if the walk took everything from one parent although `share` is between 0
/// and 1. The mean length of the block is the smaller share.
fn force_exchange(from_second: &mut [bool], share: f32, stream: &mut Stream) {
    let all_same = from_second.iter().all(|taken| *taken == from_second[0]);
    if !all_same || share <= 0.0 || share >= 1.0 {
        return;
    }
    let length = from_second.len() as u32;
    let start = stream.below(length) as usize;
    // At most twice the smaller share.
    let longest = (2.0 * share.min(1.0 - share) * length as f32) as u32;
    let end = (start + 1 + stream.below(longest.max(1)) as usize).min(from_second.len());
    for taken in &mut from_second[start..end] {
        *taken = !*taken;
    }
}
