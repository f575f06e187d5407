//! Renderer: evaluates programs for a frame, shades, develops and encodes the pictures.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use brood_eval::{Developed, Gain};
use brood_light::LightAssets;
use brood_mesh::BuiltinMesh;
use brood_program::Program;
use brood_protocol::{Backend, BackendReport, Frame, RenderStats, RenderedPicture, WorkerReport};
use brood_scene::{Exposure, Film, PixelArea, SampleSet, Sampling};
use rayon::prelude::*;

use crate::bounded_cache::BoundedCache;
use crate::cache::{Caches, LoadedAssets, LoadedMesh, Raster, SceneView};
use crate::encoded_picture::EncodedPicture;
use crate::error::RenderError;
use crate::evaluated_picture::{EvaluatedPicture, FineTiles, Refiner};
use crate::evaluator::Evaluators;
use crate::render_counters::micros;
use crate::target_cache::TargetCache;

/// Number of f32 values evaluated at once. Larger requests are split: a brood of 256 at 2048 x 2048
/// would take 13 GB.
const BATCH_FLOATS: usize = 32 << 20;
const DEFAULT_CACHE_BYTES: u64 = 256 << 20;

/// Renders frames with one choice of evaluator, and caches meshes, sample sets and programs.
pub struct Renderer {
    pub(crate) evaluators: Evaluators,
    pub(crate) caches: Caches,
    pub(crate) targets: TargetCache,
    entries: BoundedCache,
    reflectances: Mutex<Vec<f32>>,
    assets: Mutex<Arc<LoadedAssets>>,
}

impl Renderer {
    /// Creates a renderer with a cache of 256 MiB. `gpu` opens the adapter
    /// immediately, which takes up to seconds.
    #[must_use]
    pub fn new(backend: Backend) -> Self {
        Self::with_cache(backend, DEFAULT_CACHE_BYTES)
    }

    /// Creates a renderer whose derived data take at most `cache_bytes`.
    #[must_use]
    pub fn with_cache(backend: Backend, cache_bytes: u64) -> Self {
        let entries = BoundedCache::new(cache_bytes);
        Self {
            evaluators: Evaluators::new(backend),
            caches: Caches::new(entries.clone()),
            targets: TargetCache::new(entries.clone()),
            entries,
            reflectances: Mutex::default(),
            assets: Mutex::new(Arc::new(LoadedAssets::new(LightAssets::default()))),
        }
    }

    /// Returns the cache, for light files.
    pub(crate) fn entries(&self) -> BoundedCache {
        self.entries.clone()
    }

    /// With `auto`: looks for a GPU and benchmarks it against the CPU, which takes up to seconds.
    /// Rendering may continue meanwhile.
    pub fn survey(&self) {
        self.evaluators.survey();
    }

    /// Returns the default evaluator with the reason for it.
    #[must_use]
    pub fn report(&self) -> BackendReport {
        self.evaluators.report()
    }

    /// Returns the report for the server.
    #[must_use]
    pub fn worker_report(&self) -> WorkerReport {
        WorkerReport { backend: self.report(), gpu: self.evaluators.has_gpu() }
    }

    /// Returns a built-in mesh, which is built once.
    #[must_use]
    pub fn builtin(&self, mesh: BuiltinMesh) -> Arc<LoadedMesh> {
        self.caches.builtin(mesh)
    }

    /// Returns an uploaded mesh if it is in the cache.
    #[must_use]
    pub fn uploaded(&self, hash: &[u8; 32]) -> Option<Arc<LoadedMesh>> {
        self.caches.find_uploaded(hash)
    }

    /// Adds an uploaded mesh to the cache.
    ///
    /// # Errors
    /// Returns [`RenderError::MeshContent`] if its content hash is not `hash`.
    pub fn cache_uploaded(
        &self,
        hash: &[u8; 32],
        mesh: LoadedMesh,
    ) -> Result<Arc<LoadedMesh>, RenderError> {
        if mesh.hash() != hash {
            return Err(RenderError::MeshContent);
        }
        Ok(self.cached_mesh(mesh))
    }

    /// Returns the cached mesh with the same content, or caches this one.
    pub(crate) fn cached_mesh(&self, mesh: LoadedMesh) -> Arc<LoadedMesh> {
        self.caches.uploaded(mesh)
    }

    /// Replaces the light assets, which scenes refer to by name. A light whose asset is missing
    /// emits nothing.
    pub fn set_light_assets(&self, assets: LightAssets) {
        if assets.is_same(self.loaded_assets().assets()) {
            // Hashing large environment maps again takes longer than most pictures.
            return;
        }
        *self.assets.lock().unwrap_or_else(PoisonError::into_inner) =
            Arc::new(LoadedAssets::new(assets));
    }

    /// Returns the current light assets; empty at first.
    #[must_use]
    pub fn light_assets(&self) -> LightAssets {
        self.loaded_assets().assets().clone()
    }

    pub(crate) fn loaded_assets(&self) -> Arc<LoadedAssets> {
        self.assets.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Returns the program with these packed words, from the cache if possible.
    ///
    /// # Errors
    /// Returns [`RenderError::Words`] if the words are not a valid program.
    pub fn program(&self, words: &[u32]) -> Result<Arc<Program>, RenderError> {
        Ok(self.caches.program(words, Program::from_words)?)
    }

    /// Returns the counters since the last call and resets them: rays and hits, sample sets and
    /// programs computed and reused, times.
    #[must_use = "taking the counters resets them"]
    pub fn take_stats(&self) -> RenderStats {
        self.caches.counters.take()
    }

    /// Renders and encodes the pictures of all programs, in their order.
    ///
    /// # Errors
    /// Returns a [`RenderError`] if the frame is invalid, the evaluation fails or a picture cannot
    /// be encoded.
    pub fn render(
        &self,
        frame: &Frame,
        mesh: &LoadedMesh,
        programs: &[&Program],
    ) -> Result<Vec<RenderedPicture>, RenderError> {
        let encoded = self.encoded(frame, mesh, programs)?.into_iter().zip(programs);
        Ok(encoded.map(|(picture, program)| picture.with_key(frame.key(program))).collect())
    }

    /// Renders and encodes the pictures of all programs, in their order.
    pub(crate) fn encoded(
        &self,
        frame: &Frame,
        mesh: &LoadedMesh,
        programs: &[&Program],
    ) -> Result<Vec<EncodedPicture>, RenderError> {
        self.images(frame, mesh, programs, |program, picture| {
            EncodedPicture::of(frame.format, program, picture)
        })
    }

    /// Renders and develops the pictures of all programs, in their order. Ignores the frame's
    /// format.
    ///
    /// # Errors
    /// Returns a [`RenderError`] if the frame is invalid or the evaluation fails.
    pub fn develop(
        &self,
        frame: &Frame,
        mesh: &LoadedMesh,
        programs: &[&Program],
    ) -> Result<Vec<Developed>, RenderError> {
        self.images(frame, mesh, programs, |_, picture| picture.develop())
    }

    /// Returns the reflectance of each program on each sample of a set that belongs to no picture.
    ///
    /// # Shapes
    /// Per program: red, green, blue; per channel: the samples in order.
    ///
    /// # Errors
    /// Returns [`RenderError::Eval`] if the evaluation fails.
    pub fn reflectance(
        &self,
        backend: Backend,
        programs: &[&Program],
        set: &SampleSet,
    ) -> Result<Vec<f32>, RenderError> {
        let mut out = Vec::new();
        self.evaluators.eval(backend, programs, set, &mut out)?;
        Ok(out)
    }

    /// Evaluates the programs in batches and finishes the pictures in parallel.
    pub(crate) fn images<T: Send>(
        &self,
        frame: &Frame,
        mesh: &LoadedMesh,
        programs: &[&Program],
        finish: impl Fn(&Program, &EvaluatedPicture<'_>) -> Result<T, RenderError> + Sync,
    ) -> Result<Vec<T>, RenderError> {
        let scene = frame.scene()?;
        scene.validate()?;
        let (size_px, sampling) = (frame.size_px, frame.sampling);
        let whole = PixelArea::whole(size_px);
        let area = frame.area.unwrap_or(whole);
        if !area.is_within(size_px) {
            return Err(RenderError::Area { area, size_px });
        }
        let assets = self.loaded_assets();
        let view = SceneView::new(&scene, mesh, &assets);
        // Adaptive sampling needs the neighbours of each pixel, to decide if it is rough.
        let traced_area =
            if sampling == Sampling::Adaptive { area.with_border(size_px) } else { area };
        let set = self.caches.sample_set(&view, Raster { size_px, sampling, area: traced_area });
        let gains = if area == whole {
            None
        } else {
            Some(self.gains(&view, scene.film, frame, programs)?)
        };
        let tiles = FineTiles::new(size_px);
        let floats = 3 * set.len();
        let batch = (BATCH_FLOATS / floats.max(1)).max(1);
        let mut out = std::mem::take(&mut *self.buffer());
        let mut done = Vec::with_capacity(programs.len());
        for (number, programs) in programs.chunks(batch).enumerate() {
            let counters = &self.caches.counters;
            counters.timed(
                || self.evaluators.eval(frame.backend, programs, &set, &mut out),
                |evaluation_us| RenderStats { evaluation_us, ..RenderStats::default() },
            )?;
            let counts = set.counts();
            let pictures = programs.len() as u64;
            let (rays, samples_covered) = (pictures * counts.rays, pictures * counts.covered);
            counters.add(RenderStats { rays, samples_covered, ..RenderStats::default() });
            let started = Instant::now();
            let results: Result<Vec<T>, RenderError> = programs
                .par_iter()
                .enumerate()
                .map(|(index, program)| {
                    let f = &out[index * floats..(index + 1) * floats];
                    let gain = match &gains {
                        Some(gains) => gains[number * batch + index],
                        None => Gain::new(scene.film, &set, f),
                    };
                    let (caches, evaluators) = (&self.caches, &self.evaluators);
                    let (view, tiles) = (&view, &tiles);
                    let refiner = Refiner { caches, evaluators, view, frame, program, tiles };
                    finish(program, &EvaluatedPicture { set: &set, f, gain, area, refiner })
                })
                .collect();
            done.extend(results?);
            counters
                .add(RenderStats { film_us: micros(started.elapsed()), ..RenderStats::default() });
        }
        *self.buffer() = out;
        Ok(done)
    }

    /// Returns the exposure of the whole picture of each program, for rendering a part of it.
    /// Automatic exposure uses the pixel centres, so one sample per pixel is enough.
    fn gains(
        &self,
        view: &SceneView<'_>,
        film: Film,
        frame: &Frame,
        programs: &[&Program],
    ) -> Result<Vec<Gain>, RenderError> {
        if let Exposure::Ev(ev) = film.exposure {
            return Ok(vec![Gain::fixed(ev).with_tone(film.tone); programs.len()]);
        }
        let (size_px, sampling) = (frame.size_px, Sampling::Fixed(1));
        let raster = Raster { size_px, sampling, area: PixelArea::whole(size_px) };
        let set = self.caches.sample_set(view, raster);
        let mut f = Vec::new();
        let mut gains = Vec::with_capacity(programs.len());
        for program in programs {
            self.evaluators.eval(frame.backend, &[*program], &set, &mut f)?;
            gains.push(Gain::new(film, &set, &f));
        }
        Ok(gains)
    }

    /// Output buffer of the last batch, reused to avoid page faults.
    fn buffer(&self) -> std::sync::MutexGuard<'_, Vec<f32>> {
        self.reflectances.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use brood_genome::{BirthKey, Dialect, Variation};
    use brood_protocol::{MeshSource, PictureFormat};
    use brood_scene::{PictureSize, Scene};

    use super::*;

    fn programs(count: u32) -> Vec<Program> {
        let random = Variation::random(Dialect::default());
        let birth = |slot| random.birth(BirthKey { seed: 3, slot, attempt: 0 });
        (0..count).map(|slot| Program::lower(&birth(slot))).collect()
    }

    fn frame(format: PictureFormat, backend: Backend) -> Frame {
        Frame::new(&Scene::default(), MeshSource::Builtin, 24, 2, (format, backend))
    }

    #[test]
    fn picture_does_not_depend_on_rest_of_batch() {
        let renderer = Renderer::new(Backend::Cpu);
        let mesh = renderer.builtin(BuiltinMesh::Knob);
        let frame = frame(PictureFormat::Png, Backend::Auto);
        let programs = programs(7);
        let all: Vec<&Program> = programs.iter().collect();
        let together = renderer.render(&frame, &mesh, &all).unwrap();
        for (picture, program) in together.iter().zip(&programs) {
            let alone = renderer.render(&frame, &mesh, &[program]).unwrap();
            assert_eq!(alone[0], *picture);
            assert_eq!(picture.key, frame.key(program));
            assert!(picture.samples > 0 && picture.operations >= picture.samples);
        }
    }

    #[test]
    fn area_equals_crop_of_whole_picture() {
        let renderer = Renderer::new(Backend::Cpu);
        let mesh = renderer.builtin(BuiltinMesh::Knob);
        let programs = programs(3);
        let programs: Vec<&Program> = programs.iter().collect();
        for exposure in [Exposure::Auto, Exposure::Ev(0.5)] {
            for sampling in [Sampling::Adaptive, Sampling::Fixed(1), Sampling::Fixed(5)] {
                let mut scene = Scene::default();
                scene.film.exposure = exposure;
                let how = (PictureFormat::Png, Backend::Cpu);
                let frame = Frame::new(&scene, MeshSource::Builtin, 40, sampling, how);
                let whole = renderer.develop(&frame, &mesh, &programs).unwrap();
                for area in ["0,0,40,40", "11,6,17,21", "0,19,40,1", "39,39,1,1", "20,0,1,40"] {
                    let area: PixelArea = area.parse().unwrap();
                    let frame = frame.clone().with_area(Some(area));
                    let parts = renderer.develop(&frame, &mesh, &programs).unwrap();
                    for (part, whole) in parts.iter().zip(&whole) {
                        assert_eq!((part.width, part.height), (area.width, area.height));
                        assert_eq!(part.exposure_ev, whole.exposure_ev, "{area} {sampling}");
                        let row = 4 * area.width as usize;
                        for (y, own) in part.rgba.chunks(row).enumerate() {
                            let start = 4 * ((area.y as usize + y) * 40 + area.x as usize);
                            assert_eq!(own, &whole.rgba[start..start + row], "{area} {sampling}");
                        }
                    }
                }
            }
        }
        let beyond = "30,0,11,1".parse().ok();
        let frame = frame(PictureFormat::Png, Backend::Cpu).with_area(beyond);
        let refused = renderer.render(&frame, &mesh, &programs);
        assert!(matches!(refused, Err(RenderError::Area { .. })), "{refused:?}");
    }

    #[test]
    fn area_of_a_wide_or_tall_picture_equals_its_crop() {
        // Stripes, so that pixels in all tiles are rough.
        let text = "brood 1\n.dialect paper smooth registers 7\n.const C0 200 1 1 1\nMUL R0, R5.w, C0.x\nSIN R0, R0.x\n";
        let genome: brood_genome::Genome = text.parse().unwrap();
        let program = Program::lower(&genome);
        let renderer = Renderer::new(Backend::Cpu);
        let mesh = renderer.builtin(BuiltinMesh::Sphere);
        let camera = serde_json::from_str(r#"{"camera": {"distance": 2.5}}"#);
        for scene in [Scene::default(), camera.unwrap()] {
            for (size, area) in [("75x40", "20,5,40,30"), ("40x75", "5,20,30,40")] {
                let size: PictureSize = size.parse().unwrap();
                let area: PixelArea = area.parse().unwrap();
                let how = (PictureFormat::Png, Backend::Cpu);
                let frame = Frame::new(&scene, MeshSource::Builtin, size, Sampling::Adaptive, how);
                let develop = |renderer: &Renderer, frame: &Frame| {
                    renderer.develop(frame, &mesh, &[&program]).unwrap().remove(0)
                };
                let radiance = |renderer: &Renderer, frame: &Frame| {
                    let linear =
                        renderer.images(frame, &mesh, &[&program], |_, image| image.radiance());
                    linear.unwrap().remove(0)
                };
                let (whole, linear) = (develop(&renderer, &frame), radiance(&renderer, &frame));
                assert_eq!((whole.width, whole.height), (size.width, size.height));
                let part = frame.with_area(Some(area));
                let fresh = Renderer::new(Backend::Cpu);
                assert_eq!(develop(&fresh, &part), whole.crop(area), "{size}");
                let found = radiance(&Renderer::new(Backend::Cpu), &part);
                let expected = linear.crop(area);
                assert_eq!(found.premultiplied(), expected.premultiplied(), "{size}");
            }
        }
    }

    #[test]
    fn adaptive_sampling_reduces_error_and_does_not_depend_on_caches() {
        // Stripes about two pixels wide in the middle of the sphere, finer towards its edges.
        let text = "brood 1\n.dialect paper smooth registers 7\n.const C0 200 1 1 1\nMUL R0, R5.w, C0.x\nSIN R0, R0.x\n";
        let genome: brood_genome::Genome = text.parse().unwrap();
        let program = Program::lower(&genome);
        let mut scene = Scene::default();
        scene.film.exposure = Exposure::Ev(-1.0);
        let develop = |renderer: &Renderer, sampling: Sampling, area: Option<PixelArea>| {
            let how = (PictureFormat::Png, Backend::Cpu);
            let frame = Frame::new(&scene, MeshSource::Builtin, 72, sampling, how).with_area(area);
            let mesh = renderer.builtin(BuiltinMesh::Sphere);
            renderer.develop(&frame, &mesh, &[&program]).unwrap().remove(0)
        };
        let renderer = Renderer::new(Backend::Cpu);
        let many = develop(&renderer, Sampling::Fixed(256), None);
        let error = |picture: &Developed| -> f64 {
            let pairs = picture.rgba.iter().zip(&many.rgba);
            pairs.map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2)).sum()
        };
        let one = develop(&renderer, Sampling::Fixed(1), None);
        let adaptive = develop(&renderer, Sampling::Adaptive, None);
        assert!(error(&adaptive) < 0.6 * error(&one), "{} {}", error(&adaptive), error(&one));
        let fresh = Renderer::new(Backend::Cpu);
        let area: PixelArea = "30,30,20,9".parse().unwrap();
        assert_eq!(develop(&fresh, Sampling::Adaptive, Some(area)), adaptive.crop(area));
        for threads in [1, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let again = pool.install(|| develop(&fresh, Sampling::Adaptive, None));
            assert_eq!(again, adaptive, "{threads}");
        }
    }

    #[test]
    fn pictures_of_gpu_and_cpu_are_byte_identical() {
        let gpu = Renderer::new(Backend::Gpu);
        let required = std::env::var("BROOD_REQUIRE_GPU").is_ok_and(|value| value == "1");
        assert!(gpu.worker_report().gpu || !required, "{:?}", gpu.report());
        let frame = frame(PictureFormat::Png, Backend::Auto);
        let programs = programs(5);
        let programs: Vec<&Program> = programs.iter().collect();
        let render = |renderer: &Renderer| {
            let mesh = renderer.builtin(BuiltinMesh::Sphere);
            renderer.render(&frame, &mesh, &programs).unwrap()
        };
        assert_eq!(render(&gpu), render(&Renderer::new(Backend::Cpu)));
    }

    #[test]
    fn pictures_decode_to_requested_size() {
        let renderer = Renderer::new(Backend::Cpu);
        let mesh = renderer.builtin(BuiltinMesh::Torus);
        let programs = programs(1);
        for backend in [Backend::Cpu, Backend::Reference] {
            let png = frame(PictureFormat::Png, backend);
            let picture = renderer.render(&png, &mesh, &[&programs[0]]).unwrap().remove(0);
            let (width, height, rgba) = brood_eval::decode_png(&picture.bytes).unwrap();
            assert_eq!((width, height), (24, 24));
            assert!(rgba.chunks(4).any(|pixel| pixel[3] > 0 && pixel[0] > 0));
            let exr = frame(PictureFormat::Exr, backend);
            let picture = renderer.render(&exr, &mesh, &[&programs[0]]).unwrap().remove(0);
            assert!(picture.bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]));
        }
    }

    #[test]
    fn uploaded_mesh_is_rejected_when_content_hash_differs() {
        let renderer = Renderer::new(Backend::Cpu);
        let mesh = LoadedMesh::new(brood_mesh::Mesh::builtin(BuiltinMesh::Cube));
        let hash = *mesh.hash();
        assert!(matches!(renderer.cache_uploaded(&[0; 32], mesh), Err(RenderError::MeshContent)));
        let mesh = LoadedMesh::new(brood_mesh::Mesh::builtin(BuiltinMesh::Cube));
        assert!(renderer.uploaded(&hash).is_none());
        renderer.cache_uploaded(&hash, mesh).unwrap();
        assert!(renderer.uploaded(&hash).is_some());
    }
}
