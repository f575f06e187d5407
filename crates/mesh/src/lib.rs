//! Triangle meshes: built in or read from OBJ bytes, with normals, tangents and ray tracing.
//!
//! Main types: [`Mesh`] (validated triangles, from [`Mesh::builtin`] or [`parse_obj`]), the ray
//! tracer in [`trace`], and the frames of reference [`UnitFrame`] (a mesh moved and scaled to
//! radius 1) and [`LocalFrame`] (a point of its surface). The crate does not depend on cameras,
//! lights or materials and does no I/O. All geometry is computed in f64.
//!
//! ```
//! use brood_mesh::{BuiltinMesh, Mesh, ObjLimits, parse_obj};
//!
//! let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
//! let file = parse_obj(text.as_bytes(), &ObjLimits::default()).unwrap();
//! assert_eq!(file.mesh.triangle_count(), 1);
//! assert!(file.warnings[0].text.starts_with("no texture coordinates"));
//! assert!(Mesh::builtin(BuiltinMesh::Torus).to_glb().starts_with(b"glTF"));
//! ```

pub mod angle;
mod frame;
mod gltf;
mod mesh;
mod obj;
pub mod trace;

pub use frame::{FrameChange, LocalFrame, UnitFrame};
pub use mesh::{BuiltinMesh, GROUND_RADII, Mesh, MeshError, MeshParts, fixed_tangent};
pub use obj::{ObjError, ObjErrorKind, ObjFile, ObjLimits, ObjWarning, parse_obj};
