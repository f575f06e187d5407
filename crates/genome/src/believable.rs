//! Believable programs: lobes whose parameters are drawn from those of measured materials, so that
//! they look like materials, and vary by parameters, so that their children do too.
//!
//! All programs of a [`Structure`] have the same instructions; only constants differ. Their shapes
//! are drawn from `anchors.csv`, which the example `anchor` of the search crate makes.
//! docs/maths/believable.md has the distribution.

mod anchor;
mod colour;
mod draw;
mod parameters;
mod pattern;
mod program;
mod structure;
mod vary;

pub use anchor::Class;
pub use parameters::assign_roles;
pub use structure::{Structure, TERMS, WEIGHTS, Weight, dialect, shape, weights};

pub(crate) use draw::genome;
pub(crate) use program::structure_of;
pub(crate) use vary::{Rules, mutate, recombine};

#[cfg(test)]
#[path = "believable_tests.rs"]
mod tests;
