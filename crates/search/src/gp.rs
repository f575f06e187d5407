//! Genetic programming: islands of genomes that are bred to match samples.
//!
//! Children are made by mutation and crossover, as in a brood; parents are chosen by tournament or
//! lexicase selection. Scale and offset of every child's output are solved for by least squares,
//! and the constants of the best are tuned by their derivatives. Programs that were evaluated
//! before are skipped, and evaluation stops as soon as a sum of errors can no longer be among the
//! best. docs/maths/fit.md lists the parameters.
//!
//! `schedule` runs the generations over all islands, `island` those of one. In each, `breed` draws
//! children, `evaluate` solves for scale and offset (`scale`) and sums errors over the samples
//! (`cases`), and `tune` tunes constants. `front` collects the best of each length.

mod albedo;
pub(crate) mod breed;
mod cases;
mod checkpoint;
mod evaluate;
mod front;
mod island;
mod population;
mod scale;
mod schedule;
mod tune;

pub(crate) use albedo::Albedos;
pub use population::Population;
pub(crate) use schedule::Gp;
