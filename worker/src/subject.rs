//! Pictures of subjects other than plain programs: targets, programs that match a target, and
//! differences.

use std::sync::Arc;

use brood_brdf::{Brdf, Model, ModelKind};
use brood_eval::{Developed, Gain};
use brood_inspect::{LinearImage, Shade, Shot};
use brood_light::LightAssets;
use brood_mesh::Mesh;
use brood_program::Program;
use brood_protocol::{
    Aspect, Frame, MeshSource, PictureFormat, PictureKey, RenderedPicture, Subject, TargetSource,
};
use brood_scene::{
    Exposure, LitAngles, PictureSize, PixelArea, Raster, RayEnds, SampleSet, Scene, Stage,
};
use brood_target::{KnownView, PixelStatus};

use crate::encoded_picture::EncodedPicture;
use crate::error::RenderError;
use crate::renderer::Renderer;
use crate::scene_view::{LoadedMesh, SceneView};
use crate::target_cache::LoadedTarget;
use crate::view_comparison::taken;

/// Subject with its programs unpacked, and its target if it has one.
pub(crate) struct LoadedSubject {
    /// Key of the picture. Not computed again: the server may have stored the hash of the program
    /// before the meaning of an operation changed.
    pub(crate) key: PictureKey,
    pub(crate) subject: Subject<Arc<Program>>,
    pub(crate) target: Option<Arc<LoadedTarget>>,
}

impl Renderer {
    /// Renders and encodes the pictures of all subjects, in their order. Programs share a batch.
    pub(crate) fn render_subjects(
        &self,
        frame: &Frame,
        mesh: &LoadedMesh,
        subjects: &[LoadedSubject],
    ) -> Result<Vec<RenderedPicture>, RenderError> {
        let plain = |one: &LoadedSubject| match &one.subject {
            Subject::Program(program) => Some(program.clone()),
            Subject::Difference(_)
            | Subject::Target(..)
            | Subject::Matched(..)
            | Subject::Scene
            | Subject::ClearScene
            | Subject::RayEnds(_) => None,
        };
        let programs: Vec<Arc<Program>> = subjects.iter().filter_map(plain).collect();
        let programs: Vec<&Program> = programs.iter().map(AsRef::as_ref).collect();
        let mut rendered = match programs.is_empty() {
            true => Vec::new(),
            false => self.encoded(frame, mesh, &programs)?,
        }
        .into_iter();
        let picture = |one: &LoadedSubject| {
            let picture = match (&one.subject, &one.target) {
                (Subject::Program(_), _) => rendered.next().expect("one picture per program"),
                (Subject::Difference(programs), _) => self.difference(frame, mesh, programs)?,
                (Subject::Target(source, aspect), Some(target)) => {
                    self.target(frame, mesh, (source, target), *aspect)?
                }
                (Subject::Matched(program, source), Some(target)) => {
                    let ev = self.target_ev(frame, mesh, (source, target), program)?;
                    let frame = frame.clone().exposed(ev)?;
                    let mut pictures = self.encoded(&frame, mesh, &[program])?;
                    pictures.pop().expect("one picture per program")
                }
                (Subject::Scene, _) => {
                    self.geometry(frame, mesh, PictureFormat::Angles, |(scene, stage), side| {
                        EncodedPicture::angles(&LitAngles::trace(scene, stage, side))
                    })?
                }
                (Subject::ClearScene, _) => {
                    self.geometry(frame, mesh, PictureFormat::Angles, |(scene, stage), side| {
                        let stage = with_clear_subject(&stage);
                        EncodedPicture::angles(&LitAngles::trace(scene, stage, side))
                    })?
                }
                (Subject::RayEnds(hundredths), _) => {
                    let index = f64::from(*hundredths) / 100.0;
                    self.geometry(frame, mesh, PictureFormat::RayEnds, |(scene, stage), side| {
                        let stage = with_clear_subject(&stage);
                        EncodedPicture::ray_ends(&RayEnds::trace((scene, index), stage, side))
                    })?
                }
                (Subject::Target(..) | Subject::Matched(..), None) => {
                    return Err(RenderError::NoTarget);
                }
            };
            Ok(picture.with_key(one.key))
        };
        subjects.iter().map(picture).collect()
    }

    /// Makes a file of a scene without materials: `make` takes the scene, its stage and the side of
    /// the picture in pixels.
    fn geometry(
        &self,
        frame: &Frame,
        mesh: &LoadedMesh,
        format: PictureFormat,
        make: impl FnOnce((&Scene, Stage<'_>), u32) -> EncodedPicture,
    ) -> Result<EncodedPicture, RenderError> {
        let scene = frame.scene()?;
        scene.validate()?;
        let PictureSize { width, height } = frame.size_px;
        if frame.format != format || width != height {
            let words = format!("{} need a square of their format", format.name());
            return Err(RenderError::Missing(words));
        }
        let others = self.objects(frame, &scene)?;
        let meshes: Vec<&Mesh> = others.iter().map(|other| other.mesh()).collect();
        let stage = Stage::new(&scene, mesh.mesh(), &meshes);
        Ok(make((&scene, stage), width))
    }

    /// Renders the absolute difference of two programs. The frame must have a fixed exposure.
    fn difference(
        &self,
        frame: &Frame,
        mesh: &LoadedMesh,
        programs: &[Arc<Program>; 2],
    ) -> Result<EncodedPicture, RenderError> {
        let Exposure::Ev(exposure_ev) = frame.scene()?.film.exposure else {
            return Err(RenderError::AutoDifference);
        };
        let both = programs.each_ref().map(AsRef::as_ref);
        let linear = self.images(frame, mesh, &both, |_, picture| {
            Ok(LinearImage::of_radiance(&picture.radiance()?).exposed(exposure_ev))
        })?;
        let [first, second] = &linear[..] else { unreachable!("one picture per program") };
        let difference = first.absolute_difference(second);
        let ((width, height), rgba) = (difference.size(), difference.encoded_rgba());
        Ok(EncodedPicture::png(&Developed { width, height, rgba, exposure_ev }))
    }

    /// Renders an aspect of a target.
    fn target(
        &self,
        frame: &Frame,
        mesh: &LoadedMesh,
        (source, target): (&TargetSource, &LoadedTarget),
        aspect: Aspect,
    ) -> Result<EncodedPicture, RenderError> {
        if let (LoadedTarget::Measured(brdf), Aspect::Picture) = (target, aspect) {
            return self.measured(frame, mesh, &**brdf);
        }
        let known = self.targets.view(source, target)?;
        if aspect == Aspect::Mask && !known.is_masked {
            let n = source.view.unwrap_or_default();
            return Err(RenderError::Missing(format!("picture {n} of the target has no mask")));
        }
        if aspect == Aspect::Corrected {
            let grey = grey();
            return self.measured(frame, mesh, &*grey);
        }
        draw_view(&known, aspect)
    }

    /// Renders a measured material.
    fn measured(
        &self,
        frame: &Frame,
        mesh: &LoadedMesh,
        brdf: &dyn Brdf,
    ) -> Result<EncodedPicture, RenderError> {
        let set = self.whole_set(frame, mesh)?;
        let (scene, assets) = (frame.scene()?, self.light_assets());
        let (size_px, sampling) = (frame.size_px, frame.sampling);
        let shot = Shot { mesh: mesh.mesh(), scene: &scene, assets: &assets, size_px, sampling };
        EncodedPicture::of_material(frame.format, &shot.take_on(&set, brdf))
    }

    /// Returns the mesh in the scene of a target's picture, and the files of the scene's lights.
    ///
    /// # Errors
    /// [`RenderError::Missing`] if the target has no such picture.
    pub(crate) fn scenery(
        &self,
        source: &TargetSource,
        target: &LoadedTarget,
    ) -> Result<(Arc<LoadedMesh>, LightAssets), RenderError> {
        let (picture, assets) = target.picture(source.view)?;
        let mesh = match (&picture.mesh, picture.scene.builtin()) {
            (Some(mesh), _) => self.cached_mesh(LoadedMesh::new(mesh.clone())),
            (None, Some(name)) => self.builtin(name),
            (None, None) => unreachable!("a bundle's meshes have been checked"),
        };
        Ok((mesh, assets.clone()))
    }

    /// Returns the exposure at which a program is as bright as a target, in EV.
    fn target_ev(
        &self,
        frame: &Frame,
        mesh: &LoadedMesh,
        (source, target): (&TargetSource, &LoadedTarget),
        program: &Program,
    ) -> Result<f64, RenderError> {
        if let LoadedTarget::Measured(brdf) = target {
            let set = self.whole_set(frame, mesh)?;
            let mut f = Vec::new();
            brdf.shade(&set, &mut f);
            return Ok(Gain::new(frame.scene()?.film, &set, &f).ev);
        }
        let known = self.targets.view(source, target)?;
        let ev = known.gain.ev;
        if !known.view.is_gain_unknown() {
            return Ok(ev);
        }
        // The gain that minimises the difference between the two.
        let output = (PictureFormat::Exr, frame.backend);
        let (setting, size_px) = (&known.setting, known.size_px());
        let own = Frame::new(&setting.scene, MeshSource::Target, size_px, setting.sampling, output);
        let radiance =
            self.images(&own.exposed(ev)?, mesh, &[program], |_, picture| picture.radiance())?;
        let gain = known.view.compare(&radiance[0]).gain;
        Ok(if gain > 0.0 { ev + libm::log2(gain) } else { ev })
    }

    /// Returns the sample set of a whole picture.
    fn whole_set(&self, frame: &Frame, mesh: &LoadedMesh) -> Result<Arc<SampleSet>, RenderError> {
        let (scene, assets) = (frame.scene()?, self.loaded_assets());
        scene.validate()?;
        let (size_px, sampling) = (frame.size_px, frame.sampling);
        let raster = Raster { size_px, sampling, area: PixelArea::whole(size_px) };
        Ok(self.caches.sample_set(&SceneView::new(&scene, mesh, &assets), raster))
    }
}

/// Draws an aspect of the picture of an image target.
fn draw_view(known: &KnownView, aspect: Aspect) -> Result<EncodedPicture, RenderError> {
    let statuses = |color: fn(PixelStatus) -> [u8; 3]| {
        let opaque = |status: &PixelStatus| {
            let [r, g, b] = color(*status);
            [r, g, b, u8::MAX]
        };
        let rgba: Vec<u8> = known.view.statuses().iter().flat_map(opaque).collect();
        let PictureSize { width, height } = known.size_px();
        EncodedPicture::png(&Developed { width, height, rgba, exposure_ev: 0.0 })
    };
    Ok(match aspect {
        Aspect::Picture => EncodedPicture::png(&known.shown()),
        Aspect::Scene => {
            let picture = taken(known, &*grey());
            EncodedPicture::of_material(PictureFormat::Png, &picture)?
        }
        Aspect::Corrected => unreachable!("drawn in the scene of the frame"),
        Aspect::Pixels => statuses(color),
        Aspect::Mask => {
            statuses(|status| [if status == PixelStatus::Masked { 0 } else { u8::MAX }; 3])
        }
    })
}

/// Diffuse material of albedo 0.5.
fn grey() -> Box<dyn Brdf> {
    let grey = Model::new(ModelKind::Lambert).with("albedo", &[0.5; 3]);
    grey.expect("a diffuse material has an albedo").brdf()
}

/// Returns the stage with a subject through which some light passes.
fn with_clear_subject<'a>(stage: &Stage<'a>) -> Stage<'a> {
    let mut shares = vec![0.0; stage.count()];
    shares[0] = 0.5;
    stage.with_clear(&shares)
}

/// Returns the colour of a status; the API documentation lists these colours.
fn color(status: PixelStatus) -> [u8; 3] {
    match status {
        PixelStatus::Used => [0x4c, 0xaf, 0x50],
        PixelStatus::Masked => [0x00, 0x00, 0x00],
        PixelStatus::Background => [0x30, 0x36, 0x3d],
        PixelStatus::Edge => [0xff, 0xb3, 0x00],
        PixelStatus::Clipped => [0xe5, 0x39, 0x35],
        PixelStatus::Grazing => [0x8e, 0x24, 0xaa],
        PixelStatus::Outlier => [0xf0, 0x62, 0x92],
        PixelStatus::HalfLit => [0x1e, 0x88, 0xe5],
        PixelStatus::SeveralLights => [0x00, 0xac, 0xc1],
        PixelStatus::Unlit => [0x6d, 0x4c, 0x41],
    }
}

#[cfg(test)]
mod tests {

    use brood_genome::{BirthKey, Dialect, Variation};
    use brood_inspect::Specimen;
    use brood_mesh::BuiltinMesh;
    use brood_protocol::Backend;
    use brood_scene::{ClipFrom, Refine, Sampling, Scene};
    use brood_target::{BundledView, PictureBundle};

    use super::*;

    const KEY: PictureKey = PictureKey([7; 32]);

    fn subject(subject: Subject<Arc<Program>>) -> LoadedSubject {
        LoadedSubject { key: KEY, subject, target: None }
    }

    fn frame(scene: &Scene, format: PictureFormat) -> Frame {
        Frame::new(scene, MeshSource::Builtin, 40, Sampling::Adaptive, (format, Backend::Cpu))
    }

    fn programs() -> [Arc<Program>; 2] {
        let random = Variation::random(Dialect::default());
        let birth = |slot| random.birth(BirthKey { seed: 3, slot, attempt: 0 });
        [0, 1].map(|slot| Arc::new(Program::lower(&birth(slot))))
    }

    #[test]
    fn program_has_the_same_bits_as_a_material_that_is_not_a_program() {
        let renderer = Renderer::new(Backend::Cpu);
        let mesh = renderer.builtin(BuiltinMesh::Knob);
        let random = Variation::random(Dialect::default());
        let (scene, assets) = (Scene::default(), LightAssets::default());
        for slot in 0..4 {
            let genome = random.birth(BirthKey { seed: 5, slot, attempt: 0 });
            let program = Arc::new(Program::lower(&genome));
            for format in [PictureFormat::Png, PictureFormat::Exr] {
                let frame = frame(&scene, format);
                let one = [subject(Subject::Program(program.clone()))];
                let rendered = renderer.render_subjects(&frame, &mesh, &one).unwrap();
                let shot = Shot {
                    mesh: mesh.mesh(),
                    scene: &scene,
                    assets: &assets,
                    size_px: frame.size_px,
                    sampling: frame.sampling,
                };
                let taken = shot.take(&Specimen::Bred(&genome, &program));
                let taken = EncodedPicture::of_material(format, &taken).unwrap();
                assert_eq!(rendered[0].bytes, taken.bytes, "{slot} {format:?}");
            }
        }
    }

    #[test]
    fn difference_is_black_only_between_equal_programs() {
        let renderer = Renderer::new(Backend::Cpu);
        let mesh = renderer.builtin(BuiltinMesh::Knob);
        let [first, second] = programs();
        let pairs = [[first.clone(), first.clone()], [first.clone(), second]];
        let mut subjects: Vec<_> =
            pairs.map(|pair| subject(Subject::Difference(pair))).into_iter().collect();
        subjects.push(subject(Subject::Program(first.clone())));
        let frame = frame(&Scene::default(), PictureFormat::Png).exposed(0.0).unwrap();
        let pictures = renderer.render_subjects(&frame, &mesh, &subjects).unwrap();
        let is_black = |bytes: &[u8]| {
            let (_, _, rgba) = brood_eval::decode_png(bytes).unwrap();
            rgba.chunks_exact(4).all(|pixel| pixel == [0, 0, 0, 255])
        };
        assert_eq!([0, 1].map(|index: usize| is_black(&pictures[index].bytes)), [true, false]);
        assert!(pictures.iter().all(|picture| picture.key == KEY), "the keys of the server");
    }

    #[test]
    fn difference_needs_a_fixed_exposure_and_a_target_its_file() {
        let renderer = Renderer::new(Backend::Cpu);
        let mesh = renderer.builtin(BuiltinMesh::Sphere);
        let frame = frame(&Scene::default(), PictureFormat::Png);
        let source = TargetSource { kind: "merl".to_owned(), hash: [0; 32], view: None };
        let one = [subject(Subject::Difference(programs()))];
        let error = renderer.render_subjects(&frame, &mesh, &one).unwrap_err();
        assert!(matches!(error, RenderError::AutoDifference), "{error}");
        let one = [subject(Subject::Target(source, Aspect::Picture))];
        let error = renderer.render_subjects(&frame, &mesh, &one).unwrap_err();
        assert!(matches!(error, RenderError::NoTarget), "{error}");
    }

    /// First eight digits of the BLAKE3 hashes of the RGBA bytes below.
    const RECORDED: [&str; 6] =
        ["acdbe3ac", "80ba5f92", "fa7f2899", "f0e2c403", "193d7ae6", "b5d168d4"];

    #[test]
    fn pictures_of_targets_are_the_recorded_ones() {
        let renderer = Renderer::new(Backend::Cpu);
        let scene: Scene = serde_json::from_str(
            r#"{"mesh": "knob", "lights": [{"kind": "directional", "direction": [1, 2, 2]}],
                "film": {"exposure": -1}}"#,
        )
        .unwrap();
        let plastic = || Model::new(ModelKind::RoughPlastic).brdf();
        let exr = frame(&scene, PictureFormat::Exr);
        let knob = renderer.builtin(BuiltinMesh::Knob);
        let picture = renderer.measured(&exr, &knob, &*plastic()).unwrap().bytes;
        let half: Vec<u8> =
            (0..1600).flat_map(|pixel| [if pixel % 40 < 30 { 255 } else { 0 }; 4]).collect();
        let view = BundledView {
            scene: scene.clone(),
            mesh: None,
            sampling: Sampling::Adaptive,
            is_gain_unknown: true,
            clip_from: ClipFrom::LARGEST,
            crop: None,
            is_held_out: false,
            refine: Refine::default(),
            picture,
            mask: Some(brood_eval::encode_png(40, 40, &half)),
        };
        let bundle = PictureBundle { views: vec![view], ..PictureBundle::default() };
        let targets = [
            ("merl", None, LoadedTarget::Measured(plastic())),
            ("image", Some(0), LoadedTarget::Pictures(bundle, LightAssets::default())),
        ];
        let [(merl, measured), (image, pictures)] = targets.map(|(kind, view, target)| {
            let kind = kind.to_owned();
            (TargetSource { kind, hash: [view.is_some().into(); 32], view }, Arc::new(target))
        });
        let of = |subject, target: &Arc<LoadedTarget>| LoadedSubject {
            key: KEY,
            subject,
            target: Some(target.clone()),
        };
        let aspect = |aspect| of(Subject::Target(image.clone(), aspect), &pictures);
        let [program, _] = programs();
        let subjects = [
            of(Subject::Target(merl, Aspect::Picture), &measured),
            aspect(Aspect::Picture),
            aspect(Aspect::Scene),
            aspect(Aspect::Pixels),
            aspect(Aspect::Mask),
            of(Subject::Matched(program, image.clone()), &pictures),
        ];
        let png = frame(&scene, PictureFormat::Png);
        let rendered = renderer.render_subjects(&png, &knob, &subjects).unwrap();
        let hash = |picture: &RenderedPicture| {
            let (_, _, rgba) = brood_eval::decode_png(&picture.bytes).unwrap();
            blake3::hash(&rgba).to_hex()[..8].to_owned()
        };
        let hashes: Vec<String> = rendered.iter().map(hash).collect();
        assert_eq!(hashes, RECORDED, "if this is intended, increment `RENDERER_VERSION`");
    }
}
