//! Making a brood: births, programs, and redraws of neutral twins.

use std::collections::HashSet;

use brood_genome::{BirthKey, Genome, GenomeHash, Variation, live_instructions};

use crate::{Program, ProgramHash};

/// How often a slot is drawn again while its program is one that is there already.
pub const MAX_REDRAWS: u32 = 16;
/// How often it is under a judge while all its draws were twins or worth less than nothing.
pub const MAX_WORTHLESS_REDRAWS: u32 = 3 * MAX_REDRAWS;

/// What to breed.
#[derive(Debug, Clone, Copy)]
pub struct BroodRequest<'a> {
    /// Parents and operator.
    pub variation: Variation<'a>,
    /// How many children.
    pub count: u32,
    /// Seed of the brood.
    pub seed: u64,
    /// Whether twins of a parent or of an earlier sibling are drawn again.
    pub distinct: bool,
}

/// One child.
#[derive(Debug, Clone)]
pub struct Child {
    /// Place in the brood.
    pub slot: u32,
    /// Its genome.
    pub genome: Genome,
    /// The genome's content hash.
    pub hash: GenomeHash,
    /// Its program.
    pub program: Program,
    /// The program's identity.
    pub program_hash: ProgramHash,
    /// Instructions that can change the result.
    pub live_instructions: u32,
    /// Draws it took, at least 1.
    pub attempts: u32,
    /// Whether its program is a parent's or an earlier sibling's all the same.
    pub twin: bool,
}

/// A genome that was drawn for a slot, and what it lowers to.
#[derive(Debug, Clone)]
pub struct Draw {
    genome: Genome,
    hash: GenomeHash,
    program: Program,
    program_hash: ProgramHash,
    live_instructions: u32,
}

impl Draw {
    /// What it lowers to.
    #[must_use]
    pub fn program(&self) -> &Program {
        &self.program
    }

    fn into_child(self, slot: u32, attempts: u32, twin: bool) -> Child {
        let Self { genome, hash, program, program_hash, live_instructions } = self;
        Child { slot, genome, hash, program, program_hash, live_instructions, attempts, twin }
    }
}

/// Who looks at draws whose program is new, and says what they are worth beside those that were taken.
pub trait Judge {
    /// What is seen of a program.
    type Look;

    /// Looks at a program.
    fn look(&self, program: &Program) -> Self::Look;

    /// What a draw is worth beside the parents and the slots before it; the first that is worth 1 is taken, and the one of the
    /// greatest worth where none is after all draws. Below 0 it is worth less than nothing.
    fn worth(&self, look: &Self::Look, taken: &[Self::Look]) -> f32;
}

impl BroodRequest<'_> {
    /// The first draw for a slot: it depends on nothing but the request, so slots may be drawn at the same time.
    #[must_use]
    pub fn draw(&self, slot: u32) -> Draw {
        self.draw_again(slot, 0)
    }

    fn draw_again(&self, slot: u32, attempt: u32) -> Draw {
        let genome = self.variation.birth(BirthKey { seed: self.seed, slot, attempt });
        let program = Program::lower(&genome);
        let program_hash = program.hash();
        let live = live_instructions(&genome).into_iter().filter(|live| *live).count();
        let live_instructions = u32::try_from(live).expect("at most 1024");
        Draw { hash: genome.hash(), genome, program, program_hash, live_instructions }
    }
}

/// Breeds the children of a request, a pure function of it.
///
/// Slots are settled in order, each against the parents and the slots before it, so a smaller brood of the same seed
/// is the beginning of a larger one.
#[must_use]
pub fn make_brood(request: &BroodRequest<'_>) -> Vec<Child> {
    settle_brood(request, (0..request.count).map(|slot| request.draw(slot)).collect())
}

/// The same from the first draws of slots 0, 1, 2 and so on.
#[must_use]
pub fn settle_brood(request: &BroodRequest<'_>, first: Vec<Draw>) -> Vec<Child> {
    let mut seen: HashSet<ProgramHash> =
        unchanged_parents(request).iter().map(Program::hash).collect();
    (0..)
        .zip(first)
        .map(|(slot, first)| {
            let child = settle(request, slot, first, &seen);
            seen.insert(child.program_hash);
            child
        })
        .collect()
}

/// The same where a judge looks at what is drawn: a slot is drawn again while its program is a twin or is worth too little.
///
/// `first` are the first draws of slots 0, 1, 2 and so on, with what the judge saw of them.
#[must_use]
pub fn settle_judged<J: Judge>(
    request: &BroodRequest<'_>,
    first: Vec<(Draw, J::Look)>,
    judge: &J,
) -> Vec<Child> {
    let parents = unchanged_parents(request);
    let mut seen: HashSet<ProgramHash> = parents.iter().map(Program::hash).collect();
    let mut taken: Vec<J::Look> = parents.iter().map(|parent| judge.look(parent)).collect();
    let mut children = Vec::with_capacity(first.len());
    for (slot, first) in (0..).zip(first) {
        let mut best: Option<(f32, Child, J::Look)> = None;
        let mut next = Some(first);
        for attempt in 0..=MAX_WORTHLESS_REDRAWS {
            if attempt > MAX_REDRAWS && best.as_ref().is_some_and(|(worth, ..)| *worth >= 0.0) {
                break;
            }
            let (draw, look) = next.take().unwrap_or_else(|| {
                let draw = request.draw_again(slot, attempt);
                let look = judge.look(&draw.program);
                (draw, look)
            });
            let twin = seen.contains(&draw.program_hash);
            // A twin is taken only where there is nothing else.
            let worth = if twin { f32::NEG_INFINITY } else { judge.worth(&look, &taken) };
            if best.as_ref().is_none_or(|(least, ..)| worth > *least) {
                best = Some((worth, draw.into_child(slot, attempt + 1, twin), look));
            }
            if worth >= 1.0 {
                break;
            }
        }
        let (_, child, look) = best.expect("the first draw is better than none");
        seen.insert(child.program_hash);
        taken.push(look);
        children.push(child);
    }
    children
}

/// The parents as they are, and as they would be under the brood's constraints and colours.
fn unchanged_parents(request: &BroodRequest<'_>) -> Vec<Program> {
    let both = |parent: &Genome| [parent.clone(), request.variation.unchanged(parent)];
    let parents = request.variation.parents().flat_map(both);
    parents.map(|parent| Program::lower(&parent)).collect()
}

fn settle(
    request: &BroodRequest<'_>,
    slot: u32,
    first: Draw,
    seen: &HashSet<ProgramHash>,
) -> Child {
    let last = if request.distinct { MAX_REDRAWS } else { 0 };
    let mut attempt = 0;
    let mut draw = first;
    loop {
        let twin = seen.contains(&draw.program_hash);
        if !twin || attempt == last {
            return draw.into_child(slot, attempt + 1, twin);
        }
        attempt += 1;
        draw = request.draw_again(slot, attempt);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use brood_genome::Dialect;

    fn parent() -> Genome {
        Variation::random(Dialect::default()).birth(BirthKey { seed: 2, slot: 0, attempt: 0 })
    }

    #[test]
    fn brood_has_no_twins_when_distinct() {
        let parent = parent();
        let variation = Variation::mutate(&parent, 0.02);
        let request = BroodRequest { variation, count: 20, seed: 7, distinct: true };
        let brood = make_brood(&request);
        let mut hashes: HashSet<_> = brood.iter().map(|child| child.program_hash).collect();
        hashes.insert(Program::lower(&parent).hash());
        assert_eq!(hashes.len(), 21);
        assert!(
            brood.iter().any(|child| child.attempts > 1),
            "half of small mutations are neutral"
        );
        let plain = make_brood(&BroodRequest { distinct: false, ..request });
        assert!(plain.iter().any(|child| child.twin));
    }

    #[test]
    fn smaller_brood_is_the_beginning_of_a_larger_one() {
        let parent = parent();
        let variation = Variation::mutate(&parent, 0.3);
        let request = BroodRequest { variation, count: 20, seed: 7, distinct: true };
        let hashes = |count| -> Vec<_> {
            let brood = make_brood(&BroodRequest { count, ..request });
            brood.into_iter().map(|child| child.hash).collect()
        };
        assert_eq!(hashes(5), hashes(20)[..5]);
    }
}
