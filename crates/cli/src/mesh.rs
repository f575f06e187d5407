//! `brood mesh`: writes a mesh with its tangents for renderers that use exported materials.

use std::path::{Path, PathBuf};

use anyhow::Result;
use brood_bench::{logging, output};
use brood_mesh::{BuiltinMesh, Mesh};
use clap::Args;
use serde_json::json;

use crate::frame::read_obj;

/// Options of `brood mesh`.
#[derive(Debug, Args)]
pub struct MeshArgs {
    /// Mesh: an OBJ file, or ball, sphere, torus, cube or knob
    mesh: String,
    /// glTF binary to write
    #[arg(long, short, value_name = "FILE.glb")]
    output: PathBuf,
}

/// Runs the command.
pub fn run(args: &MeshArgs, json: bool) -> Result<()> {
    logging::start_offline();
    let (vertices, triangles, bytes) = match BuiltinMesh::from_name(&args.mesh) {
        Some(name) => encode(&Mesh::builtin(name)),
        None => encode(read_obj(Path::new(&args.mesh))?.mesh()),
    };
    output::write_file(&args.output, &bytes)?;
    if json {
        return output::print_json(&json!({
            "path": args.output, "vertices": vertices, "triangles": triangles, "bytes": bytes.len(),
        }));
    }
    eprintln!("{}: {vertices} vertices, {triangles} triangles", args.output.display());
    Ok(())
}

fn encode(mesh: &Mesh) -> (usize, usize, Vec<u8>) {
    (mesh.vertex_count(), mesh.triangle_count(), mesh.to_glb())
}
