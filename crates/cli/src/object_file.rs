//! Objects of a scene file: meshes and materials in its folder.

use std::path::Path;

use anyhow::{Context, Result, bail};
use brood_bench::material_file::{self, MaterialFile};
use brood_eval::express;
use brood_genome::preset::{Preset, neutral};
use brood_protocol::{MeshSource, ObjectSource};
use brood_scene::{MeshRef, Scene};
use brood_worker::Renderer;

use crate::frame::read_obj;

/// Reads the meshes and materials of a scene's other objects and of its ground: OBJ files and
/// genomes in `folder`, unless they are built-in meshes or presets. Hands the meshes to the
/// renderer.
///
/// # Errors
/// If a file cannot be read, or a material is a table of measured values.
pub fn read(scene: &Scene, folder: &Path, renderer: &Renderer) -> Result<Vec<ObjectSource>> {
    let mut meshes = Vec::new();
    let mut sources = Vec::new();
    for (index, object) in scene.objects.iter().enumerate() {
        sources.push(match &object.mesh {
            MeshRef::Builtin(_) => MeshSource::Builtin,
            MeshRef::Uploaded(file) => {
                let mesh = read_obj(&folder.join(file))
                    .with_context(|| format!("/objects/{index}/mesh of the scene"))?;
                let source = MeshSource::Uploaded(*mesh.hash());
                meshes.push(mesh.into());
                source
            }
        });
    }
    renderer.set_object_meshes(meshes);
    sources.extend(scene.ground.iter().map(|_| MeshSource::Builtin));
    let source = |((name, pointer), mesh): ((Option<&str>, String), MeshSource)| {
        let words = words(name, folder).with_context(|| format!("{pointer} of the scene"))?;
        Ok(ObjectSource { mesh, words })
    };
    scene.materials().zip(sources).map(source).collect()
}

/// Returns the words of a preset, or of the genome in a file.
fn words(name: Option<&str>, folder: &Path) -> Result<Vec<u32>> {
    let Some(name) = name else { return Ok(express(neutral()).to_words()) };
    if let Some(preset) = Preset::find(name) {
        return Ok(express(preset.genome()).to_words());
    }
    match material_file::read_with(&folder.join(name), false)? {
        MaterialFile::Bred(genome) => Ok(express(&genome).to_words()),
        MaterialFile::Measured(..) => bail!("{name} is a table of measured values, not a genome"),
    }
}
