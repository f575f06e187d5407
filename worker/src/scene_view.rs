//! Views of scenes: loaded meshes and light files with the scene, and what is sampled of them.

use std::sync::Arc;

use brood_eval::{LitBackdrop, texture_bumps};
use brood_light::LightAssets;
use brood_mesh::{BuiltinMesh, Mesh};
use brood_program::Program;
pub(crate) use brood_scene::Raster;
use brood_scene::{
    Film, LobeShape, MeshRef, PictureSize, PixelArea, PrefilteredLight, SampleSet, Sampling, Scene,
    SphereLayout, Stage,
};

/// Mesh with its content hash, which is computed once.
#[derive(Debug)]
pub struct LoadedMesh {
    mesh: Arc<Mesh>,
    hash: [u8; 32],
}

impl LoadedMesh {
    /// Hashes a mesh.
    #[must_use]
    pub fn new(mesh: impl Into<Arc<Mesh>>) -> Self {
        let mesh = mesh.into();
        let hash = mesh.content_hash();
        Self { mesh, hash }
    }

    /// Returns the mesh.
    #[must_use]
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// Returns a shared reference to the mesh.
    #[must_use]
    pub fn shared(&self) -> Arc<Mesh> {
        self.mesh.clone()
    }

    /// Returns the content hash.
    #[must_use]
    pub fn hash(&self) -> &[u8; 32] {
        &self.hash
    }
}

/// Light assets with their content hash, which is computed once.
#[derive(Debug)]
pub(crate) struct LoadedAssets {
    assets: LightAssets,
    hash: blake3::Hash,
}

impl LoadedAssets {
    pub(crate) fn new(assets: LightAssets) -> Self {
        let hash = assets.light_hash();
        Self { assets, hash }
    }

    /// As [`LoadedAssets::new`]. Hashing large environment maps takes longer than most pictures, so
    /// the hash of earlier assets with the same lights is kept.
    pub(crate) fn after(earlier: &Self, assets: LightAssets) -> Self {
        match assets.has_same_lights(&earlier.assets) {
            true => Self { assets, hash: earlier.hash },
            false => Self::new(assets),
        }
    }

    pub(crate) fn assets(&self) -> &LightAssets {
        &self.assets
    }
}

/// Scene, mesh and light assets with their common cache key.
#[derive(Clone)]
pub(crate) struct SceneView<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) stage: Stage<'a>,
    pub(crate) assets: &'a LightAssets,
    pub(crate) key: blake3::Hash,
}

impl<'a> SceneView<'a> {
    /// Returns the view of the subject alone.
    pub(crate) fn new(scene: &'a Scene, mesh: &'a LoadedMesh, loaded: &'a LoadedAssets) -> Self {
        Self::keyed(scene, (mesh.mesh().into(), &mesh.hash), &[], loaded)
    }

    /// Returns the view of the subject among other objects and the ground, whose meshes are given.
    pub(crate) fn among(
        scene: &'a Scene,
        mesh: &'a LoadedMesh,
        others: &'a [Arc<LoadedMesh>],
        loaded: &'a LoadedAssets,
    ) -> Self {
        let meshes: Vec<&Mesh> = others.iter().map(|other| other.mesh()).collect();
        let stage = Stage::new(scene, mesh.mesh(), &meshes);
        Self::keyed(scene, (stage, &mesh.hash), others, loaded)
    }

    /// The key ignores film, backdrop, materials and the names of meshes: sample sets do not depend
    /// on them.
    fn keyed(
        scene: &'a Scene,
        (stage, hash): (Stage<'a>, &[u8; 32]),
        others: &[Arc<LoadedMesh>],
        loaded: &'a LoadedAssets,
    ) -> Self {
        let mut plain = Scene {
            mesh: MeshRef::Builtin(BuiltinMesh::Sphere),
            film: Film::default(),
            backdrop: None,
            ..scene.clone()
        };
        for object in &mut plain.objects {
            (object.mesh, object.material) = (MeshRef::default(), None);
        }
        if let Some(ground) = &mut plain.ground {
            ground.material = None;
        }
        let json = serde_json::to_vec(&plain).expect("a scene is finite numbers and words");
        let mut hasher = blake3::Hasher::new();
        hasher.update(hash);
        hasher.update(&json);
        hasher.update(loaded.hash.as_bytes());
        for (map, _) in scene.normal_maps() {
            if let Some(image) = loaded.assets.image(&map.image) {
                hasher.update(image.content_hash().as_bytes());
            }
        }
        for other in others {
            hasher.update(&other.hash);
        }
        Self { scene, stage, assets: &loaded.assets, key: hasher.finalize() }
    }

    /// Number of parts: the subject, and the other objects if the view has them.
    pub(crate) fn parts(&self) -> usize {
        self.stage.count()
    }

    /// Returns the view of another part: 0 is the subject.
    pub(crate) fn with_part(&self, part: usize) -> Self {
        let mut hasher = blake3::Hasher::new();
        hasher.update(self.key.as_bytes()).update(b"part").update(&part.to_le_bytes());
        let (scene, assets) = (self.scene, self.assets);
        Self { scene, stage: self.stage.with_part(part), assets, key: hasher.finalize() }
    }

    /// Returns the view with clear parts: the share of light that passes through each.
    pub(crate) fn with_clear(&self, shares: &[f64]) -> Self {
        let stage = self.stage.with_clear(shares);
        if stage.clear() == self.stage.clear() {
            return self.clone();
        }
        let mut hasher = blake3::Hasher::new();
        hasher.update(self.key.as_bytes()).update(b"clear");
        for share in shares {
            hasher.update(&share.to_le_bytes());
        }
        Self { stage, key: hasher.finalize(), ..self.clone() }
    }

    /// Returns the view whose subject is as clear as a material; the other parts stay.
    pub(crate) fn with_subject(&self, program: &Program) -> Self {
        let mut shares = self.stage.clear().to_vec();
        shares.resize(self.parts(), 0.0);
        shares[0] = program.clearness();
        self.with_clear(&shares)
    }

    /// Returns the view whose part has the bumps of a material.
    pub(crate) fn with_bumps(&self, program: &Program) -> Self {
        let Some(bumps) = program.bumps() else { return self.clone() };
        let mut hasher = blake3::Hasher::new();
        hasher.update(self.key.as_bytes()).update(b"bumps");
        hasher.update(bumps.code().hash().as_bytes());
        hasher.update(&bumps.is_negative().map(u8::from));
        let stage = self.stage.clone().with_bumps(texture_bumps(program));
        Self { stage, key: hasher.finalize(), ..self.clone() }
    }

    pub(crate) fn scene(&self) -> &Scene {
        self.scene
    }

    /// Returns the same view of another scene, which differs in its lights.
    pub(crate) fn with_scene<'b>(&self, scene: &'b Scene) -> SceneView<'b>
    where
        'a: 'b,
    {
        let json = serde_json::to_vec(&scene.lights).expect("lights are finite numbers and words");
        let mut hasher = blake3::Hasher::new();
        hasher.update(self.key.as_bytes());
        hasher.update(&json);
        let (stage, assets) = (self.stage.clone(), self.assets);
        SceneView { scene, stage, assets, key: hasher.finalize() }
    }

    pub(crate) fn render(&self, raster: Raster) -> SampleSet {
        SampleSet::render_with_assets(self.stage.clone(), self.scene, self.assets, raster)
    }

    /// Samples a part of the picture with environments for `lobes`. Not cached: the sets are large.
    pub(crate) fn render_direct(&self, raster: Raster, lobes: LobeShape) -> SampleSet {
        SampleSet::render_direct(self.stage.clone(), self.scene, self.assets, raster, lobes)
    }

    /// Returns the backdrop and the tone curve as bytes for cache keys. The rays of clear bodies
    /// depend on both, sample sets on neither.
    pub(crate) fn seen_behind(&self) -> Vec<u8> {
        let seen = (&self.scene.backdrop, self.scene.film.tone);
        serde_json::to_vec(&seen).expect("backdrop and tone are finite numbers and words")
    }

    /// Returns the backdrop of an area of the picture.
    pub(crate) fn backdrop(&self, size_px: PictureSize, area: PixelArea) -> LitBackdrop {
        LitBackdrop::new((self.scene, self.stage.mesh(), self.assets), size_px, area)
    }

    pub(crate) fn render_prefiltered(&self, raster: Raster) -> (SampleSet, PrefilteredLight) {
        SampleSet::render_prefiltered(self.stage.clone(), self.scene, self.assets, raster)
    }

    /// Samples some pixels, columns and rows, of the whole picture. Not cached: the pixels depend
    /// on the material.
    pub(crate) fn render_pixels(
        &self,
        (size_px, samples): (PictureSize, u16),
        pixels: &[(u32, u32)],
        lobes: Option<LobeShape>,
    ) -> SampleSet {
        let (scene, stage, assets) = (self.scene, self.stage.clone(), self.assets);
        SampleSet::render_pixels(stage, scene, assets, (size_px, samples), pixels, lobes)
    }

    pub(crate) fn set_key(&self, raster: Raster) -> blake3::Hash {
        let Raster { size_px, sampling, area } = raster;
        // 0 is free to stand for adaptive sampling: a fixed number of samples is at least 1.
        let samples = match sampling {
            Sampling::Adaptive => 0,
            Sampling::Fixed(samples) => u32::from(samples),
        };
        let mut hasher = blake3::Hasher::new();
        hasher.update(self.key.as_bytes());
        let whole = [size_px.width, size_px.height];
        let part = [area.x, area.y, area.width, area.height];
        for number in whole.into_iter().chain([samples]).chain(part) {
            hasher.update(&number.to_le_bytes());
        }
        hasher.finalize()
    }

    pub(crate) fn points_key(&self, raster: Raster) -> blake3::Hash {
        let mut hasher = blake3::Hasher::new();
        hasher.update(self.set_key(raster).as_bytes()).update(b"points");
        hasher.finalize()
    }

    pub(crate) fn spheres_key(&self, layout: SphereLayout) -> blake3::Hash {
        let mut hasher = blake3::Hasher::new();
        hasher.update(self.key.as_bytes()).update(b"lit spheres");
        hasher.update(&layout.texels.to_le_bytes()).update(&layout.turns.to_le_bytes());
        hasher.finalize()
    }
}
