//! Genomes: fixed-length programs over four-component registers, models of reflectance that lie over them as layers, and
//! everything that happens to both as genotypes.
//!
//! This crate owns the instruction set, the dialects, the text and JSON forms, the content hash, the canonical
//! arithmetic that gives every opcode its bits, and the genetic operators with their counter-based random streams. It
//! refuses to know how programs are optimised, what images are, and where genomes are stored.
//!
//! ```
//! use brood_genome::{BirthKey, Dialect, Genome, Variation};
//!
//! let random = Variation::random(Dialect::default());
//! let parent = random.birth(BirthKey { seed: 1, slot: 0, attempt: 0 });
//! let text = parent.to_string();
//! assert_eq!(text.parse::<Genome>().unwrap(), parent);
//!
//! let child = Variation::mutate(&parent, 0.3).birth(BirthKey { seed: 1, slot: 7, attempt: 0 });
//! assert_ne!(child.hash(), parent.hash());
//! ```

mod arithmetic;
mod bytes;
mod dialect;
mod functions;
mod genome;
mod instruction;
mod interpret;
mod json;
mod liveness;
mod locks;
mod opcode;
mod operand;
mod random;
mod text;
mod variation;

pub use arithmetic::{Arithmetic, RANGE};
pub use bytes::{BytesError, GenomeHash, HashError};
pub use dialect::{Dialect, DialectError, OpcodeSet, Source};
pub use functions::Functions;
pub use genome::{CONSTANTS, Genome, GenomeError, LAYERS_MAX, Output, OutputError};
pub use instruction::{Instruction, InstructionError};
pub use interpret::interpret;
pub use json::JsonError;
pub use liveness::{Liveness, REGISTERS, channels_of_instructions, live_instructions};
pub use locks::{Channel, Locks, LocksError, ParameterLock};
pub use opcode::Opcode;
pub use operand::{Operand, Register, Swizzle, WriteMask};
pub use random::{BirthKey, Operator, Stream, philox4x32};
pub use text::TextError;
pub use variation::{Constraints, Variation};

pub use brood_brdf::{Input, InputMask, Model, ModelKind, Parameter, Parametrisation};
