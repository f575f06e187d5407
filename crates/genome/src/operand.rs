//! Operands and destinations of instructions: registers, swizzles, write masks.

use std::fmt;

/// Largest number of temporary registers of a genome.
pub const REGISTERS: usize = 16;

/// Number of constant registers.
pub const CONSTANTS: usize = 128;

/// Names of the four components.
pub(crate) const LETTERS: [char; 4] = ['x', 'y', 'z', 'w'];

/// Register that an operand reads.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Register {
    /// R0..R15; the dialect sets the number of registers.
    Temporary(u8),
    /// C0..C127.
    Constant(u8),
}

impl fmt::Display for Register {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Temporary(index) => write!(f, "R{index}"),
            Self::Constant(index) => write!(f, "C{index}"),
        }
    }
}

/// Source component of each of the four places; two bits for each place, x in the lowest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Swizzle(u8);

impl Swizzle {
    /// xyzw.
    pub const IDENTITY: Self = Self(0b11_10_01_00);

    /// Returns the swizzle whose place k reads component `components[k]` (modulo 4).
    #[must_use]
    pub fn new(components: [u8; 4]) -> Self {
        let [x, y, z, w] = components.map(|component| component & 3);
        Self(x | (y << 2) | (z << 4) | (w << 6))
    }

    /// Returns the swizzle that reads one component in all four places.
    #[must_use]
    pub fn splat(component: u8) -> Self {
        Self::new([component; 4])
    }

    /// Returns the swizzle with these bits. Every byte is a valid swizzle.
    #[must_use]
    pub fn from_bits(bits: u8) -> Self {
        Self(bits)
    }

    /// Bits of the swizzle: two for each place, x in the lowest.
    #[inline]
    #[must_use]
    pub fn bits(self) -> u8 {
        self.0
    }

    /// Component (0..4) that place (0..4) reads.
    #[inline]
    #[must_use]
    pub fn component(self, place: usize) -> usize {
        usize::from(self.0 >> (2 * place) & 3)
    }

    /// True if all places read the same component.
    #[inline]
    #[must_use]
    pub fn is_splat(self) -> bool {
        self.0 == Self::splat(self.0).0
    }
}

impl fmt::Display for Swizzle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if *self == Self::IDENTITY {
            return Ok(());
        }
        let places = if self.is_splat() { 1 } else { 4 };
        write!(f, ".")?;
        (0..places).try_for_each(|place| write!(f, "{}", LETTERS[self.component(place)]))
    }
}

/// An operand of an instruction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Operand {
    /// Register that is read.
    pub register: Register,
    /// Components that are read.
    pub swizzle: Swizzle,
    /// True if the value is negated.
    pub negate: bool,
}

impl fmt::Display for Operand {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}{}", if self.negate { "-" } else { "" }, self.register, self.swizzle)
    }
}

/// Components of the destination that are written: a non-empty subset, bit 0 = x.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct WriteMask(u8);

impl WriteMask {
    /// xyzw.
    pub const ALL: Self = Self(15);

    /// Returns the mask with these bits, or `None` for the empty mask and for bits beyond w.
    #[must_use]
    pub fn new(bits: u8) -> Option<Self> {
        (1..=15).contains(&bits).then_some(Self(bits))
    }

    /// Bits of the mask; bit 0 = x.
    #[inline]
    #[must_use]
    pub fn bits(self) -> u8 {
        self.0
    }

    /// True if component 0..4 is written.
    #[must_use]
    pub fn contains(self, component: usize) -> bool {
        self.0 >> component & 1 == 1
    }
}

impl fmt::Display for WriteMask {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if *self == Self::ALL {
            return Ok(());
        }
        write!(f, ".")?;
        (0..4).filter(|c| self.contains(*c)).try_for_each(|c| write!(f, "{}", LETTERS[c]))
    }
}
