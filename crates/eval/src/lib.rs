//! Evaluation on the CPU: programs on sample sets, radiance images, film, encoded pictures.
//!
//! This crate owns the [`Evaluator`] trait, the canonical f32 evaluator ([`CanonicalEvaluator`]),
//! the f64 reference ([`ReferenceEvaluator`]), fitness and its derivatives ([`FitnessTarget`],
//! [`normal_equations`]), the energy limit ([`energy_limit`], [`express`]), shading and film
//! ([`shade`], [`develop`]), picture codecs, and the [`conformance`] suite of all evaluators. It
//! does not depend on files, networks or jobs: an evaluator sees a `Program` or a `Brdf`, and a
//! `SampleSet`.
//!
//! ```
//! use brood_eval::{CanonicalEvaluator, Evaluator, develop, encode_png, express, shade};
//! use brood_mesh::{BuiltinMesh, Mesh};
//! use brood_scene::{Exposure, SampleSet, Scene};
//!
//! let program = express(&"brood 1\n.model lambert\n".parse().unwrap());
//! let set = SampleSet::render(&Mesh::builtin(BuiltinMesh::Sphere), &Scene::default(), 16, 1);
//! let mut f = Vec::new();
//! CanonicalEvaluator::default().eval(&[&program], &set, &mut f).unwrap();
//! assert_eq!(f.len(), 3 * set.len());
//! let picture = develop(&shade(&set, &f), Exposure::Auto);
//! assert!(!encode_png(picture.width, picture.height, &picture.rgba).is_empty());
//! ```

mod bumps;
mod canonical;
pub mod conformance;
mod derivative;
mod energy;
mod evaluator;
mod film;
mod fitness;
mod lanes;
mod layer;
mod lit_angles;
mod lit_spheres;
mod model;
mod picture;
mod prefiltered;
mod preview;
mod radiance;
mod ray_ends;
mod reference;
mod reflected;
mod rounding;
mod steering;

pub use brood_brdf::{Level, SimdKernel};
pub use bumps::{TurnedPair, texture_bumps};
pub use canonical::CanonicalEvaluator;
pub use derivative::{Direction, NormalEquations, normal_equations};
pub use energy::{
    ALBEDO_ORDER, ClimbStage, Effort, EnergyLimit, FLATTEST_COS, Incidence, LimitSearch, LobeRule,
    Quadrature, UNBOUNDED_COS, channel_albedos, channel_albedos_at, direction_at, direction_pair,
    directional_albedo, energy_limit, express, express_brood, express_child, is_anisotropic,
    limited,
};
pub use evaluator::{EvalError, EvalResult, Evaluator, Lowered};
pub use film::{
    Developed, FineSamples, Gain, LitBackdrop, Refinement, RoughTile, Surroundings, decode_srgb,
    develop, develop_colors, develop_exposed, develop_samples, encode_srgb, linear_colors,
    refine_lone_rays, refine_radiance, rough_pixels, rough_tile_count, rough_tiles,
};
pub use fitness::{
    CanonicalPopulation, Fitness, FitnessEvaluator, FitnessPopulation, FitnessTarget, Loss, Ranked,
    Screening, Selected, TargetError, select_best,
};
pub use lit_angles::{are_angles, encode_angles};
pub use lit_spheres::{BACKDROP_TEXELS, LitSpheres};
pub use model::{model_error, model_reflectance};
pub use picture::{
    DisplayPicture, EnvironmentFileError, IMAGE_SIDE_MOST, LinearPicture, LinearPictureError,
    PictureError, SheetCell, centre_px, decode_display, decode_environment, decode_image,
    decode_linear, decode_png, encode_apng, encode_exr, encode_png, picture_size, sheet,
};
pub use prefiltered::{GatheredLight, is_prefilterable, lobe_tables, shade_prefiltered};
pub use preview::{Preview, PreviewScorer, diverse_brood};
pub use radiance::{RadianceImage, shade, shade_brdf, shade_each};
pub use ray_ends::{are_ray_ends, encode_ray_ends};
pub use reference::ReferenceEvaluator;
pub use reflected::ReflectedLevels;
pub use steering::{Appearance, steered_brood};
