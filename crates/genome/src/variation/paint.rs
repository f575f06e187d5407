//! Random painted genomes, and mutation and crossover of effects.
//!
//! Colours change in Oklab, the palette as a whole, so that children keep a range of lightness that
//! shows the shape. docs/maths/variation.md has the rates.

mod painting;
mod palette;
mod random;
mod recombine;
mod threshold;
mod toon;
mod value;

mod mutate;

pub(super) use mutate::mutate;
pub(super) use painting::color;
pub(super) use random::random;
pub(super) use recombine::recombine;
pub(super) use toon::{are_mixed, matched, painted_by};

#[cfg(test)]
#[path = "paint_tests.rs"]
mod tests;

#[cfg(test)]
#[path = "painting_tests.rs"]
mod painting_tests;
