//! Read-through caches of materials by genome hash, scenes, and frames.

use std::sync::Arc;

use brood_eval::express;
use brood_genome::preset::{Preset, neutral};
use brood_genome::{Genome, GenomeHash, Input};
use brood_inspect::{CurvePoint, Inspection, LightOrbit, Phenomena, inspect};
use brood_mesh::{BuiltinMesh, Mesh};
use brood_program::{Program, ProgramHash};
use brood_protocol::{
    Backend, Frame, Lineage, MeshId, MeshSource, ObjectSource, PictureFormat, PictureKey,
    RENDERER_VERSION, SceneId, Subject, decode_stored,
};
use brood_scene::{MeshRef, PictureSize, PixelArea, Sampling, Scene};
use brood_storage::{NewPicture, StorageError, Store, StoredGenome};
use moka::{future, sync};

use crate::problem::{ApiError, quote};
use crate::processors::run_blocking;
use crate::scene_asset;

const MATERIALS: u64 = 4096;
const SCENES: u64 = 1024;
const FRAMES: u64 = 1024;
const INSPECTIONS: u64 = 256;
const CIRCLES: u64 = 16;
const OPTICS: u64 = 1024;

/// Genome and the program it expresses.
#[derive(Debug)]
pub struct Material {
    /// Genotype.
    pub genome: Genome,
    /// Phenotype.
    pub program: Program,
}

/// Checks that a genome is a BRDF, for exports and measurements that a painted material does not
/// have.
///
/// # Errors
/// [`ApiError`] if the genome is painted.
pub fn check_brdf(genome: &Genome) -> Result<(), ApiError> {
    match genome.is_painted() {
        true => Err(ApiError::refused("a painted material is not a BRDF")),
        false => Ok(()),
    }
}

/// Checks that a painted material can be drawn under this number of lights.
///
/// # Errors
/// 422 if there are too many.
pub fn check_painted_lights(lights: usize) -> Result<(), ApiError> {
    too_many_lights(lights).map_or(Ok(()), |words| Err(ApiError::refused(words)))
}

/// Returns why a painted material cannot be drawn under this number of lights.
fn too_many_lights(lights: usize) -> Option<String> {
    let most = Input::LIGHTS;
    (lights > most).then(|| {
        format!("a scene of painted materials must have at most {most} lights, got {lights}")
    })
}

/// Optical properties of a material in a scene.
#[derive(Debug, Clone)]
pub struct Optics {
    /// Curves over the angle of incidence.
    pub curves: Vec<CurvePoint>,
    /// Summary values.
    pub phenomena: Phenomena,
}

/// Scene with the sources of its meshes and materials.
#[derive(Debug)]
pub struct KnownScene {
    /// Scene.
    pub scene: Scene,
    /// Source of the mesh for workers.
    pub mesh: MeshSource,
    /// The other objects for workers, then the ground.
    pub objects: Vec<ObjectSource>,
    /// True if there is a ground whose material is a BRDF.
    pub has_lit_ground: bool,
}

/// Framing of a picture: everything but the material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Framing {
    /// Scene.
    pub scene: SceneId,
    /// Light angle in degrees; the scene's if absent.
    pub light_deg: Option<f64>,
    /// Size of the whole picture.
    pub size_px: PictureSize,
    /// Samples per pixel.
    pub sampling: Sampling,
    /// Part of the picture to render; all of it if absent.
    pub area: Option<PixelArea>,
    /// File format.
    pub format: PictureFormat,
    /// Backend.
    pub backend: Backend,
}

impl Framing {
    /// Returns the framing of a whole PNG picture in the scene's light.
    pub fn png(scene: SceneId, size_px: impl Into<PictureSize>, backend: Backend) -> Self {
        Self {
            scene,
            light_deg: None,
            size_px: size_px.into(),
            sampling: Sampling::default(),
            area: None,
            format: PictureFormat::Png,
            backend,
        }
    }

    /// Returns the framing of a lineage's thumbnails.
    pub fn thumbnail(backend: Backend, lineage: &Lineage) -> Self {
        Self::png(lineage.scene, lineage.thumbnail_px, backend)
    }
}

/// Bits of a [`Framing`], as a hashable key.
type FrameKey = (SceneId, Option<u64>, Shape, PictureFormat, Backend);
/// Size, sampling and area.
type Shape = (PictureSize, Sampling, Option<PixelArea>);

/// Decodes a stored genome.
///
/// # Errors
/// 500 if it cannot be decoded or has another hash.
pub fn read_genome(hash: GenomeHash, stored: &StoredGenome) -> Result<Genome, ApiError> {
    let read = match stored {
        StoredGenome::Bytes(bytes) => {
            Genome::from_canonical_bytes(bytes).map_err(|error| error.to_string())
        }
        StoredGenome::Text(text) => text.parse::<Genome>().map_err(|error| error.to_string()),
    };
    let read = read.and_then(|genome| match genome.hash() == hash {
        true => Ok(genome),
        false => Err("it has another hash".to_owned()),
    });
    read.map_err(|error| {
        ApiError::internal(format!("stored genome {hash} cannot be read: {error}"))
    })
}

/// Frame with its hash, so that a picture key costs two hashes.
#[derive(Debug)]
pub struct Framed {
    /// Frame for workers.
    pub frame: Frame,
    identity: blake3::Hash,
    view: Framing,
    light_deg: f64,
    /// Number of lights of the scene.
    lights: usize,
}

impl Framed {
    /// Checks that a program can be drawn in this frame.
    ///
    /// # Errors
    /// 422 if it cannot.
    pub fn check(&self, program: &Program) -> Result<(), ApiError> {
        self.refusal(program).map_or(Ok(()), |words| Err(ApiError::refused(words)))
    }

    /// Returns why a program cannot be drawn in this frame.
    pub fn refusal(&self, program: &Program) -> Option<String> {
        if program.is_painted() { too_many_lights(self.lights) } else { None }
    }

    /// Returns the key of a program's picture in this frame.
    pub fn key(&self, program: ProgramHash) -> PictureKey {
        PictureKey::of(&Subject::Program(program), &self.identity)
    }

    /// Returns the row that describes a key.
    pub fn row(&self, key: PictureKey, genome_hash: GenomeHash) -> NewPicture {
        NewPicture {
            key,
            genome_hash,
            scene: self.view.scene,
            light_deg: self.light_deg,
            size_px: self.view.size_px,
            sampling: self.view.sampling,
            area: self.view.area,
            format: self.view.format,
            backend: self.view.backend,
            renderer_version: RENDERER_VERSION,
        }
    }
}

/// Caches over the store. Concurrent requests for one entry read it once.
pub struct Library {
    store: Store,
    materials: future::Cache<GenomeHash, Arc<Material>>,
    scenes: future::Cache<SceneId, Arc<KnownScene>>,
    frames: future::Cache<FrameKey, Arc<Framed>>,
    inspections: sync::Cache<GenomeHash, Arc<Inspection>>,
    circles: future::Cache<SceneId, Arc<LightOrbit>>,
    optics: sync::Cache<(GenomeHash, SceneId), Arc<Optics>>,
}

impl Library {
    /// Creates empty caches over a store.
    pub fn new(store: Store) -> Self {
        Self {
            store,
            materials: future::Cache::new(MATERIALS),
            scenes: future::Cache::new(SCENES),
            frames: future::Cache::new(FRAMES),
            inspections: sync::Cache::new(INSPECTIONS),
            circles: future::Cache::new(CIRCLES),
            optics: sync::Cache::new(OPTICS),
        }
    }

    /// Caches a new material.
    pub async fn insert_material(
        &self,
        hash: GenomeHash,
        genome: Genome,
        program: Program,
    ) -> Arc<Material> {
        let material = Arc::new(Material { genome, program });
        self.materials.insert(hash, material.clone()).await;
        material
    }

    /// Drops all materials. Called after a purge, as the store may have lost some of them.
    pub fn clear_materials(&self) {
        self.materials.invalidate_all();
        self.inspections.invalidate_all();
        self.optics.invalidate_all();
    }

    /// Returns a material by its genome's hash.
    ///
    /// # Errors
    /// [`ApiError`] if it does not exist or cannot be read.
    pub async fn material(&self, hash: GenomeHash) -> Result<Arc<Material>, ApiError> {
        let read = async {
            let stored = self.store.genome(hash).await?;
            let read = move || {
                let genome = read_genome(hash, &stored)?;
                let program = express(&genome);
                Ok(Arc::new(Material { genome, program }))
            };
            run_blocking(read).await?
        };
        Ok(self.materials.try_get_with(hash, read).await?)
    }

    /// Returns a material that is a BRDF, by its genome's hash.
    ///
    /// # Errors
    /// As [`Library::material`], and if the material is painted.
    pub async fn brdf(&self, hash: GenomeHash) -> Result<Arc<Material>, ApiError> {
        let material = self.material(hash).await?;
        check_brdf(&material.genome)?;
        Ok(material)
    }

    /// Returns the cached inspection of a genome.
    pub fn known_inspection(&self, hash: GenomeHash) -> Option<Arc<Inspection>> {
        self.inspections.get(&hash)
    }

    /// Inspects a genome and caches the result.
    pub fn inspect(&self, hash: GenomeHash, genome: &Genome) -> Arc<Inspection> {
        let inspection = Arc::new(inspect(genome));
        self.inspections.insert(hash, inspection.clone());
        inspection
    }

    /// Returns the optical properties of a material in a scene, computed with `make` if not cached.
    pub fn optics(
        &self,
        (hash, scene): (GenomeHash, SceneId),
        make: impl FnOnce() -> Optics,
    ) -> Arc<Optics> {
        self.optics.get_with((hash, scene), || Arc::new(make()))
    }

    /// Returns the low-resolution light orbit of a scene, used to measure exposures.
    ///
    /// # Errors
    /// [`ApiError`] if the scene, its mesh or a light's file cannot be read.
    pub async fn light_circle(&self, id: SceneId) -> Result<Arc<LightOrbit>, ApiError> {
        let trace = async {
            let known = self.scene(id).await?;
            let mesh = self.scene_mesh(&known).await?;
            let assets = scene_asset::load(&self.store, &known.scene).await?;
            let trace = move || Arc::new(LightOrbit::trace(&mesh, &known.scene, &assets));
            run_blocking(trace).await
        };
        Ok(self.circles.try_get_with(id, trace).await?)
    }

    /// Returns a scene by its id.
    ///
    /// # Errors
    /// [`ApiError`] if it does not exist or cannot be read.
    pub async fn scene(&self, id: SceneId) -> Result<Arc<KnownScene>, ApiError> {
        let read = async {
            let json = self.store.scene(id).await?;
            let scene: Scene = serde_json::from_str(&json).map_err(|error| {
                ApiError::internal(format!("stored scene {id} cannot be read: {error}"))
            })?;
            let (mesh, objects) = self.meshes(&scene).await?;
            let ground = scene.ground.as_ref().and_then(|_| objects.last());
            let ground = ground.map(|ground| Program::from_words(&ground.words)).transpose();
            let ground = ground.map_err(|error| ApiError::internal(error.to_string()))?;
            let has_lit_ground = ground.is_some_and(|ground| !ground.is_painted());
            Ok::<_, ApiError>(Arc::new(KnownScene { scene, mesh, objects, has_lit_ground }))
        };
        Ok(self.scenes.try_get_with(id, read).await?)
    }

    /// Returns the source of a scene's mesh, and its other objects, then its ground.
    ///
    /// # Errors
    /// 422 or 404 with a pointer if the scene names a mesh or a material that does not exist.
    pub async fn meshes(&self, scene: &Scene) -> Result<(MeshSource, Vec<ObjectSource>), ApiError> {
        let mesh = self.mesh(scene).await?;
        let mut sources = Vec::with_capacity(scene.objects.len() + 1);
        for (index, object) in scene.objects.iter().enumerate() {
            sources.push(self.mesh_of(&object.mesh, &format!("/objects/{index}/mesh")).await?);
        }
        sources.extend(scene.ground.iter().map(|_| MeshSource::Builtin));
        let mut objects = Vec::with_capacity(sources.len());
        for ((name, pointer), mesh) in scene.materials().zip(sources) {
            let material = self.material_of(name).await.map_err(|error| error.at(pointer))?;
            let program = &material.program;
            if program.is_painted() {
                check_painted_lights(scene.lights.len()).map_err(|error| error.at("/lights"))?;
            }
            objects.push(ObjectSource { mesh, words: program.to_words() });
        }
        Ok((mesh, objects))
    }

    /// Returns the material of an object: a preset, a stored genome, or neutral grey.
    ///
    /// # Errors
    /// 422 or 404 if there is no such preset or genome.
    pub async fn material_of(&self, name: Option<&str>) -> Result<Arc<Material>, ApiError> {
        let of = |genome: &Genome| {
            let (genome, program) = (genome.clone(), express(genome));
            Ok(Arc::new(Material { genome, program }))
        };
        let Some(name) = name else { return of(neutral()) };
        if let Some(preset) = Preset::find(name) {
            return of(preset.genome());
        }
        let hash: GenomeHash = name.parse().map_err(|_| {
            let words = format!(
                "the material {} is not the name of a preset, and not the hash of a genome",
                quote(name)
            );
            ApiError::refused(words)
        })?;
        self.material(hash).await
    }

    /// Returns the source of a scene's mesh.
    ///
    /// # Errors
    /// 422 or 404 if the scene names no existing mesh.
    pub async fn mesh(&self, scene: &Scene) -> Result<MeshSource, ApiError> {
        self.mesh_of(&scene.mesh, "/mesh").await
    }

    async fn mesh_of(&self, mesh: &MeshRef, pointer: &str) -> Result<MeshSource, ApiError> {
        let MeshRef::Uploaded(id) = mesh else { return Ok(MeshSource::Builtin) };
        let id: MeshId = id.parse().map_err(|_| {
            let names = BuiltinMesh::ALL.map(BuiltinMesh::name).join(", ");
            ApiError::refused(format!(
                "the mesh {id:?} is none of {names}, and not the id of an uploaded one"
            ))
            .at(pointer)
        })?;
        match self.store.mesh(id).await {
            Ok(row) => Ok(MeshSource::Uploaded(row.content_hash)),
            Err(StorageError::NotFound) => {
                Err(ApiError::not_found("there is no mesh with this id").at(pointer))
            }
            Err(error) => Err(error.into()),
        }
    }

    /// Returns an uploaded mesh by its content hash.
    ///
    /// # Errors
    /// [`ApiError`] if it does not exist or cannot be read.
    pub async fn uploaded_mesh(&self, hash: [u8; 32]) -> Result<Arc<Mesh>, ApiError> {
        let data = self.store.mesh_data(hash).await?;
        let read = run_blocking(move || decode_stored::<Mesh>(&data)).await?;
        let mesh = read
            .map_err(|error| ApiError::internal(format!("cannot read a stored mesh: {error}")))?;
        Ok(Arc::new(mesh))
    }

    /// Returns the mesh of a scene.
    ///
    /// # Errors
    /// [`ApiError`] if it cannot be read.
    pub async fn scene_mesh(&self, known: &KnownScene) -> Result<Arc<Mesh>, ApiError> {
        match (known.mesh, known.scene.builtin()) {
            (MeshSource::Uploaded(hash), _) => self.uploaded_mesh(hash).await,
            (MeshSource::Builtin, Some(name)) => Ok(Arc::new(Mesh::builtin(name))),
            (MeshSource::Builtin | MeshSource::Target, _) => {
                Err(ApiError::internal("a mesh has no data"))
            }
        }
    }

    /// Returns the frame of a view.
    ///
    /// # Errors
    /// [`ApiError`] if the scene does not exist or cannot be read.
    pub async fn frame(&self, view: Framing) -> Result<Arc<Framed>, ApiError> {
        let light = view.light_deg.map(f64::to_bits);
        let shape = (view.size_px, view.sampling, view.area);
        let key: FrameKey = (view.scene, light, shape, view.format, view.backend);
        let make = async {
            let known = self.scene(view.scene).await?;
            let light_deg = view.light_deg.unwrap_or(known.scene.light_deg);
            let scene = known.scene.with_light_deg(light_deg);
            let options = (view.format, view.backend);
            let frame = Frame::new(&scene, known.mesh, view.size_px, view.sampling, options);
            let frame = frame.with_objects(known.objects.clone()).with_area(view.area);
            let identity = frame.identity();
            let lights = scene.lights.len();
            Ok::<_, ApiError>(Arc::new(Framed { frame, identity, view, light_deg, lights }))
        };
        Ok(self.frames.try_get_with(key, make).await?)
    }
}

#[cfg(test)]
mod tests {
    use brood_genome::{BirthKey, Dialect, Variation};

    use super::*;

    #[test]
    fn genome_is_read_from_bytes_and_from_the_text_of_older_rows() {
        let birth = |seed| {
            Variation::random(Dialect::default()).birth(BirthKey { seed, slot: 0, attempt: 0 })
        };
        let (genome, other) = (birth(1), birth(2));
        for form in
            [StoredGenome::Bytes(genome.canonical_bytes()), StoredGenome::Text(genome.to_string())]
        {
            assert_eq!(read_genome(genome.hash(), &form).unwrap(), genome);
            assert!(read_genome(other.hash(), &form).is_err());
        }
        let broken = StoredGenome::Bytes(genome.canonical_bytes()[1..].to_vec());
        assert!(read_genome(genome.hash(), &broken).is_err());
    }
}
