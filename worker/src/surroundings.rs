//! The objects beside the subject: their meshes, and their pictures, which a brood shares.

use std::sync::{Arc, PoisonError};

use brood_eval::{Gain, Surroundings};
use brood_mesh::BuiltinMesh;
use brood_program::Program;
use brood_protocol::{Backend, Frame, MeshSource, PictureFormat};
use brood_scene::{Exposure, Film, MeshRef, PictureSize, PixelArea, Sampling, Scene};

use crate::cache::{LoadedMesh, Raster};
use crate::error::RenderError;
use crate::renderer::Renderer;
use crate::shot::Shot;

/// Longer side of the pictures in which the exposure of a ground is measured, pixels.
const METERED_PX: u32 = 64;
/// Stops from the value that automatic exposure gives a percentile, 0.9, down to one half.
const STOPS_BELOW: f64 = 0.847_996_906_554_950_1;

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

    /// Returns the film of a shot with the exposure that its ground decides: where exposure is
    /// automatic, the ground's 97th percentile becomes one half, so that all materials of a brood
    /// are seen in one light. The film is unchanged without a lit ground in the picture.
    pub(crate) fn ground_exposure(&self, shot: &Shot<'_>) -> Result<Film, RenderError> {
        let Shot { view, frame, film, .. } = shot;
        let is_decided = film.exposure == Exposure::Auto && view.scene().ground.is_some();
        let Some(object) = frame.objects.last().filter(|_| is_decided && view.parts() > 1) else {
            return Ok(*film);
        };
        let program = self.program(&object.words)?;
        if program.is_painted() {
            return Ok(*film);
        }
        // Of one size, so that pictures of all sizes have one exposure.
        let PictureSize { width, height } = frame.size_px;
        let longer = frame.size_px.longer();
        let of_side = |side: u32| (side * METERED_PX / longer).max(1);
        let size_px = PictureSize { width: of_side(width), height: of_side(height) };
        let mut metered = (*frame).clone().with_area(None);
        (metered.format, metered.sampling) = (PictureFormat::Exr, Sampling::Adaptive);
        metered.size_px = size_px;
        let view = view.with_part(view.parts() - 1);
        let area = PixelArea::whole(size_px);
        let key = self.caches.metered_key(&view, size_px, &program);
        let ev = match self.caches.metered(key) {
            Some(ev) => ev,
            None => {
                let shot = Shot { view, frame: &metered, film: *film, area };
                let image =
                    self.shaded(&shot, &[&*program], |_: &Program, picture| picture.radiance())?;
                let image = image.first().expect("one picture of one program");
                let is_seen = image.coverage().iter().any(|coverage| *coverage > 0.0);
                let ev = is_seen.then(|| Gain::of_image(Exposure::Auto, image).ev - STOPS_BELOW);
                self.caches.keep_metered(key, ev);
                ev
            }
        };
        Ok(ev.map_or(*film, |ev| Film { exposure: Exposure::Ev(ev), ..*film }))
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
            let ev = match self.ground_exposure(shot)?.exposure {
                Exposure::Ev(ev) => Some(ev),
                Exposure::Auto => None,
            };
            let mut around = Surroundings { ev, ..Surroundings::default() };
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
        let mut hasher = blake3::Hasher::new();
        for object in &frame.objects {
            let words = object.words.iter().flat_map(|word| word.to_le_bytes());
            hasher.update(&words.collect::<Vec<u8>>()).update(b"material");
        }
        hasher.update(&[u8::from(frame.backend == Backend::Reference)]);
        hasher.update(format!("{:?}", film.exposure).as_bytes());
        let made = self.caches.surroundings((view, raster), &hasher.finalize(), make)?;
        Ok(Some(made))
    }
}
