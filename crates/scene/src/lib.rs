//! What is looked at and how: meshes, scenes and the sample sets that are made of them.
//!
//! This crate owns the description of a scene as people write it, meshes (made by code or read from OBJ bytes), their
//! tangent frames, the rays of a camera and the [`SampleSet`], the one batch type that every evaluator shades. It
//! refuses to know programs, materials, images in colours, files and sockets. All geometry is computed in f64 and is
//! the same to the bit whatever the number of threads.
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
mod mesh;
mod obj;
mod sample_set;
mod trace;

pub use description::{
    BuiltinMesh, Camera, EV_MAX, Exposure, Film, LIGHTS_MAX, Light, MeshRef, Scene, SceneError,
    Tone,
};
pub use mesh::{Mesh, MeshError, MeshParts};
pub use obj::{ObjError, ObjErrorKind, ObjFile, ObjLimits, ObjWarning, parse_obj};
pub use sample_set::{
    ImageLayout, PixelArea, PixelAreaError, PixelRun, PixelSpan, SampleCounts, SampleSet, Sampling,
    SamplingError,
};
