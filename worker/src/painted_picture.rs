//! Pictures of painted materials: evaluated at points with all lights, and averaged in display
//! values. The film of the scene has no effect on them.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;

use brood_brdf::Input;
use brood_eval::{Developed, Gain, RadianceImage, develop_colors, linear_colors};
use brood_genome::ImageHash;
use brood_program::Program;
use brood_protocol::{Backend, RenderStats};
use brood_scene::SampleSet;
use rayon::prelude::*;

use crate::error::RenderError;
use crate::evaluated_picture::EvaluatedPicture;
use crate::render_counters::micros;
use crate::renderer::Renderer;
use crate::scene_view::Raster;
use crate::shot::{BATCH_FLOATS, Shot};

/// Evaluated picture of one painted material.
struct PaintedPicture<'a> {
    set: &'a SampleSet,
    colors: &'a [f32],
    /// Exposure of the BRDF that the material paints, in EV; 0 without one.
    exposure_ev: f64,
}

impl EvaluatedPicture for PaintedPicture<'_> {
    fn develop(&self) -> Result<Developed, RenderError> {
        Ok(Developed { exposure_ev: self.exposure_ev, ..develop_colors(self.set, self.colors) })
    }

    fn radiance(&self) -> Result<RadianceImage, RenderError> {
        Ok(linear_colors(self.set, self.colors))
    }

    fn gain(&self) -> Gain {
        Gain::fixed(self.exposure_ev)
    }

    fn samples(&self) -> u64 {
        self.set.len() as u64
    }
}

impl Renderer {
    /// Evaluates painted programs in batches, those with the same control images together, on the
    /// points of the requested part of the picture.
    /// `finish` receives them as lowered for the lights of the scene.
    pub(crate) fn painted_images<T: Send>(
        &self,
        shot: &Shot<'_>,
        programs: &[&Program],
        finish: impl Fn(&Program, &dyn EvaluatedPicture) -> Result<T, RenderError> + Sync,
    ) -> Result<Vec<T>, RenderError> {
        let mut done: Vec<Option<T>> = programs.iter().map(|_| None).collect();
        let (clear, plain): (Vec<usize>, Vec<usize>) =
            (0..programs.len()).partition(|at| programs[*at].glass().is_some());
        let mut by_images: BTreeMap<Vec<ImageHash>, Vec<usize>> = BTreeMap::new();
        for at in plain {
            by_images.entry(programs[at].images()).or_default().push(at);
        }
        for together in by_images.into_values() {
            self.caches.check()?;
            let own: Vec<&Program> = together.iter().map(|at| programs[*at]).collect();
            let set = self.points_for(shot, own[0])?;
            let images = self.images_on((&set, 0.0), shot.frame.backend, &own, &finish)?;
            together.into_iter().zip(images).for_each(|(at, image)| done[at] = Some(image));
        }
        for at in clear {
            self.caches.check()?;
            let (set, own) = (self.points_for(shot, programs[at])?, &programs[at..=at]);
            done[at] = self.images_on((&set, 0.0), shot.frame.backend, own, &finish)?.pop();
        }
        Ok(done.into_iter().flatten().collect())
    }

    /// Returns the points of the requested part of a picture of a style: those of all, or of a
    /// clear one its own, with what its rays see; with the colours of its control images.
    pub(crate) fn points_for(
        &self,
        shot: &Shot<'_>,
        style: &Program,
    ) -> Result<Arc<SampleSet>, RenderError> {
        let Shot { view, frame, area, .. } = shot;
        let (given, most) = (view.scene().lights.len(), Input::LIGHTS);
        if given > most {
            return Err(RenderError::Lights { given, most });
        }
        let raster = Raster { size_px: frame.size_px, sampling: frame.sampling, area: *area };
        let points = if style.glass().is_none() {
            self.caches.points(view, raster)
        } else {
            let shot = Shot { view: shot.view_for(style), ..*shot };
            let points = self.caches.clear_points(&shot.view, raster);
            Arc::new(self.with_glass(&shot, (&points, raster), style)?)
        };
        Ok(self.with_images(&points, style)?.map_or(points, Arc::new))
    }

    /// Evaluates styles in batches on points of a picture with this exposure, and finishes the
    /// pictures in parallel.
    pub(crate) fn images_on<T: Send>(
        &self,
        (set, exposure_ev): (&SampleSet, f64),
        backend: Backend,
        styles: &[&Program],
        finish: impl Fn(&Program, &dyn EvaluatedPicture) -> Result<T, RenderError> + Sync,
    ) -> Result<Vec<T>, RenderError> {
        let lighting = set.lighting().expect("the samples are points");
        let lowered: Vec<Program> = styles.iter().map(|style| style.painted(lighting)).collect();
        let (caches, floats) = (&self.caches, 3 * set.len());
        let together = (BATCH_FLOATS / floats.max(1)).max(1);
        let mut colors = Vec::new();
        let mut done = Vec::with_capacity(lowered.len());
        for programs in lowered.chunks(together) {
            let batch: Vec<&Program> = programs.iter().collect();
            caches.counters.timed(
                || self.evaluators.eval(backend, &batch, set, &mut colors),
                |evaluation_us| RenderStats { evaluation_us, ..RenderStats::default() },
            )?;
            let (counts, pictures) = (set.counts(), programs.len() as u64);
            let (rays, samples_covered) = (pictures * counts.rays, pictures * counts.covered);
            caches.counters.add(RenderStats { rays, samples_covered, ..RenderStats::default() });
            let started = Instant::now();
            let pictures: Result<Vec<T>, RenderError> = programs
                .par_iter()
                .enumerate()
                .map(|(index, program)| {
                    let colors = &colors[index * floats..(index + 1) * floats];
                    finish(program, &PaintedPicture { set, colors, exposure_ev })
                })
                .collect();
            done.extend(pictures?);
            caches.advance(3 * rays);
            let film_us = micros(started.elapsed());
            caches.counters.add(RenderStats { film_us, ..RenderStats::default() });
        }
        Ok(done)
    }
}

#[cfg(test)]
mod tests {
    use brood_eval::decode_png;
    use brood_genome::{Genome, preset::Preset};
    use brood_mesh::BuiltinMesh;
    use brood_protocol::{Frame, MeshSource, PictureFormat};
    use brood_scene::{Exposure, PixelArea, Sampling, Scene};

    use super::*;

    fn program(preset: &str) -> Program {
        Program::lower(Preset::find(preset).expect("the preset exists").genome())
    }

    fn frame(scene: &Scene, format: PictureFormat) -> Frame {
        Frame::new(scene, MeshSource::Builtin, 40, Sampling::Adaptive, (format, Backend::Cpu))
    }

    #[test]
    fn painted_pictures_share_a_batch_with_others() {
        let renderer = Renderer::new(Backend::Cpu);
        let mesh = renderer.builtin(BuiltinMesh::Knob);
        let programs = ["paint-cartoon", "gold", "paint-brush"].map(program);
        let batch: Vec<&Program> = programs.iter().collect();
        let frame = frame(&Scene::default(), PictureFormat::Png);
        let together = renderer.render(&frame, &mesh, &batch).unwrap();
        for (picture, program) in together.iter().zip(&programs) {
            let alone = renderer.render(&frame, &mesh, &[program]).unwrap();
            assert_eq!(alone[0], *picture);
            assert!(picture.samples > 0 && picture.operations > picture.samples);
        }
    }

    #[test]
    fn film_has_no_effect_and_parts_are_cut_from_the_whole() {
        let renderer = Renderer::new(Backend::Cpu);
        let mesh = renderer.builtin(BuiltinMesh::Knob);
        let (program, mut scene) = (program("paint-cartoon"), Scene::default());
        let render = |frame: &Frame| {
            let picture = renderer.render(frame, &mesh, &[&program]).unwrap().remove(0);
            assert_eq!(picture.exposure_ev.to_bits(), 0.0f64.to_bits());
            decode_png(&picture.bytes).unwrap()
        };
        let whole = render(&frame(&scene, PictureFormat::Png));
        scene.film.exposure = Exposure::Ev(-3.0);
        assert_eq!(render(&frame(&scene, PictureFormat::Png)), whole);
        let area = PixelArea { x: 5, y: 9, width: 20, height: 11 };
        let part = render(&frame(&scene, PictureFormat::Png).with_area(Some(area)));
        assert_eq!((part.0, part.1), (area.width, area.height));
        for y in 0..area.height {
            let row = |width: u32, x: u32, y: u32| {
                let start = 4 * (y * width + x) as usize;
                start..start + 4 * area.width as usize
            };
            let expected = &whole.2[row(whole.0, area.x, area.y + y)];
            assert_eq!(&part.2[row(area.width, 0, y)], expected, "row {y}");
        }
    }

    /// Flat colours fill pixels with the codes of the palette.
    #[test]
    fn colours_are_the_codes_of_the_palette() {
        let renderer = Renderer::new(Backend::Cpu);
        let mesh = renderer.builtin(BuiltinMesh::Sphere);
        let text = "brood 1\n.effect light\npalette #2b1e46 #f2a65a\nbasis step\n";
        let program = Program::lower(&text.parse::<Genome>().unwrap());
        let frame = frame(&Scene::default(), PictureFormat::Png);
        let picture = renderer.render(&frame, &mesh, &[&program]).unwrap().remove(0);
        let (_, _, rgba) = decode_png(&picture.bytes).unwrap();
        let pixels: Vec<[u8; 4]> = rgba.as_chunks().0.to_vec();
        let covered = pixels.iter().filter(|pixel| pixel[3] == 255).count();
        let colors = [[0x2b, 0x1e, 0x46, 255], [0xf2, 0xa6, 0x5a, 255]];
        let flat = colors.map(|color| pixels.iter().filter(|pixel| **pixel == color).count());
        assert!(flat[0] + flat[1] > covered * 9 / 10, "{flat:?} of {covered}");
        assert!(flat.iter().all(|count| *count > covered / 10), "{flat:?}");
    }

    #[test]
    fn scenes_with_too_many_lights_are_refused() {
        let renderer = Renderer::new(Backend::Cpu);
        let mesh = renderer.builtin(BuiltinMesh::Sphere);
        let mut scene = Scene::default();
        let frame = |lights: usize, scene: &mut Scene| {
            scene.lights = vec![brood_light::Light::default(); lights];
            frame(scene, PictureFormat::Png)
        };
        let program = program("paint-toon");
        assert!(renderer.render(&frame(8, &mut scene), &mesh, &[&program]).is_ok());
        let error = renderer.render(&frame(9, &mut scene), &mesh, &[&program]).unwrap_err();
        let words = "painted materials are rendered with at most 8 lights, got 9";
        assert_eq!(error.to_string(), words);
    }

    #[test]
    fn linear_pictures_decode_to_the_developed_ones() {
        let renderer = Renderer::new(Backend::Cpu);
        let mesh = renderer.builtin(BuiltinMesh::Torus);
        let program = program("paint-mist");
        let frame = frame(&Scene::default(), PictureFormat::Exr);
        let developed = renderer.develop(&frame, &mesh, &[&program]).unwrap().remove(0);
        let linear = renderer
            .images(&frame, &mesh, &[&program], |_, picture| picture.radiance())
            .unwrap()
            .remove(0);
        let film = brood_eval::develop(&linear, Exposure::Ev(0.0));
        let apart = film.rgba.iter().zip(&developed.rgba).map(|(a, b)| a.abs_diff(*b)).max();
        assert!(apart <= Some(1), "{apart:?}");
    }
}
