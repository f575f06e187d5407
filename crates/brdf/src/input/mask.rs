//! Sets of inputs.

use super::catalogue::Input;

/// A set of inputs, one bit each.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, PartialOrd, Ord)]
pub struct InputMask(u128);

impl InputMask {
    /// The empty set.
    pub const EMPTY: Self = Self(0);

    /// Adds one input.
    #[inline]
    pub fn insert(&mut self, input: Input) {
        self.0 |= 1 << input.index();
    }

    /// True if the input is in the set.
    #[inline]
    #[must_use]
    pub fn contains(self, input: Input) -> bool {
        self.0 >> input.index() & 1 == 1
    }

    /// Returns the inputs of either set.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Iterates over the inputs in the order of their indices.
    #[inline]
    pub fn iter(self) -> impl Iterator<Item = Input> {
        let mut rest = self.0;
        std::iter::from_fn(move || {
            let input = Input::ALL.get(rest.trailing_zeros() as usize).copied()?;
            rest &= rest - 1;
            Some(input)
        })
    }

    /// Number of inputs.
    #[must_use]
    pub fn len(self) -> usize {
        self.0.count_ones() as usize
    }

    /// True if the set has no inputs.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }
}

impl FromIterator<Input> for InputMask {
    fn from_iter<I: IntoIterator<Item = Input>>(inputs: I) -> Self {
        let mut mask = Self::EMPTY;
        for input in inputs {
            mask.insert(input);
        }
        mask
    }
}
