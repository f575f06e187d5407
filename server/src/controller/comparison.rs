//! Comparisons: materials in one scene at one exposure, how far each is from the first, and their optics in curves and numbers.
//!
//! Workers render the pictures; here they are only held against each other.

mod picture;

use std::sync::Arc;

use axum::extract::State;
use axum::response::Response;
use brood_eval::encode_png;
use brood_genome::GenomeHash;
use brood_inspect::{COMPARED, CurvePoint, OTHER_LIGHT_DEG, Phenomena, Specimen, curves};
use brood_protocol::{ParentRef, PictureFormat, RENDERER_VERSION, SceneId};
use brood_scene::Scene;
use brood_storage::StorageError;
use http::HeaderMap;
use serde::{Deserialize, Serialize};

use self::picture::{exposed, linear, row};
use super::file::FileHead;
use crate::extract::Query;
use crate::library::{Material, Optics, View};
use crate::limit;
use crate::presenter::thumbnail_url;
use crate::problem::{ApiError, quote};
use crate::state::App;

/// A genome never changes; the lineage's scene and the version of the program do.
const CACHE: &str = "private, no-cache";
const SIZE: u32 = 256;

/// What is compared, and how it is shown.
#[derive(Debug, Clone, Deserialize, utoipa::IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct ComparisonQuery {
    /// Two to six individuals by id or genomes by hash, with commas between them; the others are held against the first.
    materials: String,
    /// The scene; unless asked otherwise that of the first individual's lineage, or the default one where only genomes are named.
    scene: Option<SceneId>,
    /// Side of the pictures in pixels, 16 to 1024; 256 unless asked otherwise.
    #[param(minimum = 16, maximum = 1024)]
    size: Option<u32>,
}

/// Materials side by side.
#[derive(Debug, Clone, Serialize, utoipa::ToSchema)]
pub struct Comparison {
    /// The scene of the pictures: the one asked for, with the exposure fixed.
    scene: SceneId,
    /// One exposure for all: the scene's, or the automatic one of the first material.
    exposure_ev: f64,
    /// Side of the pictures.
    size_px: u32,
    /// How much further along its circle the other light is, in degrees.
    other_light_deg: f64,
    /// In the order asked for.
    materials: Vec<Compared>,
}

/// One of them.
#[derive(Debug, Clone, Serialize, utoipa::ToSchema)]
pub struct Compared {
    /// As it was asked for.
    material: ParentRef,
    /// Content hash of its genome.
    hash: String,
    /// Names of its models.
    layers: Vec<String>,
    /// Where its picture is.
    picture: String,
    /// Where its picture under another light is.
    other_light: String,
    /// How far it is from the first; null for the first itself.
    difference: Option<Difference>,
    /// Directional albedo and the mirror direction over the angle of incidence.
    curves: Vec<CurvePoint>,
    /// In numbers.
    phenomena: Phenomena,
}

/// How far a picture is from the first.
#[derive(Debug, Clone, Serialize, utoipa::ToSchema)]
pub struct Difference {
    /// Where the absolute difference of linear values as exposed is shown.
    picture: String,
    /// Root mean square of the same.
    rmse: f64,
    /// Mean FLIP error of the developed pictures.
    flip: f64,
}

/// What was asked for, found.
struct Wanted {
    materials: Vec<One>,
    scene: SceneId,
    size_px: u32,
}

struct One {
    named: ParentRef,
    hash: GenomeHash,
    material: Arc<Material>,
}

/// Two to six materials side by side.
#[utoipa::path(get, path = "/v1/comparison", tag = "individuals", params(ComparisonQuery),
    responses((status = 200, body = Comparison), (status = 304, description = "unchanged")))]
pub async fn get(
    State(app): State<App>,
    Query(query): Query<ComparisonQuery>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let wanted = find(&app, query).await?;
    let etag = wanted.etag();
    let head = FileHead { etag, content_type: "application/json", cache: CACHE };
    let make = async {
        let compared = limit::in_time(compare(&app, wanted)).await?;
        Ok(serde_json::to_vec(&compared).expect("a comparison is plain data"))
    };
    head.made(&headers, make).await
}

/// The absolute difference of two materials' pictures, of linear values as exposed.
#[utoipa::path(get, path = "/v1/comparison/difference.png", tag = "pictures", params(ComparisonQuery),
    responses((status = 200, content_type = "image/png"), (status = 304, description = "unchanged")))]
pub async fn difference(
    State(app): State<App>,
    Query(query): Query<ComparisonQuery>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let wanted = find(&app, query).await?;
    if wanted.materials.len() != 2 {
        return Err(ApiError::bad_parameter("materials", "a difference is of two"));
    }
    let etag = wanted.etag();
    let head = FileHead { etag, content_type: "image/png", cache: CACHE };
    let make = async {
        let exposed = exposed(&app, &wanted).await?;
        let mut pictures = limit::in_time(linear(&app, &wanted, exposed)).await?;
        let (second, first) = (pictures.pop(), pictures.pop());
        let draw = move || {
            let apart = first.zip(second).map(|(first, second)| first.absolute_difference(&second));
            let apart = apart.expect("there are two pictures");
            let (width, height) = apart.size();
            encode_png(width, height, &apart.encoded_rgba())
        };
        app.on_processor(draw).await
    };
    head.made(&headers, make).await
}

async fn find(app: &App, query: ComparisonQuery) -> Result<Wanted, ApiError> {
    let size_px = limit::side(query.size.unwrap_or(SIZE), limit::THUMBNAIL_PX)?;
    let count = query.materials.split(',').count();
    if !COMPARED.contains(&count) {
        let words = format!("{} to {}, not {count}", COMPARED.start(), COMPARED.end());
        return Err(ApiError::bad_parameter("materials", words));
    }
    let mut materials = Vec::with_capacity(count);
    let mut lineage = None;
    for text in query.materials.split(',').map(str::trim) {
        let named = text.parse().map_err(|_| {
            let words = format!("{} is neither an id nor the hash of a genome", quote(text));
            ApiError::bad_parameter("materials", words)
        })?;
        let missing = |error: StorageError| match error {
            StorageError::NotFound => {
                ApiError::not_found(format!("there is no material {}", quote(text)))
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
        materials.push(One { named, hash, material: app.library.material(hash).await? });
    }
    let scene = match (query.scene, lineage) {
        (Some(scene), _) => scene,
        (None, Some(lineage)) => app.store.lineage(lineage).await?.scene,
        (None, None) => super::scene::store(app, &Scene::default()).await?,
    };
    // Refuses one that is not there, before anything is computed.
    app.library.scene(scene).await?;
    Ok(Wanted { materials, scene, size_px })
}

impl Wanted {
    /// Of everything that the answer depends on.
    fn etag(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        hasher.update(env!("CARGO_PKG_VERSION").as_bytes());
        hasher.update(&RENDERER_VERSION.to_le_bytes()).update(&self.size_px.to_le_bytes());
        hasher.update(self.scene.as_bytes());
        for one in &self.materials {
            hasher.update(one.named.to_string().as_bytes()).update(one.hash.as_bytes());
        }
        format!("\"{}\"", hasher.finalize().to_hex())
    }

    fn first(&self) -> Arc<Material> {
        self.materials[0].material.clone()
    }
}

fn specimen(material: &Material) -> Specimen<'_> {
    Specimen::Bred(&material.genome, &material.program)
}

async fn compare(app: &App, wanted: Wanted) -> Result<Comparison, ApiError> {
    let (scene, exposure_ev) = exposed(app, &wanted).await?;
    let pictures = linear(app, &wanted, (scene, exposure_ev)).await?;
    let apart = move || -> Vec<(f64, f64)> {
        let (first, others) = pictures.split_first().expect("there are two at least");
        others.iter().map(|other| (first.rmse(other), first.flip(other))).collect()
    };
    let mut apart = app.on_processor(apart).await?.into_iter();
    let first = wanted.materials[0].hash;
    let light_deg = app.library.scene(scene).await?.scene.light_deg;
    let mut materials = Vec::with_capacity(wanted.materials.len());
    for (index, one) in wanted.materials.iter().enumerate() {
        let optics = optics(app, one, wanted.scene).await?;
        let view = wanted.view(app, scene, PictureFormat::Png);
        let other = View { light_deg: Some(light_deg + OTHER_LIGHT_DEG), ..view };
        let difference = (index > 0).then(|| apart.next()).flatten();
        let (hash, size) = (one.hash, wanted.size_px);
        materials.push(Compared {
            material: one.named,
            hash: hash.to_string(),
            layers: one.material.genome.layers().iter().map(|it| it.kind().name().into()).collect(),
            picture: thumbnail_url(row(app, one, view).await?.key),
            other_light: thumbnail_url(row(app, one, other).await?.key),
            difference: difference.map(|(rmse, flip)| Difference {
                picture: format!(
                    "/v1/comparison/difference.png?materials={first},{hash}&scene={scene}&size={size}"
                ),
                rmse,
                flip,
            }),
            curves: optics.curves.clone(),
            phenomena: optics.phenomena.clone(),
        });
    }
    let (size_px, other_light_deg) = (wanted.size_px, OTHER_LIGHT_DEG);
    Ok(Comparison { scene, exposure_ev, size_px, other_light_deg, materials })
}

async fn optics(app: &App, one: &One, scene: SceneId) -> Result<Arc<Optics>, ApiError> {
    let circle = app.library.circle(scene).await?;
    let (key, material, app2) = ((one.hash, scene), one.material.clone(), app.clone());
    let look = move || {
        app2.library.optics(key, || {
            let specimen = specimen(&material);
            let curves = curves(&specimen);
            let phenomena = Phenomena::of(&specimen, &curves, &circle);
            Optics { curves, phenomena }
        })
    };
    app.on_processor(look).await
}
