//! Scene descriptions, meshes, lights, and the sample sets rendered from them.
//!
//! Main types: [`Scene`] (JSON description of mesh, camera, lights and film), [`Mesh`] (validated
//! triangles, built in or read from OBJ bytes with [`parse_obj`]), [`LightAssets`] (IES profiles
//! and environment maps by name) and [`SampleSet`] (batch of direction pairs with irradiance, the
//! input of every evaluator). The crate does not depend on programs or materials and does no I/O.
//! All geometry is computed in f64; results are bit-identical for any number of threads.
//!
//! ```
//! use brood_scene::{BuiltinMesh, Mesh, SampleSet, Scene};
//!
//! let scene = Scene::default();
//! scene.validate().unwrap();
//! let samples = SampleSet::render(&Mesh::builtin(BuiltinMesh::Sphere), &scene, 32, 1);
//! assert!(samples.counts().lit <= samples.counts().covered);
//! assert_eq!(samples.irradiance()[0].len(), samples.len());
//! ```

mod angle;
mod description;
mod environment;
mod gltf;
mod ies;
mod light_assets;
mod mesh;
mod obj;
mod sample_set;
mod trace;
pub mod units;

pub(crate) use description::Measure;
pub use description::{
    AREA_SAMPLES, AmbientLight, BuiltinMesh, Camera, DirectionalLight, DiskLight,
    ENVIRONMENT_SAMPLES, EV_MAX, EnvironmentLight, Exposure, Film, IesLight, LIGHT_SAMPLES_MAX,
    LIGHTS_MAX, Light, MeshRef, Normals, PointLight, Quantity, RectangleLight, Scene, SceneError,
    SphereLight, SpotLight, Strength, Tone,
};
pub use environment::{EnvironmentError, EnvironmentMap};
pub use ies::{IesError, IesErrorKind, IesProfile, Photometry};
pub use light_assets::{AssetRef, LightAssets};
pub use mesh::{Mesh, MeshError, MeshParts};
pub use obj::{ObjError, ObjErrorKind, ObjFile, ObjLimits, ObjWarning, parse_obj};
pub use sample_set::{
    ImageLayout, PixelArea, PixelAreaError, PixelRun, PixelSpan, Raster, SampleCounts, SampleSet,
    Sampling, SamplingError,
};
