//! Programs: the phenotype of a genome as scalar code, live operations only.
//!
//! This crate owns lowering (scalarisation, per-component dead-code removal, value numbering, folding), the program's
//! identity, its packed words, the register-allocated tape that evaluators execute, and the making of broods without
//! neutral twins. It refuses to know samples, images and how operations are executed in bulk. Lowering never changes
//! meaning: the result is bit-equal to [`brood_genome::interpret`] in canonical f32 and in the f64 reference.
//!
//! ```
//! use brood_genome::{BirthKey, Dialect, Variation};
//! use brood_program::Program;
//!
//! let genome = Variation::random(Dialect::default()).birth(BirthKey { seed: 1, slot: 0, attempt: 0 });
//! let program = Program::lower(&genome);
//! assert_eq!(Program::from_words(&program.to_words()).unwrap(), program);
//! ```

mod brood;
mod build;
mod counts;
mod execute;
mod hash;
mod lower;
mod program;
mod range;
mod tape;
mod tunable;
mod words;

pub use brood::{
    BroodRequest, Child, Draw, Judge, MAX_REDRAWS, MAX_WORTHLESS_REDRAWS, make_brood, settle_brood,
    settle_judged,
};
pub use counts::{Counts, written_operations};
pub use execute::{execute, execute_layered};
pub use hash::ProgramHash;
pub use program::{Constant, Operand, Operation, Program, Step};
pub use range::{Range, StepRange, step_ranges};
pub use tape::{Tape, TapeOperand, TapeStep};
pub use tunable::Tunable;
pub use words::WordsError;
