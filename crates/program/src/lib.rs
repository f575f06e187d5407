//! Lowering of genomes to programs: the phenotype as scalar code, live operations only.
//!
//! This crate owns lowering (scalarisation, per-component dead-code removal, value numbering,
//! constant folding), the program hash, the packed words of a program, the register-allocated
//! [`Tape`] that interpreters execute, and the making of broods without neutral twins. The main
//! types are [`Program`], [`ProgramHash`], [`Tape`], [`Tunable`] (constants stay parameters) and
//! [`BroodRequest`]. The crate does not depend on samples, images or the execution of operations in
//! bulk.
//!
//! Lowering never changes meaning: the result is bit-equal to [`brood_genome::interpret`] in
//! canonical f32 and in the f64 reference.
//!
//! ```
//! use brood_genome::{BirthKey, Dialect, Variation};
//! use brood_program::Program;
//!
//! let random = Variation::random(Dialect::default());
//! let genome = random.birth(BirthKey { seed: 1, slot: 0, attempt: 0 });
//! let program = Program::lower(&genome);
//! assert!(program.operations() > 0);
//! assert_eq!(Program::from_words(&program.to_words()).unwrap(), program);
//! ```

mod brood;
mod build;
mod bump;
mod counts;
mod execute;
mod hash;
mod lower;
mod operation;
mod paint;
mod program;
mod range;
mod tape;
mod tunable;
mod words;

pub use brood::{
    BroodRequest, Child, Draw, DrawScorer, MAX_REDRAWS, MAX_UNWANTED_REDRAWS, make_brood,
    settle_brood, settle_scored,
};
pub use counts::{Counts, written_operations};
pub use execute::{execute, execute_layered};
pub use hash::ProgramHash;
pub use operation::{Binary, Operation};
pub use program::{Bumps, Constant, Meaning, Operand, Program, Step};
pub use range::{Range, StepRange, step_ranges};
pub use tape::{Tape, TapeOperand, TapeStep};
pub use tunable::Tunable;
pub use words::WordsError;
