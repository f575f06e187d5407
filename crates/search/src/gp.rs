//! Genetic programs: islands of genomes that are bred against samples.
//!
//! Children come of mutation and recombination as a brood's do; parents are chosen by tournaments or by lexicase selection. Scale and
//! offset of every child are solved for, constants of the best are tuned by their derivatives. Programs that were there before are not
//! evaluated again, and evaluation ends as soon as a sum cannot be among the best. docs/maths/fit.md has the amounts.

pub(crate) mod breed;
mod cases;
mod checkpoint;
mod front;
mod island;
mod judge;
mod population;
mod scale;
mod schedule;
mod tune;

pub use population::Population;
pub(crate) use schedule::Gp;
