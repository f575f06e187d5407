//! Lights: their descriptions and JSON form, units, IES profiles, environment maps, and sampling.
//!
//! Main types: [`Light`] (JSON description of one light), [`LightAssets`] (IES profiles,
//! environment maps and images by name) and [`LightSampler`] (directions and irradiances at a
//! surface point).
//! The crate does not depend on scenes, cameras or materials, tests no occlusion and does no I/O.
//!
//! ```
//! use brood_light::{Light, LightAssets, LightSampler, Receiver};
//! use brood_mesh::{BuiltinMesh, LocalFrame, Mesh, UnitFrame};
//! use glam::DVec3;
//!
//! let json = r#"{"kind": "sphere", "position": [0, 0, 4], "flux_lm": 800, "samples": 64}"#;
//! let light: Light = serde_json::from_str(json).unwrap();
//! light.validate("/lights/0").unwrap();
//! let frame = UnitFrame::new(&Mesh::builtin(BuiltinMesh::Sphere), 1.0, [0.0; 3]);
//! let samplers = LightSampler::all(&[light], 0.0, &LightAssets::default(), &frame);
//! let surface = LocalFrame::new(DVec3::Z, DVec3::X);
//! let top = Receiver { position: DVec3::Z, frame: surface, wo: DVec3::Z, seed: 1 };
//! let mut count = 0;
//! samplers[0].for_each_sample(&top, |_, sample| count += u32::from(sample.towards.z > 0.9));
//! assert_eq!(count, 64);
//! ```

mod assets;
mod environment;
pub mod field;
mod ies;
mod image_pyramid;
mod light;
mod sampler;
mod sequence;
pub mod units;

pub use assets::{AssetRef, LightAssets};
pub use environment::{
    BuiltinEnvironment, EnvironmentError, EnvironmentMap, PrefilteredEnvironment, SPOTS_MAX, Spots,
};
pub use field::FieldError;
pub use ies::{IesError, IesErrorKind, IesProfile, Photometry};
pub use image_pyramid::ImagePyramid;
pub use light::{
    AREA_SAMPLES, AmbientLight, DirectionalLight, DiskLight, ENVIRONMENT_SAMPLES, EnvironmentLight,
    IesLight, Light, LightMove, PointLight, Quantity, RectangleLight, SphereLight, SpotLight,
    Strength,
};
pub use sampler::{CentralLight, LightSample, LightSampler, Receiver};
pub use sequence::ray_seed;
