//! Genomes: fixed-length programs over four-component registers, with models of reflectance added
//! as layers.
//!
//! - [`Genome`] is valid by construction; it has [`Instruction`]s, constants, a [`Dialect`], an
//!   [`Output`] stage and layers of [`Model`]s, or [`Effect`]s. It has a text form, a JSON form and
//!   canonical bytes, whose hash is its [`GenomeHash`].
//! - [`expand`] defines every opcode by scalar operations, [`Arithmetic`] every scalar operation,
//!   for the canonical f32 bits and for the f64 reference; [`interpret`] runs a genome with both.
//! - [`Variation`] has the genetic operators. Their randomness is a counter-based [`Stream`] for
//!   each [`BirthKey`].
//! - [`preset`] has hand-written genomes, [`believable`] programs like measured materials.
//!
//! The crate does not depend on the optimisation of programs, on images or on storage.
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
pub mod believable;
mod bytes;
mod dialect;
mod effect;
mod expand;
mod functions;
mod genome;
mod hash;
mod instruction;
mod interpret;
mod json;
mod liveness;
pub mod lobes;
mod locks;
pub mod oklab;
mod opcode;
mod operand;
mod output;
mod painting;
pub mod preset;
mod random;
mod range;
mod start;
mod steer;
mod text;
mod variation;

pub use arithmetic::{Arithmetic, Function};
pub use brood_brdf::named_enum;
pub use bytes::BytesError;
pub use dialect::{Dialect, DialectConstraints, DialectError, InitialValue, OpcodeSet};
pub use effect::{
    Basis, Effect, EffectError, EffectImage, EffectKind, EffectsError, IMAGES_MAX, ImagePlace,
    PALETTE_MAX, PALETTE_MIN, Palette, PaletteError,
};
pub use expand::{ScalarMachine, expand};
pub use functions::Functions;
pub use genome::{BUMP_LENGTH_MAX, BUMP_STRENGTH_MAX, Bump, Genome, GenomeError, LAYERS_MAX};
pub use hash::{GenomeHash, HashError, ImageHash};
pub use instruction::{Instruction, InstructionError};
pub use interpret::interpret;
pub use json::JsonError;
pub use liveness::{Liveness, channels_of_instructions, live_instructions};
pub use locks::{Channel, EffectLock, Locks, LocksError, ParameterLock};
pub use opcode::Opcode;
pub use operand::{CONSTANTS, Operand, REGISTERS, Register, Swizzle, WriteMask};
pub use output::{Output, OutputError};
pub use painting::{PaintingError, PaintingPalette, PaintingRegion, REGIONS_MAX};
pub use random::{BirthKey, Operator, Stream, philox4x32};
pub use range::RANGE;
pub use start::Start;
pub use steer::{Steer, SteerError};
pub use text::TextError;
pub use variation::{MutationScale, Variation};

pub use brood_brdf::{
    Input, InputMask, LightInput, Model, ModelKind, Parameter, ParameterKind, ParameterScale,
    ParameterValues, Parametrisation,
};
