//! What rendering one picture leaves behind for the next: meshes, sample sets, programs.
//!
//! Everything here is derived and bounded; dropping an entry costs time, never a result.

use std::sync::Arc;

use brood_program::Program;
use brood_protocol::Work;
pub(crate) use brood_scene::Raster;
use brood_scene::{BuiltinMesh, Film, LightAssets, Mesh, MeshRef, SampleSet, Sampling, Scene};
use moka::sync::Cache;

use crate::tally::Tally;

/// Share of a sample set's inputs that is filled after it was weighed: eight f32 a sample cover the paper's dialect.
const LATER_INPUT_BYTES: usize = 32;
const PROGRAMS: u64 = 8192;

/// A mesh and its content hash, computed once.
#[derive(Debug)]
pub struct LoadedMesh {
    mesh: Arc<Mesh>,
    hash: [u8; 32],
}

impl LoadedMesh {
    /// Takes a mesh in and hashes it.
    #[must_use]
    pub fn new(mesh: Mesh) -> Self {
        let hash = mesh.content_hash();
        Self { mesh: Arc::new(mesh), hash }
    }

    /// The mesh.
    #[must_use]
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// The mesh for those who keep it.
    #[must_use]
    pub fn shared(&self) -> Arc<Mesh> {
        self.mesh.clone()
    }

    /// Its content hash.
    #[must_use]
    pub fn hash(&self) -> &[u8; 32] {
        &self.hash
    }
}

/// What lights refer to, and its content hash, computed once.
#[derive(Debug)]
pub(crate) struct LoadedAssets {
    assets: LightAssets,
    hash: blake3::Hash,
}

impl LoadedAssets {
    pub(crate) fn new(assets: LightAssets) -> Self {
        let hash = assets.content_hash();
        Self { assets, hash }
    }

    pub(crate) fn assets(&self) -> &LightAssets {
        &self.assets
    }
}

/// A scene, its mesh and what its lights refer to, under one name.
pub(crate) struct View<'a> {
    scene: &'a Scene,
    mesh: &'a Mesh,
    assets: &'a LightAssets,
    key: blake3::Hash,
}

impl<'a> View<'a> {
    /// Film and name of the mesh have no part in what is seen.
    pub(crate) fn new(scene: &'a Scene, mesh: &'a LoadedMesh, loaded: &'a LoadedAssets) -> Self {
        let plain = Scene {
            mesh: MeshRef::Builtin(BuiltinMesh::Sphere),
            film: Film::default(),
            ..scene.clone()
        };
        let json = serde_json::to_vec(&plain).expect("a scene is finite numbers and words");
        let mut hasher = blake3::Hasher::new();
        hasher.update(&mesh.hash);
        hasher.update(&json);
        hasher.update(loaded.hash.as_bytes());
        let (mesh, assets) = (&mesh.mesh, &loaded.assets);
        Self { scene, mesh, assets, key: hasher.finalize() }
    }

    fn render(&self, raster: Raster) -> SampleSet {
        SampleSet::render_lit(self.mesh, self.scene, self.assets, raster)
    }

    fn set_key(&self, raster: Raster) -> blake3::Hash {
        let Raster { size_px, sampling, area } = raster;
        // No fixed number is 0.
        let samples = match sampling {
            Sampling::Adaptive => 0,
            Sampling::Fixed(samples) => u32::from(samples),
        };
        let mut hasher = blake3::Hasher::new();
        hasher.update(self.key.as_bytes());
        for number in [size_px, samples, area.x, area.y, area.width, area.height] {
            hasher.update(&number.to_le_bytes());
        }
        hasher.finalize()
    }
}

/// The caches of one renderer.
pub(crate) struct Caches {
    builtin: Cache<BuiltinMesh, Arc<LoadedMesh>>,
    uploaded: Cache<[u8; 32], Arc<LoadedMesh>>,
    sets: Cache<blake3::Hash, Arc<SampleSet>>,
    programs: Cache<blake3::Hash, Arc<Program>>,
    pub(crate) tally: Tally,
}

impl Caches {
    /// Caches whose meshes and sample sets weigh about `bytes` together.
    pub(crate) fn new(bytes: u64) -> Self {
        let kib = (bytes / 1024).max(1);
        Self {
            builtin: Cache::new(BuiltinMesh::ALL.len() as u64),
            uploaded: Cache::builder().max_capacity(kib / 4).weigher(weigh_mesh).build(),
            sets: Cache::builder().max_capacity(kib - kib / 4).weigher(weigh_set).build(),
            programs: Cache::new(PROGRAMS),
            tally: Tally::default(),
        }
    }

    pub(crate) fn builtin(&self, name: BuiltinMesh) -> Arc<LoadedMesh> {
        self.builtin.get_with(name, || Arc::new(LoadedMesh::new(Mesh::builtin(name))))
    }

    pub(crate) fn uploaded(&self, hash: &[u8; 32]) -> Option<Arc<LoadedMesh>> {
        self.uploaded.get(hash)
    }

    pub(crate) fn keep_uploaded(&self, mesh: Arc<LoadedMesh>) {
        self.uploaded.insert(*mesh.hash(), mesh);
    }

    /// The sample set of a raster, which lies within its picture.
    pub(crate) fn sample_set(&self, view: &View<'_>, raster: Raster) -> Arc<SampleSet> {
        let mut made = false;
        let set = self.tally.timed(
            || {
                self.sets.get_with(view.set_key(raster), || {
                    made = true;
                    Arc::new(view.render(raster))
                })
            },
            |sets_us| Work { sets_us, ..Work::default() },
        );
        let (sets_made, sets_reused) = (u64::from(made), u64::from(!made));
        self.tally.add(Work { sets_made, sets_reused, ..Work::default() });
        set
    }

    /// The same for those who are a task among many: while one of them made the set, the others would wait for it, and
    /// the one too, if it was given the work of another while its own rays are shared out. Making a set twice does no
    /// harm.
    pub(crate) fn sample_set_in_task(&self, view: &View<'_>, raster: Raster) -> Arc<SampleSet> {
        let key = view.set_key(raster);
        if let Some(set) = self.sets.get(&key) {
            self.tally.add(Work { sets_reused: 1, ..Work::default() });
            return set;
        }
        self.tally.add(Work { sets_made: 1, ..Work::default() });
        let set = Arc::new(view.render(raster));
        self.sets.insert(key, set.clone());
        set
    }

    /// The program of packed words.
    pub(crate) fn program<E>(
        &self,
        words: &[u32],
        unpack: impl FnOnce(&[u32]) -> Result<Program, E>,
    ) -> Result<Arc<Program>, E> {
        let mut hasher = blake3::Hasher::new();
        for word in words {
            hasher.update(&word.to_le_bytes());
        }
        let key = hasher.finalize();
        if let Some(program) = self.programs.get(&key) {
            self.tally.add(Work { translations_reused: 1, ..Work::default() });
            return Ok(program);
        }
        self.tally.add(Work { translations_made: 1, ..Work::default() });
        let program = Arc::new(unpack(words)?);
        self.programs.insert(key, program.clone());
        Ok(program)
    }
}

fn weigh_set(_: &blake3::Hash, set: &Arc<SampleSet>) -> u32 {
    kib(set.bytes().saturating_add(set.len().saturating_mul(LATER_INPUT_BYTES)))
}

fn weigh_mesh(_: &[u8; 32], mesh: &Arc<LoadedMesh>) -> u32 {
    // Position, normal, tangent and texture coordinate in f64 for a vertex, three indices for a triangle.
    kib(mesh.mesh.vertex_count() * 88 + mesh.mesh.triangle_count() * 12)
}

fn kib(bytes: usize) -> u32 {
    u32::try_from(bytes / 1024 + 1).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use brood_scene::{Exposure, PixelArea};

    use super::*;

    #[test]
    fn sample_set_is_shared_when_only_the_film_differs() {
        let caches = Caches::new(64 << 20);
        let mesh = caches.builtin(BuiltinMesh::Sphere);
        let none = LoadedAssets::new(LightAssets::default());
        let scene = Scene::default();
        let whole = PixelArea::whole(16);
        let frame = Raster { size_px: 16, sampling: Sampling::Adaptive, area: whole };
        let first = caches.sample_set(&View::new(&scene, &mesh, &none), frame);
        let mut other = scene.clone();
        other.film.exposure = Exposure::Ev(2.0);
        assert!(Arc::ptr_eq(&first, &caches.sample_set(&View::new(&other, &mesh, &none), frame)));
        other.scale = 0.5;
        assert!(!Arc::ptr_eq(&first, &caches.sample_set(&View::new(&other, &mesh, &none), frame)));
        let torus = caches.builtin(BuiltinMesh::Torus);
        assert!(!Arc::ptr_eq(&first, &caches.sample_set(&View::new(&scene, &torus, &none), frame)));
        let fixed = Raster { sampling: Sampling::Fixed(1), ..frame };
        assert!(!Arc::ptr_eq(&first, &caches.sample_set(&View::new(&scene, &mesh, &none), fixed)));
        let part = Raster { area: PixelArea { width: 3, ..whole }, ..frame };
        assert!(!Arc::ptr_eq(&first, &caches.sample_set(&View::new(&scene, &mesh, &none), part)));
    }
}
