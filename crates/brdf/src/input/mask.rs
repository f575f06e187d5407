//! Sets of inputs.

use super::catalogue::Input;

/// Number of words of a mask.
const WORDS: usize = Input::ALL.len().div_ceil(64);

/// A set of inputs, one bit each.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, PartialOrd, Ord)]
pub struct InputMask([u64; WORDS]);

impl InputMask {
    /// The empty set.
    pub const EMPTY: Self = Self([0; WORDS]);

    /// Adds one input.
    #[inline]
    pub fn insert(&mut self, input: Input) {
        self.0[input.index() / 64] |= 1 << (input.index() % 64);
    }

    /// True if the input is in the set.
    #[inline]
    #[must_use]
    pub fn contains(self, input: Input) -> bool {
        self.0[input.index() / 64] >> (input.index() % 64) & 1 == 1
    }

    /// Returns the inputs of either set.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self(std::array::from_fn(|word| self.0[word] | other.0[word]))
    }

    /// Iterates over the inputs in the order of their indices.
    #[inline]
    pub fn iter(self) -> impl Iterator<Item = Input> {
        (0..WORDS).flat_map(move |word| {
            let mut rest = self.0[word];
            std::iter::from_fn(move || {
                let bit = rest.trailing_zeros() as usize;
                let input = Input::ALL.get(64 * word + bit).copied().filter(|_| rest != 0)?;
                rest &= rest - 1;
                Some(input)
            })
        })
    }

    /// Number of inputs.
    #[must_use]
    pub fn len(self) -> usize {
        self.0.iter().map(|word| word.count_ones() as usize).sum()
    }

    /// True if the set has no inputs.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self == Self::EMPTY
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
