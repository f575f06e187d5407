//! The objects beside the subject: their meshes, and their pictures, which a brood shares.

use std::sync::{Arc, PoisonError};

use brood_eval::Surroundings;
use brood_mesh::BuiltinMesh;
use brood_program::Program;
use brood_protocol::{Frame, MeshSource, PictureFormat};
use brood_scene::{MeshRef, Scene};

use crate::cache::{LoadedMesh, Raster};
use crate::error::RenderError;
use crate::renderer::Renderer;
use crate::shot::Shot;

impl Renderer {
    /// Replaces the uploaded meshes that frames may name for objects beside the subject.
    pub fn set_object_meshes(&self, meshes: Vec<Arc<LoadedMesh>>) {
        *self.object_meshes.lock().unwrap_or_else(PoisonError::into_inner) = meshes;
    }

    /// Returns the meshes of a scene's other objects, then that of its ground.
    ///
    /// # Errors
    /// [`RenderError::Objects`] if the frame has not one source for each;
    /// [`RenderError::MeshContent`] if an uploaded mesh was not given.
    pub(crate) fn objects(
        &self,
        frame: &Frame,
        scene: &Scene,
    ) -> Result<Vec<Arc<LoadedMesh>>, RenderError> {
        let (expected, given) = (scene.materials().count(), frame.objects.len());
        if expected != given {
            return Err(RenderError::Objects { expected, given });
        }
        let names = scene.objects.iter().map(|object| match &object.mesh {
            MeshRef::Builtin(mesh) => Some(*mesh),
            MeshRef::Uploaded(_) => None,
        });
        let names = names.chain(scene.ground.iter().map(|_| Some(BuiltinMesh::Ground)));
        let mesh = |(source, name): (MeshSource, Option<BuiltinMesh>)| match (source, name) {
            (MeshSource::Builtin, Some(name)) => Ok(self.builtin(name)),
            (MeshSource::Uploaded(hash), _) => {
                let meshes = self.object_meshes.lock().unwrap_or_else(PoisonError::into_inner);
                let found = meshes.iter().find(|mesh| *mesh.hash() == hash);
                found.cloned().ok_or(RenderError::MeshContent)
            }
            (MeshSource::Builtin | MeshSource::Target, _) => Err(RenderError::MeshContent),
        };
        frame.objects.iter().map(|object| object.mesh).zip(names).map(mesh).collect()
    }

    /// Returns the pictures of the objects beside the subject; `None` if there are none.
    pub(crate) fn surroundings(
        &self,
        shot: &Shot<'_>,
    ) -> Result<Option<Arc<Surroundings>>, RenderError> {
        let Shot { view, frame, film, area } = shot;
        if view.parts() == 1 {
            return Ok(None);
        }
        let mut linear = (*frame).clone();
        linear.format = PictureFormat::Exr;
        let make = || {
            let mut around = Surroundings::default();
            for (part, object) in (1..).zip(&frame.objects) {
                let program = self.program(&object.words)?;
                let view = view.with_part(part);
                let own = Shot { view, frame: &linear, film: *film, area: *area };
                let mut image =
                    self.shaded(&own, &[&*program], |_: &Program, picture| picture.radiance())?;
                let image = image.pop().expect("one picture of one program");
                around.add(image, program.is_painted());
            }
            Ok(around)
        };
        let raster = Raster { size_px: frame.size_px, sampling: frame.sampling, area: *area };
        // The frame's own light decides the view; its film decides nothing.
        let mut hasher = blake3::Hasher::new();
        for object in &frame.objects {
            let words = object.words.iter().flat_map(|word| word.to_le_bytes());
            hasher.update(&words.collect::<Vec<u8>>()).update(b"material");
        }
        hasher.update(&[u8::from(frame.backend == brood_protocol::Backend::Reference)]);
        let made = self.caches.surroundings((view, raster), &hasher.finalize(), make)?;
        Ok(Some(made))
    }
}
