//! Broods: births of children, their programs, and redraws of neutral twins.

use std::collections::{HashSet, VecDeque};

use brood_genome::{BirthKey, Genome, GenomeHash, Variation, live_instructions};

use crate::{Program, ProgramHash};

/// Largest number of redraws of a slot whose program is a twin of a parent or an earlier sibling.
pub const MAX_REDRAWS: u32 = 16;
/// Largest number of redraws of a slot under a [`DrawScorer`] while all of the slot's draws were
/// twins or scored below 0.
pub const MAX_UNWANTED_REDRAWS: u32 = 3 * MAX_REDRAWS;

/// A request for a brood.
#[derive(Debug, Clone, Copy)]
pub struct BroodRequest<'a> {
    /// Parents and operator.
    pub variation: Variation<'a>,
    /// Number of children.
    pub count: u32,
    /// Seed of the brood.
    pub seed: u64,
    /// True if twins of a parent or of an earlier sibling are drawn again.
    pub distinct: bool,
}

/// A child of a brood.
#[derive(Debug, Clone)]
pub struct Child {
    /// Place in the brood, from 0.
    pub slot: u32,
    /// Genome of the child.
    pub genome: Genome,
    /// Content hash of the genome.
    pub hash: GenomeHash,
    /// Program of the genome.
    pub program: Program,
    /// Identity of the program.
    pub program_hash: ProgramHash,
    /// Number of instructions that can change the result.
    pub live_instructions: u32,
    /// Number of draws for this slot, at least 1.
    pub attempts: u32,
    /// True if the program is still that of a parent or an earlier sibling.
    pub twin: bool,
}

/// A genome drawn for a slot, with its program.
#[derive(Debug, Clone)]
pub struct Draw {
    genome: Genome,
    hash: GenomeHash,
    program: Program,
    program_hash: ProgramHash,
    live_instructions: u32,
}

impl Draw {
    /// Program that the genome lowers to.
    #[must_use]
    pub fn program(&self) -> &Program {
        &self.program
    }

    fn into_child(self, slot: u32, attempts: u32, twin: bool) -> Child {
        let Self { genome, hash, program, program_hash, live_instructions } = self;
        Child { slot, genome, hash, program, program_hash, live_instructions, attempts, twin }
    }
}

/// Scores draws whose program is new against those that were taken already.
pub trait DrawScorer {
    /// Features of a program that scores compare.
    type Features;

    /// Number of redraws of a slot whose features are measured together.
    const BATCH: u32 = 1;

    /// Returns the features of a program.
    fn features(&self, program: &Program) -> Self::Features;

    /// Returns the features of several programs, in their order.
    fn features_of_all(&self, programs: &[&Program]) -> Vec<Self::Features> {
        programs.iter().map(|program| self.features(program)).collect()
    }

    /// Returns the score of a draw against `taken`: the parents and the slots before it.
    ///
    /// The first draw with score 1 is taken. If no draw of a slot reaches 1, the one with the
    /// greatest score is. A score below 0 allows [`MAX_UNWANTED_REDRAWS`] redraws instead of
    /// [`MAX_REDRAWS`].
    fn score(&self, features: &Self::Features, taken: &[Self::Features]) -> f32;
}

impl BroodRequest<'_> {
    /// Returns the first draw of a slot. It depends only on the request, so slots may be drawn
    /// concurrently.
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

/// Breeds the children of a request; a pure function of it.
///
/// Slots are settled in order, each against the parents and the slots before it, so a smaller brood
/// of the same seed is a prefix of a larger one.
#[must_use]
pub fn make_brood(request: &BroodRequest<'_>) -> Vec<Child> {
    settle_brood(request, (0..request.count).map(|slot| request.draw(slot)).collect())
}

/// Does the same as [`make_brood`], given the first draws of slots 0, 1, 2 and so on.
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

/// Does the same as [`settle_brood`], but also draws a slot again while its score is below 1.
///
/// `first` holds the first draws of slots 0, 1, 2 and so on, with the features of each.
#[must_use]
pub fn settle_scored<S: DrawScorer>(
    request: &BroodRequest<'_>,
    first: Vec<(Draw, S::Features)>,
    scorer: &S,
) -> Vec<Child> {
    let parents = unchanged_parents(request);
    let mut seen: HashSet<ProgramHash> = parents.iter().map(Program::hash).collect();
    let mut taken: Vec<S::Features> =
        parents.iter().map(|parent| scorer.features(parent)).collect();
    let mut children = Vec::with_capacity(first.len());
    for (slot, first) in (0..).zip(first) {
        let mut best: Option<(f32, Child, S::Features)> = None;
        let mut next = VecDeque::from([first]);
        for attempt in 0..=MAX_UNWANTED_REDRAWS {
            if attempt > MAX_REDRAWS && best.as_ref().is_some_and(|(score, ..)| *score >= 0.0) {
                break;
            }
            if next.is_empty() {
                let last = (attempt + S::BATCH).min(MAX_UNWANTED_REDRAWS + 1);
                let draws: Vec<Draw> =
                    (attempt..last).map(|attempt| request.draw_again(slot, attempt)).collect();
                let programs: Vec<&Program> = draws.iter().map(|draw| &draw.program).collect();
                let features = scorer.features_of_all(&programs);
                next.extend(draws.into_iter().zip(features));
            }
            let (draw, features) = next.pop_front().expect("a batch has draws");
            let twin = seen.contains(&draw.program_hash);
            // A twin is taken only if the slot has no other draw.
            let score = if twin { f32::NEG_INFINITY } else { scorer.score(&features, &taken) };
            if best.as_ref().is_none_or(|(least, ..)| score > *least) {
                best = Some((score, draw.into_child(slot, attempt + 1, twin), features));
            }
            if score >= 1.0 {
                break;
            }
        }
        let (_, child, features) = best.expect("every slot has a first draw");
        seen.insert(child.program_hash);
        taken.push(features);
        children.push(child);
    }
    children
}

/// Programs of the parents, unchanged and under the constraints and colours of the brood.
fn unchanged_parents(request: &BroodRequest<'_>) -> Vec<Program> {
    let both = |parent: &Genome| [parent.clone(), request.variation.unchanged(parent)];
    let parents = request.variation.parents().flat_map(both);
    parents.map(|parent| Program::lower(&parent)).collect()
}

/// Returns the first draw of a slot that is no twin, or the last allowed one.
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
    use std::cell::{Cell, RefCell};

    use brood_genome::{Dialect, MutationScale};

    use super::*;

    fn parent() -> Genome {
        Variation::random(Dialect::default()).birth(BirthKey { seed: 2, slot: 0, attempt: 0 })
    }

    #[test]
    fn brood_has_no_twins_when_distinct() {
        let parent = parent();
        // Mutations by the rates of searches are often neutral.
        let variation = Variation::mutate(&parent, 0.02).with_scale(MutationScale::Search);
        let request = BroodRequest { variation, count: 20, seed: 7, distinct: true };
        let brood = make_brood(&request);
        let mut hashes: HashSet<_> = brood.iter().map(|child| child.program_hash).collect();
        hashes.insert(Program::lower(&parent).hash());
        assert_eq!(hashes.len(), 21);
        assert!(
            brood.iter().any(|child| child.attempts > 1),
            "about half of all small mutations are neutral"
        );
        let plain = make_brood(&BroodRequest { distinct: false, ..request });
        assert!(plain.iter().any(|child| child.twin));
    }

    #[test]
    fn smaller_brood_is_a_prefix_of_a_larger_one() {
        let parent = parent();
        let variation = Variation::mutate(&parent, 0.3);
        let request = BroodRequest { variation, count: 20, seed: 7, distinct: true };
        let hashes = |count| -> Vec<_> {
            let brood = make_brood(&BroodRequest { count, ..request });
            brood.into_iter().map(|child| child.hash).collect()
        };
        assert_eq!(hashes(5), hashes(20)[..5]);
    }

    /// Scores draws by their number, counted over all slots, and records what it was given.
    struct Numbered<F> {
        score: F,
        draws: Cell<u32>,
        taken: RefCell<Vec<Vec<u32>>>,
    }

    impl<F: Fn(u32) -> f32> Numbered<F> {
        fn new(score: F) -> Self {
            Self { score, draws: Cell::new(0), taken: RefCell::default() }
        }

        fn settle(&self, request: &BroodRequest<'_>) -> Vec<Child> {
            let first = (0..request.count).map(|slot| {
                let draw = request.draw(slot);
                let features = self.features(draw.program());
                (draw, features)
            });
            settle_scored(request, first.collect(), self)
        }
    }

    impl<F: Fn(u32) -> f32> DrawScorer for Numbered<F> {
        type Features = u32;

        fn features(&self, _: &Program) -> u32 {
            self.draws.replace(self.draws.get() + 1)
        }

        fn score(&self, features: &u32, taken: &[u32]) -> f32 {
            self.taken.borrow_mut().push(taken.to_vec());
            (self.score)(*features)
        }
    }

    fn random(count: u32) -> BroodRequest<'static> {
        let variation = Variation::random(Dialect::default());
        BroodRequest { variation, count, seed: 7, distinct: true }
    }

    #[test]
    fn slot_is_drawn_until_a_score_is_1_or_its_draws_are_used_up() {
        type Score = fn(u32) -> f32;
        let cases: [(Score, u32, u32); 5] = [
            // A score of 1 ends the slot.
            (|draw| if draw == 2 { 1.0 } else { 0.0 }, 3, 3),
            // The first of the greatest scores is taken.
            (|draw| if draw == 3 || draw == 5 { 0.9 } else { 0.5 }, 4, MAX_REDRAWS + 1),
            // Scores of 0 are not drawn again more often.
            (|_| 0.0, 1, MAX_REDRAWS + 1),
            (|_| -1.0, 1, MAX_UNWANTED_REDRAWS + 1),
            (|draw| if draw == 20 { 0.0 } else { -1.0 }, 21, 21),
        ];
        for (score, attempts, draws) in cases {
            let scorer = Numbered::new(score);
            let brood = scorer.settle(&random(1));
            assert_eq!((brood.len(), brood[0].attempts, scorer.draws.get()), (1, attempts, draws));
            let same = random(1).draw_again(0, attempts - 1);
            assert_eq!(brood[0].hash, same.hash);
        }
        assert_eq!((MAX_REDRAWS, MAX_UNWANTED_REDRAWS), (16, 48));
    }

    #[test]
    fn draws_are_scored_against_the_parents_and_the_slots_before() {
        let scorer = Numbered::new(|_| 1.0);
        scorer.settle(&random(3));
        assert_eq!(scorer.taken.into_inner(), [vec![], vec![0], vec![0, 1]]);
        let parent = parent();
        let scorer = Numbered::new(|_| 1.0);
        let variation = Variation::mutate(&parent, 0.9);
        let brood = scorer.settle(&BroodRequest { variation, ..random(1) });
        assert!(!brood[0].twin);
        assert_eq!(scorer.taken.into_inner(), [[1, 2]], "the parent as it is and as constrained");
    }

    #[test]
    fn twins_are_taken_when_all_draws_are_twins() {
        let parent = parent();
        let variation = Variation::mutate(&parent, 0.0);
        let request = BroodRequest { variation, ..random(2) };
        let scorer = Numbered::new(|_| 1.0);
        let scored = scorer.settle(&request);
        assert!(scorer.taken.borrow().is_empty(), "twins are not scored");
        let parents = 2;
        assert_eq!(scorer.draws.get(), parents + 2 * (MAX_UNWANTED_REDRAWS + 1));
        let attempts = |brood: &[Child]| -> Vec<(u32, u32, bool)> {
            brood.iter().map(|child| (child.slot, child.attempts, child.twin)).collect()
        };
        assert_eq!(attempts(&scored), [(0, 1, true), (1, 1, true)]);
        let last = MAX_REDRAWS + 1;
        assert_eq!(attempts(&make_brood(&request)), [(0, last, true), (1, last, true)]);
        let any = BroodRequest { distinct: false, ..request };
        assert_eq!(attempts(&make_brood(&any)), [(0, 1, true), (1, 1, true)]);
    }
}
