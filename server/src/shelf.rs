//! Targets at hand: their files as they were read, their pictures, and what was drawn of them.
//!
//! Measured materials and pictures of known scenes are no programs, so no worker draws them: the few pictures that are wanted of them are drawn
//! here, on the processors that broods are made on. Everything is derived, bounded and may be thrown away; what is read or drawn when nobody
//! waits for it any more is kept all the same. It refuses to know addresses and queries.

use std::sync::Arc;

use brood_brdf::Brdf;
use brood_eval::{encode_exr, encode_png};
use brood_inspect::{Picture, Shade, Shot};
use brood_protocol::{PictureFormat, SceneId, Target};
use brood_scene::{Exposure, LightAssets, Mesh, SampleSet, Sampling, Scene};
use brood_search::{KnownView, MeasuredFile, PictureBundle, TargetKind};
use bytes::Bytes;
use moka::sync::Cache;
use tokio::sync::{Semaphore, SemaphorePermit};

use crate::lighting;
use crate::limit;
use crate::problem::ApiError;
use crate::state::App;

/// Targets that are read at once: reading takes several times a file's memory.
pub const DESKS: u32 = 2;
static READING: Semaphore = Semaphore::const_new(DESKS as usize);

/// What is kept, in KiB: files as they were read, what cameras see, pictures.
const VOLUMES_KIB: u64 = 160 << 10;
const VIEWS_KIB: u64 = 192 << 10;
const STAGES_KIB: u64 = 96 << 10;
const PICTURES_KIB: u64 = 32 << 10;

async fn desk(desks: u32) -> Result<SemaphorePermit<'static>, ApiError> {
    READING.acquire_many(desks).await.map_err(|error| ApiError::internal(error.to_string()))
}

/// Reads a target where so many of the [`DESKS`] are free; who is not waited for any more is not read.
pub async fn at_desk<T: Send + 'static>(
    desks: u32,
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<T, ApiError> {
    sit(desk(desks).await?, work).await
}

async fn sit<T: Send + 'static>(
    desk: SemaphorePermit<'static>,
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<T, ApiError> {
    let done = tokio::task::spawn_blocking(move || {
        let result = work();
        drop(desk);
        result
    });
    done.await.map_err(|error| ApiError::internal(error.to_string()))
}

/// A target's file, read.
pub enum Volume {
    /// What was measured at directions.
    Measured(Box<dyn Brdf>),
    /// Pictures, yet encoded, and what the lights of their scenes refer to.
    Pictures(PictureBundle, LightAssets),
}

/// What a camera sees of a scene.
pub struct Stage {
    scene: Scene,
    mesh: Arc<Mesh>,
    assets: LightAssets,
    size_px: u32,
    sampling: Sampling,
    set: SampleSet,
}

/// Which one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StageView {
    /// The scene.
    pub scene: SceneId,
    /// Position on the light circle; where the scene has it if absent.
    pub light_deg: Option<f64>,
    /// Side in pixels.
    pub size_px: u32,
    /// Samples per pixel.
    pub sampling: Sampling,
}

type StageKey = (SceneId, Option<u64>, u32, Sampling);

/// A picture in its file's form, and how it was exposed.
#[derive(Debug, Clone)]
pub struct Drawn {
    /// The file.
    pub bytes: Bytes,
    /// The exposure.
    pub exposure_ev: f64,
}

impl Stage {
    /// A material there; at another exposure than the scene's where one is given.
    pub fn take(&self, material: &(impl Shade + ?Sized), exposure_ev: Option<f64>) -> Picture {
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
    /// Of a picture.
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

/// What is kept of targets.
pub struct Shelf {
    volumes: Cache<[u8; 32], (Arc<Volume>, u32)>,
    views: Cache<([u8; 32], u32), Arc<KnownView>>,
    stages: Cache<StageKey, Arc<Stage>>,
    pictures: Cache<blake3::Hash, Drawn>,
}

impl Default for Shelf {
    fn default() -> Self {
        let volume = |_: &_, volume: &(Arc<Volume>, u32)| volume.1;
        let view = |_: &_, view: &Arc<KnownView>| kib(view.bytes());
        let stage = |_: &_, stage: &Arc<Stage>| kib(stage.set.bytes());
        let picture = |_: &_, drawn: &Drawn| kib(drawn.bytes.len());
        Self {
            volumes: Cache::builder().max_capacity(VOLUMES_KIB).weigher(volume).build(),
            views: Cache::builder().max_capacity(VIEWS_KIB).weigher(view).build(),
            stages: Cache::builder().max_capacity(STAGES_KIB).weigher(stage).build(),
            pictures: Cache::builder().max_capacity(PICTURES_KIB).weigher(picture).build(),
        }
    }
}

impl Shelf {
    /// The file of a target, read.
    pub async fn volume(app: &App, target: &Target) -> Result<Arc<Volume>, ApiError> {
        let hash = hash(target)?;
        if let Some((volume, _)) = app.shelf.volumes.get(&hash) {
            return Ok(volume);
        }
        let desk = desk(1).await?;
        // Who had the desk before may have read it.
        if let Some((volume, _)) = app.shelf.volumes.get(&hash) {
            return Ok(volume);
        }
        let kind: TargetKind = target.kind.parse().map_err(unreadable)?;
        let bytes = app.store.target_file(hash).await?;
        let own = app.clone();
        let read = move || -> Result<Arc<Volume>, ApiError> {
            let volume = Arc::new(match kind {
                TargetKind::Image => {
                    let bundle = PictureBundle::decode(&bytes).map_err(unreadable)?;
                    let assets = bundle.assets().map_err(unreadable)?;
                    Volume::Pictures(bundle, assets)
                }
                _ => Volume::Measured(MeasuredFile::read(kind, &bytes).map_err(unreadable)?.brdf),
            });
            own.shelf.volumes.insert(hash, (volume.clone(), kib(bytes.len())));
            Ok(volume)
        };
        sit(desk, read).await?
    }

    /// A picture of a target, with what its pixels say.
    pub async fn view(app: &App, target: &Target, n: u32) -> Result<Arc<KnownView>, ApiError> {
        let key = (hash(target)?, n);
        if let Some(view) = app.shelf.views.get(&key) {
            return Ok(view);
        }
        let volume = Self::volume(app, target).await?;
        let desk = desk(1).await?;
        if let Some(view) = app.shelf.views.get(&key) {
            return Ok(view);
        }
        let own = app.clone();
        let read = move || -> Result<Arc<KnownView>, ApiError> {
            let Volume::Pictures(bundle, assets) = &*volume else {
                return Err(ApiError::internal("a target has no pictures"));
            };
            let index = usize::try_from(n).unwrap_or(usize::MAX);
            let view = bundle.views.get(index).ok_or_else(|| {
                ApiError::internal("a target's file has fewer pictures than it is said to have")
            })?;
            let (view, _) = view.read(assets).map_err(unreadable)?;
            let view = Arc::new(view);
            own.shelf.views.insert(key, view.clone());
            Ok(view)
        };
        sit(desk, read).await?
    }

    /// What a camera sees of a scene.
    pub async fn stage(app: &App, view: StageView) -> Result<Arc<Stage>, ApiError> {
        let StageView { scene, light_deg, size_px, sampling } = view;
        let key: StageKey = (scene, light_deg.map(f64::to_bits), size_px, sampling);
        if let Some(stage) = app.shelf.stages.get(&key) {
            return Ok(stage);
        }
        let known = app.library.scene(scene).await?;
        let mesh = app.library.shown(&known).await?;
        let assets = lighting::load(&app.store, &known.scene).await?;
        let scene = known.scene.with_light_deg(light_deg.unwrap_or(known.scene.light_deg));
        let own = app.clone();
        let trace = move || {
            if let Some(stage) = own.shelf.stages.get(&key) {
                return stage;
            }
            let shot = Shot { mesh: &mesh, scene: &scene, assets: &assets, size_px, sampling };
            let set = shot.set();
            let stage = Arc::new(Stage { scene, mesh, assets, size_px, sampling, set });
            own.shelf.stages.insert(key, stage.clone());
            stage
        };
        app.on_processor(trace).await
    }

    /// A picture by its key; where it is not at hand, what draws it is prepared and drawing waited for, a bounded time.
    pub async fn drawn<Draw>(
        app: &App,
        key: blake3::Hash,
        prepare: impl Future<Output = Result<Draw, ApiError>>,
    ) -> Result<Drawn, ApiError>
    where
        Draw: FnOnce() -> Result<Drawn, ApiError> + Send + 'static,
    {
        if let Some(drawn) = app.shelf.pictures.get(&key) {
            return Ok(drawn);
        }
        let draw = prepare.await?;
        let own = app.clone();
        let work = app.on_processor(move || {
            // Who had the processor before may have drawn it.
            if let Some(drawn) = own.shelf.pictures.get(&key) {
                return Ok(drawn);
            }
            let drawn = draw()?;
            own.shelf.pictures.insert(key, drawn.clone());
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
    ApiError::internal(format!("a stored target cannot be read: {error}"))
}

fn kib(bytes: usize) -> u32 {
    u32::try_from(bytes / 1024 + 1).unwrap_or(u32::MAX)
}
