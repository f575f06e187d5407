//! Fits of a smooth family of functions that becomes a short program: exponentials of ridges of the
//! reciprocal inputs.
//!
//! Units u_k = log2(1 + 2^(v_k . x + b_k)) of inputs x, terms e_j = 2^(w_j . (u, x)), results S_c =
//! sum over j of C_jc e_j with C >= 0, and f = S^2, as the machine squares. Only C differs between
//! channels. f is reciprocal and non-negative for any parameters. docs/maths/fit.md explains the
//! family and how its parameters are found.

mod albedo;
mod batch;
mod bounds;
mod checkpoint;
mod finish;
mod flux;
mod guard;
mod known;
mod normal_equations;
mod product;
mod program;
mod prune;
mod refine;
mod schedule;
mod seed;
mod shape;
mod sweep;

pub(crate) use albedo::{ANGLES, IMPORTANCE};
pub use batch::Batch;
pub(crate) use checkpoint::outcome;
pub use finish::Fitted;
pub use program::LobesError;
pub use schedule::Fit;
pub use shape::{Lobes, Shape};
