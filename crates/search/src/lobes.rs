//! Fits of a smooth family of functions that becomes a short program: sums of exponentials of
//! quantities that do not change when `wi` and `wo` are exchanged.
//!
//! Units u_k = log2(1 + 2^(v_k . x + b_k)) of inputs x, terms e_j = 2^(w_j . (u, x)), results S_c =
//! sum over j of C_jc e_j with C >= 0, and f = S^2, as the machine squares. Only C differs between
//! channels. f is reciprocal and non-negative for any parameters. docs/maths/fit.md explains the
//! family and how its parameters are found.
//!
//! Names in the code: v and w are weights, b is a bias, C a colour (stored as log2 C). The features
//! are (u, x, 1). A slot is the argument of a term's or a unit's exponential, that is a weighted
//! sum of features. Samples are stored in blocks of 256 lanes, one sample per lane. A bound is a
//! one-sided sample: only an f above it (or below it) has a residual.
//!
//! `schedule` runs the generations. `seed` draws random starts; `refine` fits them by
//! Levenberg-Marquardt steps, whose sums are in `normal_equations`, `sweep` and `product`. `known`
//! and `bounds` derive bounds from samples, `albedo` and `flux` compute directional albedos, and
//! `guard` enforces both. `finish` prunes the best fit (`prune`).

mod albedo;
mod batch;
mod block;
mod bounds;
mod checkpoint;
mod finish;
mod flux;
mod guard;
mod known;
mod normal_equations;
mod product;
mod prune;
mod refine;
mod restricted;
mod schedule;
mod seed;
mod shape;
mod sweep;
mod terms;

pub(crate) use albedo::{ANGLES, IMPORTANCE};
pub use batch::Batch;
pub(crate) use checkpoint::outcome;
pub use finish::Fitted;
pub use restricted::{Restricted, fit_restricted};
pub use schedule::Fit;
pub use shape::Lobes;
pub use terms::Terms;
