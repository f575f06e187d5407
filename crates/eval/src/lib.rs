//! Evaluation on the CPU: programs on sample sets, radiance images, film, encoded pictures.
//!
//! This crate owns the evaluator trait, the canonical f32 evaluator, the f64 reference, development of pictures, and
//! the conformance suite that every evaluator anywhere passes. It refuses to know genomes as genotypes, meshes,
//! cameras, files and networks: it sees a `Program` or a `Brdf`, and a `SampleSet`.

mod canonical;
pub mod conformance;
mod derivative;
mod energy;
mod evaluator;
mod film;
mod fitness;
mod layer;
mod level;
mod model;
mod picture;
mod preview;
mod radiance;
mod reference;

pub use canonical::{CanonicalEvaluator, Work};
pub use derivative::{Direction, NormalEquations, normal_equations};
pub use energy::{
    ALBEDO_ORDER, Effort, EnergyLimit, LimitSearch, LobeRule, Place, Quadrature, around,
    channel_albedos, directional_albedo, energy_limit, express, express_brood, limited, pair,
    turns_with_surface,
};
pub use evaluator::{EvalError, Evaluator};
pub use film::{
    Developed, FineSamples, Gain, RoughTile, develop, develop_samples, encode_srgb,
    rough_tile_count, rough_tiles,
};
pub use fitness::{
    CanonicalPopulation, Fitness, FitnessEvaluator, FitnessTarget, Loss, Population, Ranked,
    Screening, Selected, TargetError, select_best,
};
pub use level::Level;
pub use model::{model_error, model_reflectance};
pub use picture::{
    EnvironmentFileError, LinearPicture, LinearPictureError, PictureError, SheetCell, centre_px,
    decode_environment, decode_linear, decode_png, encode_apng, encode_exr, encode_png,
    picture_size, sheet,
};
pub use preview::{Look, Previewer, diverse_brood};
pub use radiance::{RadianceImage, shade, shade_each};
pub use reference::ReferenceEvaluator;
