//! Checkpoint of a genetic search.

use std::collections::VecDeque;

use brood_genome::Genome;
use brood_program::{Program, ProgramHash};
use serde::{Deserialize, Serialize};

use super::evaluate::{BareGenome, Member, operations};
use super::front::Front;
use super::island::Island;
use super::schedule::{Best, Gp};

#[derive(Serialize, Deserialize)]
struct State {
    generation: u32,
    evaluations: u64,
    repeats: u64,
    islands: Vec<(u32, Vec<MemberState>)>,
    seen: Vec<[u8; 32]>,
    front: Vec<MemberState>,
    best: Option<(MemberState, f64, f64)>,
}

/// A [`Member`] without what is computed from its genome: hash and number of operations.
#[derive(Serialize, Deserialize)]
struct MemberState {
    genome: Vec<u8>,
    sum: f64,
    is_tuned: bool,
}

impl MemberState {
    fn of(member: &Member) -> Self {
        let Member { genome, sum, is_tuned, .. } = member;
        Self { genome: genome.canonical_bytes(), sum: *sum, is_tuned: *is_tuned }
    }

    fn read(self) -> Option<Member> {
        let Self { genome, sum, is_tuned } = self;
        let genome = Genome::from_canonical_bytes(&genome).ok()?;
        let operations = operations(&Program::lower(&genome));
        let hash = BareGenome::of(vec![genome.clone()])[0].hash;
        Some(Member { genome, hash, operations, sum, is_tuned })
    }
}

fn read(members: Vec<MemberState>) -> Option<Vec<Member>> {
    members.into_iter().map(MemberState::read).collect()
}

impl Gp {
    pub(super) fn state(&self) -> Vec<u8> {
        let members = |members: &[Member]| members.iter().map(MemberState::of).collect();
        let state = State {
            generation: self.generation,
            evaluations: self.evaluations,
            repeats: self.repeats,
            islands: self
                .islands
                .iter()
                .map(|island| (island.stale, members(&island.members)))
                .collect(),
            seen: self.seen.iter().map(|hash| *hash.as_bytes()).collect(),
            front: members(&self.front.members),
            best: self
                .best
                .as_ref()
                .map(|best| (MemberState::of(&best.member), best.fitted, best.held)),
        };
        postcard::to_stdvec(&state).expect("plain data serialises")
    }

    /// Restores a state; `None` if it does not fit this search.
    pub(super) fn set_state(&mut self, state: &[u8]) -> Option<()> {
        let state: State = postcard::from_bytes(state).ok()?;
        if state.islands.len() != self.islands.len() {
            return None;
        }
        let island = |(stale, members)| Some(Island { members: read(members)?, stale });
        let islands = state.islands.into_iter().map(island).collect::<Option<Vec<_>>>()?;
        let best = match state.best {
            Some((member, fitted, held)) => Some(Best { member: member.read()?, fitted, held }),
            None => None,
        };
        self.front = Front { members: read(state.front)? };
        let seen: VecDeque<ProgramHash> =
            state.seen.into_iter().map(ProgramHash::from_bytes).collect();
        (self.generation, self.evaluations) = (state.generation, state.evaluations);
        self.repeats = state.repeats;
        (self.islands, self.seen, self.best) = (islands, seen, best);
        Some(())
    }
}
