//! Caches of a renderer: meshes, sample sets, programs.
//!
//! Everything here is derived and bounded. Dropping an entry costs time and changes no result.

use std::convert::Infallible;
use std::sync::{Arc, Mutex, PoisonError};

use brood_eval::{GatheredLight, Surroundings, shade_prefiltered};
use brood_mesh::{BuiltinMesh, Mesh};
use brood_program::Program;
use brood_protocol::{Backend, RenderStats};
use brood_scene::{
    LobeTable, PictureSize, PixelArea, PrefilteredLight, SampleSet, Sampling, SphereLayout,
};
use moka::sync::Cache;

use crate::bounded_cache::BoundedCache;
use crate::error::RenderError;
use crate::job_control::JobControl;
use crate::render_counters::RenderCounters;
use crate::scene_view::{LoadedMesh, Raster, SceneView};

/// Bytes per sample for inputs that are computed after a sample set was weighed: eight f32 cover
/// the dialect `paper`.
const LATER_INPUT_BYTES: usize = 32;
/// Largest size of gathered light that is kept: that of pictures of the ball of about 640 pixels a
/// side.
const GATHERED_BYTES_MAX: usize = 160 << 20;
/// Bytes per packed word of a program with its translations.
const PROGRAM_BYTES: usize = 64;

/// Caches of one renderer.
pub(crate) struct Caches {
    builtin: Cache<BuiltinMesh, Arc<LoadedMesh>>,
    entries: BoundedCache,
    pub(crate) counters: RenderCounters,
    control: Mutex<JobControl>,
}

impl Caches {
    /// Creates caches in `entries`. Built-in meshes are kept beside them.
    pub(crate) fn new(entries: BoundedCache) -> Self {
        Self {
            // With the sphere of other poles and the ground, which have no names.
            builtin: Cache::new(BuiltinMesh::ALL.len() as u64 + 2),
            entries,
            counters: RenderCounters::default(),
            control: Mutex::default(),
        }
    }

    /// Sets the current job. Once it is cancelled, rendering ends with [`RenderError::Cancelled`].
    pub(crate) fn set_control(&self, control: JobControl) {
        *self.control.lock().unwrap_or_else(PoisonError::into_inner) = control;
    }

    /// Error if the current job is cancelled.
    pub(crate) fn check(&self) -> Result<(), RenderError> {
        let control = self.control.lock().unwrap_or_else(PoisonError::into_inner);
        if control.cancelled.is_cancelled() { Err(RenderError::Cancelled) } else { Ok(()) }
    }

    /// Notes that this many rays of the current job have done one more step of three: sample,
    /// evaluation, film.
    pub(crate) fn advance(&self, rays: u64) {
        self.control.lock().unwrap_or_else(PoisonError::into_inner).advance(rays);
    }

    pub(crate) fn builtin(&self, name: BuiltinMesh) -> Arc<LoadedMesh> {
        self.builtin.get_with(name, || Arc::new(LoadedMesh::new(Mesh::builtin(name))))
    }

    pub(crate) fn find_uploaded(&self, hash: &[u8; 32]) -> Option<Arc<LoadedMesh>> {
        self.entries.get(*hash)
    }

    /// Returns the cached mesh with the same content, or caches this one.
    pub(crate) fn uploaded(&self, mesh: LoadedMesh) -> Arc<LoadedMesh> {
        let key = *mesh.hash();
        let make = || {
            let bytes = bytes_of(&mesh);
            Ok::<_, Infallible>((Arc::new(mesh), bytes))
        };
        self.entries.get_or_make(key, make).unwrap_or_else(|error| match *error {})
    }

    /// Returns the sample set of a raster, which must lie within its picture. Concurrent callers
    /// wait for the one that computes it.
    pub(crate) fn sample_set(&self, view: &SceneView<'_>, raster: Raster) -> Arc<SampleSet> {
        self.set_of(view, raster, || {
            let set = view.render(raster);
            let bytes = bytes_of_set(&set);
            (set, bytes)
        })
    }

    /// Returns the points of a raster with their lights, for painted materials.
    pub(crate) fn points(&self, view: &SceneView<'_>, raster: Raster) -> Arc<SampleSet> {
        self.timed_set(view.points_key(raster), || {
            let set = SampleSet::render_points(view.stage.clone(), view.scene, view.assets, raster);
            let bytes = bytes_of_set(&set);
            (set, bytes)
        })
    }

    /// Returns the points of a raster with their places on the surface, for clear materials.
    pub(crate) fn clear_points(&self, view: &SceneView<'_>, raster: Raster) -> Arc<SampleSet> {
        let mut hasher = blake3::Hasher::new();
        hasher.update(view.points_key(raster).as_bytes()).update(b"clear");
        self.timed_set(hasher.finalize(), || {
            let (stage, scene, assets) = (view.stage.clone(), view.scene, view.assets);
            let set = SampleSet::render_clear_points(stage, scene, assets, raster);
            let bytes = bytes_of_set(&set);
            (set, bytes)
        })
    }

    /// Returns the sample set of a raster without environments, and their prefiltered light.
    pub(crate) fn prefiltered(&self, view: &SceneView<'_>, raster: Raster) -> Arc<PrefilteredSet> {
        self.set_of(view, raster, || {
            let (set, light) = view.render_prefiltered(raster);
            let (light, bytes) = LightOnPoints::new(light);
            let bytes = bytes_of_set(&set) + bytes;
            (PrefilteredSet { set, light }, bytes)
        })
    }

    /// Returns the environments of a view on its lit spheres.
    pub(crate) fn lit_spheres(
        &self,
        view: &SceneView<'_>,
        layout: SphereLayout,
    ) -> Arc<LightOnPoints> {
        let make = || {
            let (scene, mesh, assets) = (view.scene, view.stage.mesh(), view.assets);
            LightOnPoints::new(PrefilteredLight::on_spheres(scene, mesh, assets, layout))
        };
        self.timed_set(view.spheres_key(layout), make)
    }

    /// Returns the key of the exposure of a material in a view, by an evaluator.
    pub(crate) fn metered_key(
        &self,
        view: &SceneView<'_>,
        size_px: PictureSize,
        (program, backend): (&Program, Backend),
    ) -> [u8; 32] {
        let area = PixelArea::whole(size_px);
        let raster = Raster { size_px, sampling: Sampling::Adaptive, area };
        let mut hasher = blake3::Hasher::new();
        hasher.update(view.set_key(raster).as_bytes()).update(program.hash().as_bytes());
        hasher.update(&[u8::from(backend == Backend::Reference)]);
        *hasher.finalize().as_bytes()
    }

    /// Returns a measured exposure in EV if it is in the cache; `Some(None)` if there is none.
    pub(crate) fn metered(&self, key: [u8; 32]) -> Option<Option<f64>> {
        self.entries.get(key).map(|ev| *ev)
    }

    pub(crate) fn keep_metered(&self, key: [u8; 32], ev: Option<f64>) {
        self.entries.insert(key, Arc::new(ev), size_of::<Option<f64>>());
    }

    /// Returns the pictures of a view's other objects, from the cache if possible. `identity` is a
    /// hash of everything else that they depend on.
    pub(crate) fn surroundings(
        &self,
        (view, raster): (&SceneView<'_>, Raster),
        identity: &blake3::Hash,
        make: impl FnOnce() -> Result<Surroundings, RenderError>,
    ) -> Result<Arc<Surroundings>, RenderError> {
        let mut hasher = blake3::Hasher::new();
        hasher.update(view.set_key(raster).as_bytes()).update(identity.as_bytes());
        self.entry(*hasher.finalize().as_bytes(), || {
            let made = make()?;
            let bytes = made.bytes();
            Ok((made, bytes))
        })
    }

    /// Returns what `make` makes of a raster, from the cache if possible. `make` also returns its
    /// size in bytes.
    fn set_of<T: Send + Sync + 'static>(
        &self,
        view: &SceneView<'_>,
        raster: Raster,
        make: impl FnOnce() -> (T, usize),
    ) -> Arc<T> {
        self.timed_set(view.set_key(raster), make)
    }

    fn timed_set<T: Send + Sync + 'static>(
        &self,
        key: blake3::Hash,
        make: impl FnOnce() -> (T, usize),
    ) -> Arc<T> {
        let mut made = false;
        let set = self.counters.timed(
            || {
                let make = || {
                    made = true;
                    let (set, bytes) = make();
                    Ok::<_, Infallible>((Arc::new(set), bytes))
                };
                self.entries
                    .get_or_make(*key.as_bytes(), make)
                    .unwrap_or_else(|error| match *error {})
            },
            |sets_us| RenderStats { sets_us, ..RenderStats::default() },
        );
        let (sets_made, sets_reused) = (u64::from(made), u64::from(!made));
        self.counters.add(RenderStats { sets_made, sets_reused, ..RenderStats::default() });
        set
    }

    /// Returns the table of a program if it is in the cache. `class`: 1 for the reference
    /// evaluator, 0 for the others.
    pub(crate) fn lobe_table(&self, class: u8, program: &Program) -> Option<Arc<LobeTable>> {
        self.entries.get(table_key(class, program))
    }

    pub(crate) fn keep_lobe_table(&self, class: u8, program: &Program, table: Arc<LobeTable>) {
        self.entries.insert(table_key(class, program), table, LobeTable::BYTES);
    }

    /// Like [`Caches::sample_set`], for callers inside a rayon task. It never waits for another
    /// task that computes the same set: that task may itself be suspended below the caller on the
    /// same thread, which would deadlock. Computing a set twice is harmless.
    pub(crate) fn sample_set_nonblocking(
        &self,
        view: &SceneView<'_>,
        raster: Raster,
    ) -> Arc<SampleSet> {
        let key = *view.set_key(raster).as_bytes();
        if let Some(set) = self.entries.get(key) {
            self.counters.add(RenderStats { sets_reused: 1, ..RenderStats::default() });
            return set;
        }
        self.counters.add(RenderStats { sets_made: 1, ..RenderStats::default() });
        let set = Arc::new(view.render(raster));
        self.entries.insert(key, set.clone(), bytes_of_set(&set));
        set
    }

    /// Returns the entry of a key, or makes it with its size in bytes. Concurrent callers may make
    /// it twice.
    pub(crate) fn entry<T: Send + Sync + 'static>(
        &self,
        key: [u8; 32],
        make: impl FnOnce() -> Result<(T, usize), RenderError>,
    ) -> Result<Arc<T>, RenderError> {
        if let Some(known) = self.entries.get(key) {
            return Ok(known);
        }
        let (made, bytes) = make()?;
        let made = Arc::new(made);
        self.entries.insert(key, made.clone(), bytes);
        Ok(made)
    }

    /// Returns the program with these packed words, from the cache if possible.
    pub(crate) fn program<E>(
        &self,
        words: &[u32],
        unpack: impl FnOnce(&[u32]) -> Result<Program, E>,
    ) -> Result<Arc<Program>, E> {
        let mut hasher = blake3::Hasher::new();
        for word in words {
            hasher.update(&word.to_le_bytes());
        }
        let key = *hasher.finalize().as_bytes();
        if let Some(program) = self.entries.get(key) {
            self.counters.add(RenderStats { translations_reused: 1, ..RenderStats::default() });
            return Ok(program);
        }
        self.counters.add(RenderStats { translations_made: 1, ..RenderStats::default() });
        let program = Arc::new(unpack(words)?);
        self.entries.insert(key, program.clone(), PROGRAM_BYTES * words.len());
        Ok(program)
    }
}

/// Sample set of the lights that are sampled, and the light that is not.
pub(crate) struct PrefilteredSet {
    pub(crate) set: SampleSet,
    pub(crate) light: LightOnPoints,
}

/// Prefiltered light, gathered unless that takes too much memory.
pub(crate) struct LightOnPoints {
    /// Without its environments if the light is gathered.
    light: PrefilteredLight,
    /// `None` for large pictures, which gather the light again for every batch.
    gathered: Option<GatheredLight>,
}

impl LightOnPoints {
    /// Gathers the light; also returns the size in bytes.
    fn new(light: PrefilteredLight) -> (Self, usize) {
        let bytes = GatheredLight::bytes_for(&light);
        let (light, gathered, kept) = if bytes <= GATHERED_BYTES_MAX {
            let gathered = GatheredLight::new(&light);
            (light.without_environments(), Some(gathered), bytes)
        } else {
            (light, None, 0)
        };
        let bytes = light.bytes() + kept;
        (Self { light, gathered }, bytes)
    }

    /// Returns the radiance of each pixel times coverage, for each table.
    pub(crate) fn shade(&self, tables: &[&LobeTable], pixels: usize) -> Vec<Vec<[f32; 3]>> {
        shade_prefiltered(tables, &self.light, self.gathered.as_ref(), pixels)
    }
}

fn table_key(class: u8, program: &Program) -> [u8; 32] {
    let mut hasher = blake3::Hasher::new();
    hasher.update(&[class]);
    hasher.update(program.hash().as_bytes());
    *hasher.finalize().as_bytes()
}

fn bytes_of_set(set: &SampleSet) -> usize {
    set.bytes().saturating_add(set.len().saturating_mul(LATER_INPUT_BYTES))
}

fn bytes_of(mesh: &LoadedMesh) -> usize {
    // Bytes per vertex: position, normal, tangent and texture coordinate in f64. Bytes per
    // triangle: three indices, and the triangle and nodes of the tracer that the first picture
    // builds.
    mesh.mesh().vertex_count() * 88 + mesh.mesh().triangle_count() * (12 + 144)
}

#[cfg(test)]
mod tests {
    use brood_light::LightAssets;
    use brood_scene::{Exposure, Scene};

    use super::*;
    use crate::scene_view::LoadedAssets;

    #[test]
    fn sample_set_is_shared_when_only_film_differs() {
        let caches = Caches::new(BoundedCache::new(64 << 20));
        let mesh = caches.builtin(BuiltinMesh::Sphere);
        let none = LoadedAssets::new(LightAssets::default());
        let scene = Scene::default();
        let whole = PixelArea::whole(16);
        let frame = Raster { size_px: 16.into(), sampling: Sampling::Adaptive, area: whole };
        let first = caches.sample_set(&SceneView::new(&scene, &mesh, &none), frame);
        let mut other = scene.clone();
        other.film.exposure = Exposure::Ev(2.0);
        assert!(Arc::ptr_eq(
            &first,
            &caches.sample_set(&SceneView::new(&other, &mesh, &none), frame)
        ));
        other.scale = 0.5;
        assert!(!Arc::ptr_eq(
            &first,
            &caches.sample_set(&SceneView::new(&other, &mesh, &none), frame)
        ));
        let torus = caches.builtin(BuiltinMesh::Torus);
        assert!(!Arc::ptr_eq(
            &first,
            &caches.sample_set(&SceneView::new(&scene, &torus, &none), frame)
        ));
        let fixed = Raster { sampling: Sampling::Fixed(1), ..frame };
        assert!(!Arc::ptr_eq(
            &first,
            &caches.sample_set(&SceneView::new(&scene, &mesh, &none), fixed)
        ));
        let part = Raster { area: PixelArea { width: 3, ..whole }, ..frame };
        assert!(!Arc::ptr_eq(
            &first,
            &caches.sample_set(&SceneView::new(&scene, &mesh, &none), part)
        ));
    }
}
