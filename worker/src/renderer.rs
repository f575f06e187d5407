//! Renderer: evaluates programs for a frame, shades, develops and encodes the pictures.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use brood_eval::{Developed, Gain, LitBackdrop, lobe_tables, shade};
use brood_light::LightAssets;
use brood_mesh::BuiltinMesh;
use brood_program::Program;
use brood_protocol::{
    Backend, BackendReport, Frame, PictureFormat, RenderStats, RenderedPicture, WorkerReport,
};
use brood_scene::{Exposure, Film, LobeNodes, LobeTable, PixelArea, SampleSet, Sampling};
use rayon::prelude::*;

use crate::banded_picture::banded_images;
use crate::bounded_cache::BoundedCache;
use crate::cache::Caches;
use crate::encoded_picture::EncodedPicture;
use crate::error::RenderError;
use crate::evaluated_picture::{EvaluatedPicture, FineTiles, Prefiltered, Refiner, SampledPicture};
use crate::evaluator::Evaluators;
use crate::render_counters::micros;
use crate::scene_view::{LoadedAssets, LoadedMesh, Raster, SceneView};
use crate::shot::{BATCH_FLOATS, Method, Shot};
use crate::target_cache::TargetCache;

const DEFAULT_CACHE_BYTES: u64 = 256 << 20;

/// Renders frames with one choice of evaluator, and caches meshes, sample sets and programs.
pub struct Renderer {
    pub(crate) evaluators: Arc<Evaluators>,
    pub(crate) caches: Caches,
    pub(crate) targets: TargetCache,
    entries: BoundedCache,
    reflectances: Mutex<Vec<f32>>,
    assets: Mutex<Arc<LoadedAssets>>,
    /// Uploaded meshes of objects beside the subject.
    pub(crate) object_meshes: Mutex<Vec<Arc<LoadedMesh>>>,
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
        Self::on(Arc::new(Evaluators::new(backend)), cache_bytes)
    }

    /// Creates a renderer with these evaluators, for other frames at the same time.
    #[must_use]
    pub(crate) fn beside(&self, cache_bytes: u64) -> Self {
        Self::on(self.evaluators.clone(), cache_bytes)
    }

    fn on(evaluators: Arc<Evaluators>, cache_bytes: u64) -> Self {
        let entries = BoundedCache::new(cache_bytes);
        Self {
            evaluators,
            caches: Caches::new(entries.clone()),
            targets: TargetCache::new(entries.clone()),
            entries,
            reflectances: Mutex::default(),
            assets: Mutex::new(Arc::new(LoadedAssets::new(LightAssets::default()))),
            object_meshes: Mutex::default(),
        }
    }

    /// Returns the cache, for light assets.
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

    /// Replaces the light assets, which scenes and painted materials refer to by name. A light
    /// whose asset is missing emits nothing; a painted material cannot be rendered then.
    pub fn set_light_assets(&self, assets: LightAssets) {
        let loaded = LoadedAssets::after(&self.loaded_assets(), assets);
        *self.assets.lock().unwrap_or_else(PoisonError::into_inner) = Arc::new(loaded);
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
        if frame.format == PictureFormat::Spheres {
            return self.lit_spheres(frame, mesh, programs);
        }
        self.beside_others(frame, mesh, programs, |program, picture, backdrop| {
            EncodedPicture::of(frame.format, program, picture, backdrop)
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
        let behind = |_: &Program, picture: &dyn EvaluatedPicture, backdrop: &LitBackdrop| {
            Ok(backdrop.behind(picture.develop()?))
        };
        self.beside_others(frame, mesh, programs, behind)
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
        finish: impl Fn(&Program, &dyn EvaluatedPicture) -> Result<T, RenderError> + Sync,
    ) -> Result<Vec<T>, RenderError> {
        let scene = frame.scene()?;
        scene.validate()?;
        let size_px = frame.size_px;
        let area = frame.area.unwrap_or(PixelArea::whole(size_px));
        if !area.is_within(size_px) {
            return Err(RenderError::Area { area, size_px });
        }
        let assets = self.loaded_assets();
        let others = self.objects(frame, &scene)?;
        let view = SceneView::among(&scene, mesh, &others, &assets);
        let view = view.with_clear(&self.clear_shares(frame)?);
        let mut shot = Shot { view, frame, film: scene.film, area, subject: None };
        shot.film = self.ground_exposure(&shot)?;
        self.shaded(&shot, programs, finish)
    }

    /// As [`Renderer::images`], for the part of the scene that a shot shows. Programs with the same
    /// bumps share their samples.
    pub(crate) fn shaded<T: Send>(
        &self,
        shot: &Shot<'_>,
        programs: &[&Program],
        finish: impl Fn(&Program, &dyn EvaluatedPicture) -> Result<T, RenderError> + Sync,
    ) -> Result<Vec<T>, RenderError> {
        let mut done: Vec<Option<T>> = programs.iter().map(|_| None).collect();
        for first in 0..programs.len() {
            if done[first].is_some() {
                continue;
            }
            let bumps = programs[first].bumps();
            let places = (first..programs.len()).filter(|at| programs[*at].bumps() == bumps);
            let places: Vec<usize> = places.collect();
            let own: Vec<&Program> = places.iter().map(|at| programs[*at]).collect();
            let view = shot.view.with_bumps(programs[first]);
            let shot = Shot { view, film: shot.film, area: shot.area, ..*shot };
            for (place, image) in places.into_iter().zip(self.shaded_alike(&shot, &own, &finish)?) {
                done[place] = Some(image);
            }
        }
        Ok(done.into_iter().flatten().collect())
    }

    /// As [`Renderer::shaded`], for programs with the bumps of the shot's view.
    fn shaded_alike<T: Send>(
        &self,
        shot: &Shot<'_>,
        programs: &[&Program],
        finish: impl Fn(&Program, &dyn EvaluatedPicture) -> Result<T, RenderError> + Sync,
    ) -> Result<Vec<T>, RenderError> {
        let scene = shot.view.scene();
        let prefilters = shot.frame.sampling == Sampling::Adaptive && scene.is_prefilterable();
        let method = |program: &Program| Method::of(program, prefilters);
        let mut done: Vec<Option<T>> = programs.iter().map(|_| None).collect();
        let tools = (&self.caches, &*self.evaluators);
        for own_method in Method::ALL {
            self.caches.check()?;
            let pairs = programs.iter().enumerate();
            let own = pairs.filter(|(_, program)| method(program) == own_method);
            let (places, own): (Vec<usize>, Vec<&Program>) = own.unzip();
            if own.is_empty() {
                continue;
            }
            let images = match own_method {
                Method::Samples => self.sampled_images(shot, &own, &finish)?,
                Method::Tables => self.prefiltered_images(shot, &own, &finish)?,
                Method::Direct(lobes) => {
                    banded_images(shot, lobes, &own, tools, &mut self.buffer(), &finish)?
                }
                Method::Points => self.painted_images(shot, &own, &finish)?,
                Method::Reflected => self.reflected_images(shot, &own, &finish)?,
            };
            for (place, image) in places.into_iter().zip(images) {
                done[place] = Some(image);
            }
        }
        Ok(done.into_iter().flatten().collect())
    }

    /// Evaluates the programs in batches on the samples of all lights.
    fn sampled_images<T: Send>(
        &self,
        shot: &Shot<'_>,
        programs: &[&Program],
        finish: impl Fn(&Program, &dyn EvaluatedPicture) -> Result<T, RenderError> + Sync,
    ) -> Result<Vec<T>, RenderError> {
        let Shot { view, frame, film, area, .. } = shot;
        let (size_px, sampling) = (frame.size_px, frame.sampling);
        // Adaptive sampling needs the neighbours of each pixel, to decide if it is rough.
        let traced_area =
            if sampling == Sampling::Adaptive { area.with_border(size_px) } else { *area };
        let set = self.caches.sample_set(view, Raster { size_px, sampling, area: traced_area });
        let gains = if *area == PixelArea::whole(size_px) {
            None
        } else {
            Some(self.gains(view, *film, frame, programs)?)
        };
        self.evaluated((view, frame), programs, &set, |index, program, f, refiner| {
            let gain = match &gains {
                Some(gains) => gains[index],
                None => Gain::new(*film, &set, f),
            };
            let samples = set.len() as u64;
            let picture = SampledPicture {
                set: &set,
                f,
                gain,
                area: *area,
                refiner,
                prefiltered: None,
                samples,
            };
            finish(program, &picture)
        })
    }

    /// Evaluates the programs on the samples of the other lights, and adds prefiltered
    /// environments.
    fn prefiltered_images<T: Send>(
        &self,
        shot: &Shot<'_>,
        programs: &[&Program],
        finish: impl Fn(&Program, &dyn EvaluatedPicture) -> Result<T, RenderError> + Sync,
    ) -> Result<Vec<T>, RenderError> {
        let Shot { view, frame, film, area, .. } = shot;
        let size_px = frame.size_px;
        let lit_area = shot.lit_area();
        let raster = Raster { size_px, sampling: Sampling::Adaptive, area: lit_area };
        let made = self.caches.prefiltered(view, raster);
        let others = view.scene().without_environments();
        let refined = view.with_scene(&others);
        let pixels = usize::try_from(lit_area.pixels()).expect("a picture fits the memory");
        let together = (BATCH_FLOATS / (3 * pixels)).max(1);
        let mut done = Vec::with_capacity(programs.len());
        for programs in programs.chunks(together) {
            let tables = self.lobe_tables(frame.backend, programs)?;
            let tables: Vec<&LobeTable> = tables.iter().map(|table| &**table).collect();
            let started = Instant::now();
            let radiance = made.light.shade(&tables, pixels);
            self.caches.counters.add(RenderStats {
                evaluation_us: micros(started.elapsed()),
                ..RenderStats::default()
            });
            let set = &made.set;
            let develop = |index: usize, program: &Program, f: &[f32], refiner: Refiner<'_>| {
                let mut image = shade(set, f);
                image.add(&radiance[index]);
                let gain = Gain::of_image(*film, &image);
                let prefiltered = Some(Prefiltered { image: &image, radiance: &radiance[index] });
                let samples = (set.len() + LobeNodes::get().set().len()) as u64;
                let area = *area;
                let picture = SampledPicture { set, f, gain, area, refiner, prefiltered, samples };
                finish(program, &picture)
            };
            done.extend(self.evaluated((&refined, frame), programs, set, develop)?);
        }
        Ok(done)
    }

    /// Evaluates the programs in batches on a set, and finishes the pictures in parallel. `finish`
    /// also receives the index of the program.
    fn evaluated<T: Send>(
        &self,
        (view, frame): (&SceneView<'_>, &Frame),
        programs: &[&Program],
        set: &SampleSet,
        finish: impl Fn(usize, &Program, &[f32], Refiner<'_>) -> Result<T, RenderError> + Sync,
    ) -> Result<Vec<T>, RenderError> {
        let tiles = FineTiles::new(frame.size_px);
        let floats = 3 * set.len();
        let batch = (BATCH_FLOATS / floats.max(1)).max(1);
        let mut out = std::mem::take(&mut *self.buffer());
        let mut done = Vec::with_capacity(programs.len());
        self.caches.advance(programs.len() as u64 * set.counts().rays);
        for (number, programs) in programs.chunks(batch).enumerate() {
            self.caches.check()?;
            let counters = &self.caches.counters;
            counters.timed(
                || self.evaluators.eval(frame.backend, programs, set, &mut out),
                |evaluation_us| RenderStats { evaluation_us, ..RenderStats::default() },
            )?;
            let counts = set.counts();
            let pictures = programs.len() as u64;
            let (rays, samples_covered) = (pictures * counts.rays, pictures * counts.covered);
            counters.add(RenderStats { rays, samples_covered, ..RenderStats::default() });
            self.caches.advance(rays);
            let started = Instant::now();
            let results: Result<Vec<T>, RenderError> = programs
                .par_iter()
                .enumerate()
                .map(|(index, program)| {
                    self.caches.check()?;
                    let f = &out[index * floats..(index + 1) * floats];
                    let (caches, evaluators) = (&self.caches, &*self.evaluators);
                    let tiles = &tiles;
                    let refiner = Refiner { caches, evaluators, view, frame, program, tiles };
                    finish(number * batch + index, program, f, refiner)
                })
                .collect();
            done.extend(results?);
            self.caches.advance(rays);
            counters
                .add(RenderStats { film_us: micros(started.elapsed()), ..RenderStats::default() });
        }
        *self.buffer() = out;
        Ok(done)
    }

    /// Returns the tables of programs, from the cache if possible.
    pub(crate) fn lobe_tables(
        &self,
        backend: Backend,
        programs: &[&Program],
    ) -> Result<Vec<Arc<LobeTable>>, RenderError> {
        let class = u8::from(backend == Backend::Reference);
        let mut tables: Vec<Option<Arc<LobeTable>>> =
            programs.iter().map(|program| self.caches.lobe_table(class, program)).collect();
        let missing: Vec<usize> = (0..tables.len()).filter(|k| tables[*k].is_none()).collect();
        if !missing.is_empty() {
            let programs: Vec<&Program> = missing.iter().map(|k| programs[*k]).collect();
            let made = self.caches.counters.timed(
                || {
                    lobe_tables(&programs, |programs, set, out| {
                        self.evaluators.eval(backend, programs, set, out)
                    })
                },
                |evaluation_us| RenderStats { evaluation_us, ..RenderStats::default() },
            )?;
            for ((k, program), table) in missing.into_iter().zip(programs).zip(made) {
                let table = Arc::new(table);
                self.caches.keep_lobe_table(class, program, table.clone());
                tables[k] = Some(table);
            }
        }
        Ok(tables.into_iter().flatten().collect())
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
