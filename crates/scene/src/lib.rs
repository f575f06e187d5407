//! Scene descriptions, and the sample sets rendered from them.
//!
//! Main types: [`Scene`] (JSON description of mesh, camera, lights and film) and [`SampleSet`]
//! (batch of direction pairs with irradiance, the input of every evaluator). The crate does not
//! depend on programs or materials and does no I/O. All geometry is computed in f64; results are
//! bit-identical for any number of threads.
//!
//! ```
//! use brood_mesh::{BuiltinMesh, Mesh};
//! use brood_scene::{SampleSet, Scene};
//!
//! let scene = Scene::default();
//! scene.validate().unwrap();
//! let samples = SampleSet::render(&Mesh::builtin(BuiltinMesh::Sphere), &scene, 32, 1);
//! assert!(samples.counts().lit <= samples.counts().covered);
//! assert_eq!(samples.irradiance()[0].len(), samples.len());
//! ```

mod backdrop;
mod clip_from;
mod correction;
mod description;
mod prefiltered;
mod refine;
mod sample_set;
mod stage;

pub use backdrop::{backdrop_colors, backdrop_radiance, colors_towards, radiance_towards};
pub use clip_from::{ClipFrom, ClipFromError};
pub use correction::{CameraMove, Correction};
pub use description::{
    Backdrop, Camera, EV_MAX, Exposure, Film, Ground, LIGHT_SAMPLES_MAX, LIGHTS_MAX, LookAtCamera,
    MeshRef, NormalMap, Normals, OBJECTS_MAX, OrbitCamera, OrthographicCamera, Scene, SceneObject,
    SpherePole, Tangents, Tone,
};
pub use prefiltered::{
    LitPoint, LobeNodes, LobeShape, LobeTable, NODES, NODES_TOGETHER, PixelBetween,
    PrefilteredLight, SphereLayout,
};
pub use refine::Refine;
pub use sample_set::{
    ImageLayout, LeavingRay, LightTerms, LitAngles, PictureSize, PictureSizeError, PixelArea,
    PixelAreaError, PixelRays, PixelRun, PixelSpan, PixelTerms, Raster, RayEnd, RayEnds,
    SampleCounts, SampleSet, Sampling, SamplingError, Seen, Toggles, WayOut, above_horizon,
};
pub use stage::{Stage, TextureBumps};
