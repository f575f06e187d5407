//! Query of a comparison: materials, scene and size.

use std::sync::Arc;

use brood_genome::GenomeHash;
use brood_inspect::{COMPARED, Specimen};
use brood_protocol::{ParentRef, PictureFormat, RENDERER_VERSION, SceneId};
use brood_scene::Scene;
use brood_storage::StorageError;
use serde::Deserialize;

use crate::controller::picture_query::SIZE;
use crate::controller::scene;
use crate::library::{Framing, Material};
use crate::limit;
use crate::problem::{ApiError, quote};
use crate::state::App;

/// Materials to compare and how to show them.
#[derive(Debug, Clone, Deserialize, utoipa::IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct ComparisonQuery {
    /// Two to six individuals by id or genomes by hash, separated by commas. The first is the
    /// reference.
    materials: String,
    /// Scene to render; default: that of the first individual's lineage, or the default scene if
    /// only genomes are named.
    scene: Option<SceneId>,
    /// Side of the pictures in pixels, 16 to 1024; default 256.
    #[param(minimum = 16, maximum = 1024)]
    size: Option<u32>,
}

/// Parsed and resolved query.
pub struct ComparisonRequest {
    /// Materials in their order.
    pub materials: Vec<RequestedMaterial>,
    /// Scene of the pictures.
    pub scene: SceneId,
    /// Side of the pictures in pixels.
    pub size_px: u32,
}

/// Material of a comparison.
pub struct RequestedMaterial {
    /// Name in the query.
    pub named: ParentRef,
    /// Content hash of the genome.
    pub hash: GenomeHash,
    /// Genome and program.
    pub material: Arc<Material>,
}

impl ComparisonRequest {
    /// Resolves a query.
    ///
    /// # Errors
    /// [`ApiError`] if a parameter is invalid, or a material or the scene does not exist.
    pub async fn find(app: &App, query: ComparisonQuery) -> Result<Self, ApiError> {
        let size_px = limit::side(query.size.unwrap_or(SIZE), limit::THUMBNAIL_PX)?;
        let count = query.materials.split(',').count();
        if !COMPARED.contains(&count) {
            let words =
                format!("must be {} to {} items, got {count}", COMPARED.start(), COMPARED.end());
            return Err(ApiError::bad_parameter("materials", words));
        }
        let mut materials = Vec::with_capacity(count);
        let mut lineage = None;
        for text in query.materials.split(',').map(str::trim) {
            let named = text.parse().map_err(|_| {
                let words =
                    format!("{} is neither an individual's id nor a genome hash", quote(text));
                ApiError::bad_parameter("materials", words)
            })?;
            let missing = |error: StorageError| match error {
                StorageError::NotFound => {
                    ApiError::not_found(format!("there is no individual or genome {}", quote(text)))
                }
                other => other.into(),
            };
            let hash = match named {
                ParentRef::Genome(hash) => {
                    app.store.genome(hash).await.map_err(missing)?;
                    hash
                }
                ParentRef::Individual(id) => {
                    let individual = app.store.individual(id).await.map_err(missing)?;
                    lineage = lineage.or(Some(individual.lineage));
                    individual.hash
                }
            };
            materials.push(RequestedMaterial {
                named,
                hash,
                material: app.library.brdf(hash).await?,
            });
        }
        let scene = match (query.scene, lineage) {
            (Some(scene), _) => scene,
            (None, Some(lineage)) => app.store.lineage(lineage).await?.scene,
            (None, None) => scene::store(app, &Scene::default()).await?,
        };
        // Fails early if the scene does not exist.
        app.library.scene(scene).await?;
        Ok(Self { materials, scene, size_px })
    }

    /// Returns an ETag of everything that the answer depends on.
    pub fn etag(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        hasher.update(env!("CARGO_PKG_VERSION").as_bytes());
        hasher.update(&RENDERER_VERSION.to_le_bytes()).update(&self.size_px.to_le_bytes());
        hasher.update(self.scene.as_bytes());
        for one in &self.materials {
            hasher.update(one.named.to_string().as_bytes()).update(one.hash.as_bytes());
        }
        format!("\"{}\"", hasher.finalize().to_hex())
    }

    /// Returns the first material, the reference.
    pub fn first(&self) -> Arc<Material> {
        self.materials[0].material.clone()
    }

    /// Returns the framing of the pictures in a scene.
    pub fn view(&self, app: &App, scene: SceneId, format: PictureFormat) -> Framing {
        Framing { format, ..Framing::png(scene, self.size_px, app.backend) }
    }
}

/// Returns a material for comparing it.
pub fn specimen(material: &Material) -> Specimen<'_> {
    Specimen::Bred(&material.genome, &material.program)
}
