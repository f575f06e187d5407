//! What rendering one picture leaves behind for the next: meshes, sample sets, programs.
//!
//! Everything here is derived and bounded; dropping an entry costs time, never a result.

use std::sync::Arc;

use brood_program::Program;
use brood_protocol::Frame;
use brood_scene::{BuiltinMesh, Film, Mesh, MeshRef, SampleSet, Scene};
use moka::sync::Cache;

/// Share of a sample set's inputs that is filled after it was weighed: eight f32 a sample cover the paper's dialect.
const LATER_INPUT_BYTES: usize = 32;
const PROGRAMS: u64 = 8192;

/// A mesh and its content hash, computed once.
#[derive(Debug)]
pub struct LoadedMesh {
    mesh: Mesh,
    hash: [u8; 32],
}

impl LoadedMesh {
    /// Takes a mesh in and hashes it.
    #[must_use]
    pub fn new(mesh: Mesh) -> Self {
        let hash = mesh.content_hash();
        Self { mesh, hash }
    }

    /// The mesh.
    #[must_use]
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// Its content hash.
    #[must_use]
    pub fn hash(&self) -> &[u8; 32] {
        &self.hash
    }
}

/// The caches of one renderer.
pub(crate) struct Caches {
    builtin: Cache<BuiltinMesh, Arc<LoadedMesh>>,
    uploaded: Cache<[u8; 32], Arc<LoadedMesh>>,
    sets: Cache<blake3::Hash, Arc<SampleSet>>,
    programs: Cache<blake3::Hash, Arc<Program>>,
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

    /// The sample set of a frame: the film and the name of the mesh have no part in it.
    pub(crate) fn sample_set(
        &self,
        scene: &Scene,
        mesh: &LoadedMesh,
        frame: &Frame,
    ) -> Arc<SampleSet> {
        let key = set_key(scene, mesh, frame);
        let render = || {
            let set = SampleSet::render(&mesh.mesh, scene, frame.size_px, frame.samples_per_pixel);
            Arc::new(set)
        };
        self.sets.get_with(key, render)
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
            return Ok(program);
        }
        let program = Arc::new(unpack(words)?);
        self.programs.insert(key, program.clone());
        Ok(program)
    }
}

fn set_key(scene: &Scene, mesh: &LoadedMesh, frame: &Frame) -> blake3::Hash {
    let plain = Scene {
        mesh: MeshRef::Builtin(BuiltinMesh::Sphere),
        film: Film::default(),
        ..scene.clone()
    };
    let json = serde_json::to_vec(&plain).expect("a scene is finite numbers and words");
    let mut hasher = blake3::Hasher::new();
    hasher.update(&mesh.hash);
    hasher.update(&frame.size_px.to_le_bytes());
    hasher.update(&frame.samples_per_pixel.to_le_bytes());
    hasher.update(&json);
    hasher.finalize()
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
    use brood_protocol::{Backend, MeshSource, PictureFormat};
    use brood_scene::Exposure;

    use super::*;

    #[test]
    fn sample_set_is_shared_when_only_the_film_differs() {
        let caches = Caches::new(64 << 20);
        let mesh = caches.builtin(BuiltinMesh::Sphere);
        let how = (PictureFormat::Png, Backend::Cpu);
        let scene = Scene::default();
        let frame = Frame::new(&scene, MeshSource::Builtin, 16, 1, how);
        let first = caches.sample_set(&scene, &mesh, &frame);
        let mut other = scene.clone();
        other.film.exposure = Exposure::Ev(2.0);
        assert!(Arc::ptr_eq(&first, &caches.sample_set(&other, &mesh, &frame)));
        other.scale = 0.5;
        assert!(!Arc::ptr_eq(&first, &caches.sample_set(&other, &mesh, &frame)));
        let torus = caches.builtin(BuiltinMesh::Torus);
        assert!(!Arc::ptr_eq(&first, &caches.sample_set(&scene, &torus, &frame)));
    }
}
