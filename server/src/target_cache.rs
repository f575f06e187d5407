//! Cache of search targets: parsed files, pictures, traced views, and drawn pictures.
//!
//! Measured materials and pictures of known scenes are not programs, so workers cannot render them;
//! the server draws the few that are needed, on the processors for broods. Everything is derived,
//! bounded and can be recomputed. Results are cached even if the request that asked for them is
//! cancelled. Independent of URLs and queries.

use std::sync::Arc;

use brood_brdf::Brdf;
use brood_eval::{encode_exr, encode_png};
use brood_inspect::{Picture, Shade, Shot};
use brood_light::LightAssets;
use brood_mesh::Mesh;
use brood_protocol::{PictureFormat, SceneId, Target};
use brood_scene::{Exposure, SampleSet, Sampling, Scene};
use brood_target::{KnownView, MeasuredFile, PictureBundle, TargetKind};
use bytes::Bytes;
use moka::sync::Cache;
use tokio::sync::{Semaphore, SemaphorePermit};

use crate::lighting;
use crate::limit;
use crate::problem::ApiError;
use crate::state::App;

/// Number of targets parsed at a time: parsing takes several times the file's memory.
pub const READ_PERMITS: u32 = 2;
static READING: Semaphore = Semaphore::const_new(READ_PERMITS as usize);

/// Capacities in KiB: parsed files, pictures, traced views, drawn pictures.
const LOADED_KIB: u64 = 160 << 10;
const VIEWS_KIB: u64 = 192 << 10;
const TRACED_KIB: u64 = 96 << 10;
const PICTURES_KIB: u64 = 32 << 10;

async fn read_permit(permits: u32) -> Result<SemaphorePermit<'static>, ApiError> {
    READING.acquire_many(permits).await.map_err(|error| ApiError::internal(error.to_string()))
}

/// Runs `work`, which parses a target, on a blocking thread under `permits` of the
/// [`READ_PERMITS`]. A cancelled request releases its place in the queue.
///
/// # Errors
/// 500 if `work` panics.
pub async fn read_blocking<T: Send + 'static>(
    permits: u32,
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<T, ApiError> {
    run_with_permit(read_permit(permits).await?, work).await
}

async fn run_with_permit<T: Send + 'static>(
    permit: SemaphorePermit<'static>,
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<T, ApiError> {
    let done = tokio::task::spawn_blocking(move || {
        let result = work();
        drop(permit);
        result
    });
    done.await.map_err(|error| ApiError::internal(error.to_string()))
}

/// Parsed file of a target.
pub enum LoadedTarget {
    /// Measured BRDF.
    Measured(Box<dyn Brdf>),
    /// Encoded pictures, and the files of their scenes' lights.
    Pictures(PictureBundle, LightAssets),
}

/// Scene traced from the camera, ready to shade any material.
pub struct TracedView {
    scene: Scene,
    mesh: Arc<Mesh>,
    assets: LightAssets,
    size_px: u32,
    sampling: Sampling,
    set: SampleSet,
}

/// Parameters of a traced view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ViewParams {
    /// Scene.
    pub scene: SceneId,
    /// Light angle in degrees; the scene's if absent.
    pub light_deg: Option<f64>,
    /// Side in pixels.
    pub size_px: u32,
    /// Samples per pixel.
    pub sampling: Sampling,
}

type ViewKey = (SceneId, Option<u64>, u32, Sampling);

/// Encoded picture and its exposure.
#[derive(Debug, Clone)]
pub struct Drawn {
    /// Contents of the file.
    pub bytes: Bytes,
    /// Exposure in EV.
    pub exposure_ev: f64,
}

impl TracedView {
    /// Renders a material, at `exposure_ev` if given, else at the scene's exposure.
    pub fn render(&self, material: &(impl Shade + ?Sized), exposure_ev: Option<f64>) -> Picture {
        let mut scene = self.scene.clone();
        if let Some(ev) = exposure_ev {
            scene.film.exposure = Exposure::Ev(ev);
        }
        let shot = Shot {
            mesh: &self.mesh,
            scene: &scene,
            assets: &self.assets,
            size_px: self.size_px,
            sampling: self.sampling,
        };
        shot.take_on(&self.set, material)
    }
}

impl Drawn {
    /// Encodes a picture.
    ///
    /// # Errors
    /// 500 if encoding fails.
    pub fn of(picture: &Picture, format: PictureFormat) -> Result<Self, ApiError> {
        let developed = &picture.developed;
        let bytes = match format {
            PictureFormat::Png => encode_png(developed.width, developed.height, &developed.rgba),
            PictureFormat::Exr => encode_exr(&picture.radiance)
                .map_err(|error| ApiError::internal(error.to_string()))?,
        };
        Ok(Self { bytes: bytes.into(), exposure_ev: developed.exposure_ev })
    }
}

impl From<Drawn> for Bytes {
    fn from(drawn: Drawn) -> Self {
        drawn.bytes
    }
}

/// Caches of targets.
pub struct TargetCache {
    loaded: Cache<[u8; 32], (Arc<LoadedTarget>, u32)>,
    views: Cache<([u8; 32], u32), Arc<KnownView>>,
    traced: Cache<ViewKey, Arc<TracedView>>,
    pictures: Cache<blake3::Hash, Drawn>,
}

impl Default for TargetCache {
    fn default() -> Self {
        let loaded = |_: &_, loaded: &(Arc<LoadedTarget>, u32)| loaded.1;
        let view = |_: &_, view: &Arc<KnownView>| kib(view.bytes());
        let traced = |_: &_, traced: &Arc<TracedView>| kib(traced.set.bytes());
        let picture = |_: &_, drawn: &Drawn| kib(drawn.bytes.len());
        Self {
            loaded: Cache::builder().max_capacity(LOADED_KIB).weigher(loaded).build(),
            views: Cache::builder().max_capacity(VIEWS_KIB).weigher(view).build(),
            traced: Cache::builder().max_capacity(TRACED_KIB).weigher(traced).build(),
            pictures: Cache::builder().max_capacity(PICTURES_KIB).weigher(picture).build(),
        }
    }
}

impl TargetCache {
    /// Returns the parsed file of a target.
    ///
    /// # Errors
    /// 500 if the file cannot be read.
    pub async fn load(app: &App, target: &Target) -> Result<Arc<LoadedTarget>, ApiError> {
        let hash = hash(target)?;
        if let Some((loaded, _)) = app.target_cache.loaded.get(&hash) {
            return Ok(loaded);
        }
        let permit = read_permit(1).await?;
        // Checked again: the previous holder of the permit may have read it.
        if let Some((loaded, _)) = app.target_cache.loaded.get(&hash) {
            return Ok(loaded);
        }
        let kind: TargetKind = target.kind.parse().map_err(unreadable)?;
        let bytes = app.store.target_file(hash).await?;
        let own = app.clone();
        let read = move || -> Result<Arc<LoadedTarget>, ApiError> {
            let loaded = Arc::new(match kind {
                TargetKind::Image => {
                    let bundle = PictureBundle::decode(&bytes).map_err(unreadable)?;
                    let assets = bundle.assets().map_err(unreadable)?;
                    LoadedTarget::Pictures(bundle, assets)
                }
                _ => LoadedTarget::Measured(
                    MeasuredFile::read(kind, &bytes).map_err(unreadable)?.brdf,
                ),
            });
            own.target_cache.loaded.insert(hash, (loaded.clone(), kib(bytes.len())));
            Ok(loaded)
        };
        run_with_permit(permit, read).await?
    }

    /// Returns a decoded picture of a target with the statuses of its pixels.
    ///
    /// # Errors
    /// 500 if the file cannot be read or has no such picture.
    pub async fn view(app: &App, target: &Target, n: u32) -> Result<Arc<KnownView>, ApiError> {
        let key = (hash(target)?, n);
        if let Some(view) = app.target_cache.views.get(&key) {
            return Ok(view);
        }
        let loaded = Self::load(app, target).await?;
        let permit = read_permit(1).await?;
        if let Some(view) = app.target_cache.views.get(&key) {
            return Ok(view);
        }
        let own = app.clone();
        let read = move || -> Result<Arc<KnownView>, ApiError> {
            let LoadedTarget::Pictures(bundle, assets) = &*loaded else {
                return Err(ApiError::internal("a measured target has no pictures"));
            };
            let index = usize::try_from(n).unwrap_or(usize::MAX);
            let view = bundle.views.get(index).ok_or_else(|| {
                ApiError::internal("a target's file has fewer pictures than its row")
            })?;
            let (view, _) = view.read(assets).map_err(unreadable)?;
            let view = Arc::new(view);
            own.target_cache.views.insert(key, view.clone());
            Ok(view)
        };
        run_with_permit(permit, read).await?
    }

    /// Returns a scene traced from its camera.
    ///
    /// # Errors
    /// [`ApiError`] if the scene cannot be read or the server is busy.
    pub async fn traced_view(app: &App, view: ViewParams) -> Result<Arc<TracedView>, ApiError> {
        let ViewParams { scene, light_deg, size_px, sampling } = view;
        let key: ViewKey = (scene, light_deg.map(f64::to_bits), size_px, sampling);
        if let Some(traced) = app.target_cache.traced.get(&key) {
            return Ok(traced);
        }
        let known = app.library.scene(scene).await?;
        let mesh = app.library.scene_mesh(&known).await?;
        let assets = lighting::load(&app.store, &known.scene).await?;
        let scene = known.scene.with_light_deg(light_deg.unwrap_or(known.scene.light_deg));
        let own = app.clone();
        let trace = move || {
            if let Some(traced) = own.target_cache.traced.get(&key) {
                return traced;
            }
            let shot = Shot { mesh: &mesh, scene: &scene, assets: &assets, size_px, sampling };
            let set = shot.set();
            let traced = Arc::new(TracedView { scene, mesh, assets, size_px, sampling, set });
            own.target_cache.traced.insert(key, traced.clone());
            traced
        };
        app.on_processor(trace).await
    }

    /// Returns a picture by its key, prepared and drawn if not cached; waits at most
    /// [`limit::WAIT`].
    ///
    /// # Errors
    /// 503 if the server is busy or too slow; else the errors of `prepare` and of drawing.
    pub async fn picture<Draw>(
        app: &App,
        key: blake3::Hash,
        prepare: impl Future<Output = Result<Draw, ApiError>>,
    ) -> Result<Drawn, ApiError>
    where
        Draw: FnOnce() -> Result<Drawn, ApiError> + Send + 'static,
    {
        if let Some(drawn) = app.target_cache.pictures.get(&key) {
            return Ok(drawn);
        }
        let draw = prepare.await?;
        let own = app.clone();
        let work = app.on_processor(move || {
            // Checked again: another request may have drawn it.
            if let Some(drawn) = own.target_cache.pictures.get(&key) {
                return Ok(drawn);
            }
            let drawn = draw()?;
            own.target_cache.pictures.insert(key, drawn.clone());
            Ok(drawn)
        });
        limit::in_time(work).await?
    }
}

fn hash(target: &Target) -> Result<[u8; 32], ApiError> {
    let hash = blake3::Hash::from_hex(&target.hash);
    hash.map(|hash| *hash.as_bytes()).map_err(unreadable)
}

fn unreadable(error: impl std::fmt::Display) -> ApiError {
    ApiError::internal(format!("cannot read a stored target: {error}"))
}

fn kib(bytes: usize) -> u32 {
    u32::try_from(bytes / 1024 + 1).unwrap_or(u32::MAX)
}
