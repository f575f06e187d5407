//! Believable programs: lobes whose parameters are drawn from those of measured materials, so that
//! they look like materials, and vary by parameters, so that their children do too.
//!
//! All have the same instructions ([`dialect`], [`shape`]); only constants differ. Their shapes are
//! drawn from `anchors.csv`, which the example `anchor` of the search crate makes.
//! docs/maths/believable.md has the distribution.

mod anchor;
mod colour;
mod draw;
mod parameters;
mod structure;
mod vary;

pub use anchor::Class;
pub use parameters::assign_roles;
pub use structure::{TERMS, WEIGHTS, Weight, dialect, shape, weights};

pub(crate) use draw::genome;
pub(crate) use vary::{mutate, recombine};

#[cfg(test)]
#[path = "believable_tests.rs"]
mod tests;
