//! The objects beside the subject: their meshes, and their pictures, which a brood shares.

use std::sync::{Arc, PoisonError};

use brood_eval::{Gain, LitBackdrop, Surroundings};
use brood_mesh::BuiltinMesh;
use brood_program::Program;
use brood_protocol::{Backend, Frame, MeshSource, ObjectSource, PictureFormat};
use brood_scene::{Exposure, Film, MeshRef, PictureSize, PixelArea, Sampling, Scene};

use crate::error::RenderError;
use crate::evaluated_picture::EvaluatedPicture;
use crate::renderer::Renderer;
use crate::scene_view::{LoadedMesh, Raster, SceneView};
use crate::shot::Shot;

/// Longer side of the pictures in which the exposure of a ground is measured, pixels.
const METERED_PX: u32 = 64;
/// Stops from the value that automatic exposure gives a percentile, 0.9, down to one half.
const STOPS_BELOW: f64 = 0.847_996_906_554_950_1;

impl Renderer {
    /// As [`Renderer::images`], with the surroundings of each picture: those of all, or its own if
    /// clear objects show the subject.
    pub(crate) fn beside_others<T: Send>(
        &self,
        frame: &Frame,
        mesh: &LoadedMesh,
        programs: &[&Program],
        finish: impl Fn(&Program, &dyn EvaluatedPicture, &LitBackdrop) -> Result<T, RenderError> + Sync,
    ) -> Result<Vec<T>, RenderError> {
        let images = |programs: &[&Program], subject: Option<&Program>| {
            let backdrop = self.backdrop(frame, mesh, subject)?;
            self.images(frame, mesh, programs, |program, picture| {
                finish(program, picture, &backdrop)
            })
        };
        let shows_subject = self.has_clear_objects(frame)?;
        let is_alone = |program: &Program| shows_subject || program.glass().is_some();
        let (alone, shared): (Vec<usize>, Vec<usize>) =
            (0..programs.len()).partition(|at| is_alone(programs[*at]));
        let mut done: Vec<Option<T>> = programs.iter().map(|_| None).collect();
        let own: Vec<&Program> = shared.iter().map(|at| programs[*at]).collect();
        if !own.is_empty() {
            let made = images(&own, None)?;
            shared.into_iter().zip(made).for_each(|(at, image)| done[at] = Some(image));
        }
        for at in alone {
            done[at] = images(&[programs[at]], Some(programs[at]))?.pop();
        }
        Ok(done.into_iter().flatten().collect())
    }

    /// Returns the backdrop of the requested part of a picture, and the other objects of its scene.
    /// If some of these are clear, `subject` is the material of the subject, which they show.
    fn backdrop(
        &self,
        frame: &Frame,
        mesh: &LoadedMesh,
        subject: Option<&Program>,
    ) -> Result<LitBackdrop, RenderError> {
        let (scene, assets) = (frame.scene()?, self.loaded_assets());
        scene.validate()?;
        let whole = PixelArea::whole(frame.size_px);
        let area = frame.area.unwrap_or(whole);
        if !area.is_within(frame.size_px) {
            return Err(RenderError::Area { area, size_px: frame.size_px });
        }
        let others = self.objects(frame, &scene)?;
        let view = SceneView::among(&scene, mesh, &others, &assets);
        let view = view.with_clear(&self.clear_shares(frame)?);
        let shot = Shot { view, frame, film: scene.film, area, subject };
        let surroundings = self.surroundings(&shot)?;
        let backdrop = SceneView::new(&scene, mesh, &assets).backdrop(frame.size_px, area);
        Ok(backdrop.with_surroundings(surroundings))
    }

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
        let key = self.caches.metered_key(&view, size_px, (&program, frame.backend));
        let ev = match self.caches.metered(key) {
            Some(ev) => ev,
            None => {
                let shot = Shot { view, frame: &metered, film: *film, area, subject: None };
                let image =
                    self.shaded(&shot, &[&*program], |_: &Program, picture| picture.radiance())?;
                let image = image.first().expect("one picture of one program");
                let ev = Gain::of_lit(image).map(|gain| gain.ev - STOPS_BELOW);
                self.caches.keep_metered(key, ev);
                ev
            }
        };
        Ok(ev.map_or(*film, |ev| Film { exposure: Exposure::Ev(ev), ..*film }))
    }

    /// Returns the share of light that passes through each part of a scene, with an opaque
    /// subject.
    pub(crate) fn clear_shares(&self, frame: &Frame) -> Result<Vec<f64>, RenderError> {
        let object = |object: &ObjectSource| Ok(self.program(&object.words)?.clearness());
        std::iter::once(Ok(0.0)).chain(frame.objects.iter().map(object)).collect()
    }

    /// True if the material of an object beside the subject is clear.
    pub(crate) fn has_clear_objects(&self, frame: &Frame) -> Result<bool, RenderError> {
        for object in &frame.objects {
            if self.program(&object.words)?.glass().is_some() {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Returns the pictures of the objects beside the subject; `None` if there are none.
    pub(crate) fn surroundings(
        &self,
        shot: &Shot<'_>,
    ) -> Result<Option<Arc<Surroundings>>, RenderError> {
        let Shot { view, frame, area, subject, .. } = shot;
        if view.parts() == 1 {
            return Ok(None);
        }
        // Of the whole picture, so that its parts are cut from one.
        let whole = PixelArea::whole(frame.size_px);
        let mut linear = (*frame).clone().with_area(None);
        linear.format = PictureFormat::Exr;
        // Automatic exposure is that beside an opaque subject, for all materials of a brood.
        let lit = match subject {
            Some(subject) => view.with_subject(subject),
            None => view.clone(),
        };
        let make = || {
            let film = self.ground_exposure(shot)?;
            let ev = match film.exposure {
                Exposure::Ev(ev) => Some(ev),
                Exposure::Auto => None,
            };
            let mut around = Surroundings { ev, ..Surroundings::default() };
            for (part, object) in (1..).zip(&frame.objects) {
                let program = self.program(&object.words)?;
                let view = lit.with_part(part);
                let own = Shot { view, frame: &linear, film, area: whole, subject: *subject };
                let mut image =
                    self.shaded(&own, &[&*program], |_: &Program, picture| picture.radiance())?;
                let image = image.pop().expect("one picture of one program");
                around.add(image, program.is_painted());
            }
            Ok(around)
        };
        let raster = Raster { size_px: frame.size_px, sampling: frame.sampling, area: whole };
        let shows_subject = self.has_clear_objects(frame)?;
        let mut hasher = blake3::Hasher::new();
        for object in &frame.objects {
            let words = object.words.iter().flat_map(|word| word.to_le_bytes());
            hasher.update(&words.collect::<Vec<u8>>()).update(b"material");
        }
        hasher.update(&[u8::from(frame.backend == Backend::Reference)]);
        hasher.update(format!("{:?}", shot.film.exposure).as_bytes());
        if shows_subject {
            hasher.update(&shot.view.seen_behind());
        }
        if let Some(subject) = subject.filter(|_| shows_subject) {
            hasher.update(subject.hash().as_bytes());
        }
        let made = self.caches.surroundings((&lit, raster), &hasher.finalize(), make)?;
        Ok(Some(if *area == whole { made } else { Arc::new(made.crop(*area)) }))
    }
}

#[cfg(test)]
mod tests {
    use brood_eval::decode_png;
    use brood_genome::preset::{Preset, neutral};

    use super::*;

    const SIDE: u32 = 48;

    fn program(preset: &str) -> Program {
        Program::lower(Preset::find(preset).expect("the preset exists").genome())
    }

    fn scene(json: &str) -> Scene {
        serde_json::from_str(json).unwrap()
    }

    fn frame(scene: &Scene, materials: &[&Program]) -> Frame {
        let options = (PictureFormat::Png, Backend::Cpu);
        let object = |program: &&Program| ObjectSource {
            mesh: MeshSource::Builtin,
            words: program.to_words(),
        };
        Frame::new(scene, MeshSource::Builtin, SIDE, Sampling::Adaptive, options)
            .with_objects(materials.iter().map(object).collect())
    }

    const GROUND: &str = r#"{"mesh": "knob", "shadows": true, "ground": {},
        "objects": [{"mesh": "cube", "position": [1, 0, 0.6], "scale": 0.3, "stands": true}],
        "lights": [{"kind": "environment", "image": "studio", "shadows": false}, {}]}"#;

    #[test]
    fn ground_looks_the_same_beside_every_material() {
        let renderer = Renderer::new(Backend::Cpu);
        let mesh = renderer.builtin(BuiltinMesh::Knob);
        let grey = Program::lower(neutral());
        let toon = program("paint-toon");
        let scene = scene(GROUND);
        let frame = frame(&scene, &[&toon, &grey]);
        let programs = ["moon-dust", "model-porcelain", "gold"].map(program);
        let batch: Vec<&Program> = programs.iter().collect();
        let pictures = renderer.render(&frame, &mesh, &batch).unwrap();
        let codes =
            |picture: &brood_protocol::RenderedPicture| decode_png(&picture.bytes).unwrap().2;
        let first = codes(&pictures[0]);
        let corner = (4 * SIDE * (SIDE - 1)) as usize;
        assert_eq!(first[corner + 3], 255);
        for picture in &pictures[1..] {
            assert_eq!(picture.exposure_ev.to_bits(), pictures[0].exposure_ev.to_bits());
            let other = codes(picture);
            assert_eq!(other[corner..corner + 4], first[corner..corner + 4]);
            assert_ne!(other, first);
        }
        // A part of a picture is cut from the whole.
        let area = PixelArea { x: 7, y: 20, width: 30, height: 17 };
        let part = frame.clone().with_area(Some(area));
        let part = codes(&renderer.render(&part, &mesh, &batch[..1]).unwrap()[0]);
        let rows = (area.y..area.y + area.height).flat_map(|y| {
            let start = 4 * (y * SIDE + area.x) as usize;
            first[start..start + 4 * area.width as usize].to_vec()
        });
        assert!(rows.eq(part));
    }

    #[test]
    fn exposure_does_not_depend_on_earlier_evaluators_nor_on_a_black_ground() {
        let mesh = Renderer::new(Backend::Cpu).builtin(BuiltinMesh::Knob);
        let grey = Program::lower(neutral());
        let scene = scene(GROUND);
        let orders = [[Backend::Cpu, Backend::Reference], [Backend::Reference, Backend::Cpu]];
        let [first, mut second] = orders.map(|order| {
            let renderer = Renderer::new(Backend::Cpu);
            order.map(|backend| {
                let mut frame = frame(&scene, &[&grey, &grey]);
                frame.backend = backend;
                renderer.render(&frame, &mesh, &[&grey]).unwrap()[0].exposure_ev.to_bits()
            })
        });
        second.reverse();
        assert_eq!(first, second);

        let black: brood_genome::Genome =
            "brood 1\n.model lambert\nalbedo 0 0 0\n".parse().unwrap();
        let renderer = Renderer::new(Backend::Cpu);
        let black = Program::lower(&black);
        let gold = program("gold");
        let dark = renderer.render(&frame(&scene, &[&grey, &black]), &mesh, &[&gold]).unwrap();
        let alone = Scene { ground: None, objects: Vec::new(), ..scene };
        let alone = renderer.render(&frame(&alone, &[]), &mesh, &[&gold]).unwrap();
        assert!((dark[0].exposure_ev - alone[0].exposure_ev).abs() < 0.5, "the subject decides");
    }

    #[test]
    fn clear_objects_show_the_backdrop_of_their_own_picture() {
        let clear = program("paint-glass");
        let toon = program("paint-toon");
        let of = |renderer: &Renderer, backdrop: &str| {
            let scene = scene(&format!(
                r#"{{"mesh": "sphere", "lights": [{{}}], "ground": {{}}, "film": {{"exposure": 0}},
                    "backdrop": {{"kind": "color", "color": {backdrop}}}}}"#
            ));
            let mesh = renderer.builtin(BuiltinMesh::Sphere);
            renderer.render(&frame(&scene, &[&clear]), &mesh, &[&toon]).unwrap().remove(0).bytes
        };
        let used = Renderer::new(Backend::Cpu);
        let [white, black] = ["[1, 1, 1]", "[0, 0, 0]"].map(|backdrop| of(&used, backdrop));
        assert_ne!(white, black);
        assert_eq!(black, of(&Renderer::new(Backend::Cpu), "[0, 0, 0]"));
    }

    #[test]
    fn frames_without_the_objects_of_their_scene_are_refused() {
        let renderer = Renderer::new(Backend::Cpu);
        let mesh = renderer.builtin(BuiltinMesh::Knob);
        let grey = Program::lower(neutral());
        let error = renderer.render(&frame(&scene(GROUND), &[&grey]), &mesh, &[&grey]);
        let words = "the scene has 2 objects beside the subject, the frame 1";
        assert_eq!(error.unwrap_err().to_string(), words);
        let mut unknown = frame(&scene(GROUND), &[&grey, &grey]);
        unknown.objects[0].mesh = MeshSource::Uploaded([7; 32]);
        let error = renderer.render(&unknown, &mesh, &[&grey]).unwrap_err();
        assert!(matches!(error, RenderError::MeshContent), "{error}");
    }
}
