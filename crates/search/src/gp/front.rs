//! Front of error against length: members better than all shorter ones.

use super::evaluate::Member;
use crate::front::offer;

/// Largest number of members of a front.
const MOST: usize = 24;

/// Members by number of operations, each with a smaller sum than all shorter ones.
#[derive(Debug, Clone, Default)]
pub(super) struct Front {
    /// From the shortest to the longest.
    pub(super) members: Vec<Member>,
}

impl Front {
    /// Adds a member if it is better than all shorter ones, and thins a front that is too long.
    pub(super) fn offer(&mut self, member: &Member) {
        offer(&mut self.members, member, |own| (own.operations, own.sum));
        if self.members.len() > MOST {
            self.thin();
        }
    }

    /// Removes the member that improves least on the next shorter one, but never the shortest or
    /// the best.
    fn thin(&mut self) {
        let gain =
            |at: &usize| self.members[at - 1].sum / self.members[*at].sum.max(f64::MIN_POSITIVE);
        let least = (1..self.members.len() - 1).min_by(|a, b| gain(a).total_cmp(&gain(b)));
        if let Some(at) = least {
            self.members.remove(at);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gp::breed::random;
    use brood_genome::{BirthKey, Dialect};
    use brood_program::Program;

    fn member(operations: u32, sum: f64) -> Member {
        let key = BirthKey { seed: 1, slot: 0, attempt: 0 };
        let genome = random(Dialect::default(), key);
        let hash = Program::lower(&genome).hash();
        Member { genome, hash, operations, sum, is_tuned: false }
    }

    fn pairs(front: &Front) -> Vec<(u32, f64)> {
        front.members.iter().map(|member| (member.operations, member.sum)).collect()
    }

    #[test]
    fn front_holds_only_members_better_than_all_shorter_ones() {
        let mut front = Front::default();
        for (operations, sum) in [(10, 5.0), (20, 4.0), (15, 6.0), (12, 4.0), (12, 4.5), (30, 1.0)]
        {
            front.offer(&member(operations, sum));
        }
        assert_eq!(pairs(&front), [(10, 5.0), (12, 4.0), (30, 1.0)]);
    }

    #[test]
    fn front_keeps_its_ends_when_thinned() {
        let mut front = Front::default();
        for operations in 1..=60 {
            front.offer(&member(operations, 100.0 / f64::from(operations)));
        }
        let pairs = pairs(&front);
        assert_eq!((pairs.len(), pairs[0].0, pairs[MOST - 1].0), (MOST, 1, 60));
    }
}
