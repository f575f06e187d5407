//! A leased render job from grant to results: downloads, rendering, heartbeats, submission.

use std::sync::Arc;
use std::time::Duration;

use brood_light::{AssetRef, LightAssets};
use brood_protocol::{
    ClientError, JobId, LeaseGrant, LeaseRenewal, LeaseRequest, LeaseResults, LeaseTicket,
    LightAssetFile, MeshSource, Queue, RENDERER_VERSION, RenderJob, RenderOutcome, TargetSource,
    WorkerClient,
};
use brood_target::TargetKind;
use tokio::sync::{mpsc, oneshot};
use tokio_util::sync::CancellationToken;

use crate::error::RenderError;
use crate::job_control::JobControl;
use crate::lease::{
    Interrupted, JobKind, RetryPolicy, leave_to_others, renew_lease, send_with_retry,
};
use crate::light_asset_cache::LightAssetCache;
use crate::render_thread::RenderRequest;
use crate::renderer::Renderer;
use crate::scene_view::LoadedMesh;
use crate::target_cache::LoadedTarget;

/// Resources that a worker shares among its render jobs.
#[derive(Clone)]
pub(crate) struct RenderContext {
    pub(crate) client: WorkerClient,
    pub(crate) queue: Queue,
    pub(crate) renderer: Arc<Renderer>,
    pub(crate) requests: mpsc::Sender<RenderRequest>,
    pub(crate) asset_cache: LightAssetCache,
    pub(crate) shutdown: CancellationToken,
}

impl JobKind for RenderContext {
    /// Short, because a job may be long and no longer wanted.
    const HEARTBEAT: Duration = Duration::from_millis(500);
    type Request = LeaseRequest;
    type Ticket = LeaseTicket;

    fn at(self, client: WorkerClient) -> Self {
        Self { client, ..self }
    }

    fn name(&self) -> &'static str {
        match self.queue {
            Queue::Interactive => "render",
            Queue::Batch => "batch render",
        }
    }

    /// One interactive job renders while the next is downloaded and waits.
    fn concurrent(&self) -> usize {
        match self.queue {
            Queue::Interactive => 2,
            Queue::Batch => 1,
        }
    }

    fn request(&self, worker: &str, wait_ms: u32) -> LeaseRequest {
        let report = self.renderer.worker_report();
        LeaseRequest { worker: worker.to_owned(), queue: self.queue, report, wait_ms }
    }

    fn lease(grant: &LeaseGrant) -> (JobId, LeaseTicket) {
        (grant.job, grant.ticket)
    }

    async fn run(self, grant: LeaseGrant) {
        let LeaseGrant { ticket, job, ttl_ms, work } = grant;
        let ttl = Duration::from_millis(ttl_ms.into());
        let pictures = work.items.len();
        let control = JobControl::new(work.rays());
        let renew = async || {
            let progress = control.progress();
            self.client.renew(&LeaseRenewal { ticket, progress }).await
        };
        let outcome = tokio::select! {
            outcome = self.render(work, control.clone()) => outcome,
            () = renew_lease::<Self, _>(ttl, renew) => Err(Interrupted::Stale),
            () = self.shutdown.cancelled() => Err(Interrupted::Release("shutting down".to_owned())),
        };
        let outcome = match outcome {
            Ok(outcome) => outcome,
            Err(Interrupted::Failed(reason)) => RenderOutcome::Failed(reason),
            Err(Interrupted::Stale) => {
                tracing::info!(%job, "the lease has expired or was granted to another worker");
                return;
            }
            Err(Interrupted::Release(reason)) => {
                tracing::info!(%job, reason, "job returned to the queue");
                if let Err(error) = self.client.release(&ticket).await {
                    tracing::debug!(%job, %error, "cannot return the lease; it will expire");
                }
                return;
            }
            Err(Interrupted::OtherVersion(reason)) => {
                tracing::warn!(%job, reason, "job returned to the queue");
                if let Err(error) = self.client.release(&ticket).await {
                    tracing::debug!(%job, %error, "cannot return the lease; it will expire");
                }
                leave_to_others(&self.shutdown).await;
                return;
            }
        };
        if let RenderOutcome::Failed(reason) = &outcome {
            tracing::warn!(%job, reason, "job failed");
        }
        let results = LeaseResults { ticket, outcome };
        // For at most the duration of a lease: later, another worker has the job.
        let policy = RetryPolicy { limit: Some(ttl), repeats_server_errors: false };
        let submit = || self.client.results(&results);
        let sent = tokio::select! {
            sent = send_with_retry(policy, (job, "submit results"), &self.shutdown, submit) => sent,
            () = renew_lease::<Self, _>(ttl, renew) => Err(ClientError::Stale),
        };
        match sent {
            Ok(()) => tracing::debug!(%job, pictures, "results submitted"),
            Err(ClientError::Stale) => tracing::info!(
                %job, "results rejected: the lease has expired or was granted to another worker"
            ),
            Err(error) => {
                tracing::warn!(%job, %error, "cannot submit results; the lease will expire");
            }
        }
    }
}

impl RenderContext {
    async fn render(
        &self,
        work: RenderJob,
        control: JobControl,
    ) -> Result<RenderOutcome, Interrupted> {
        if work.renderer_version != RENDERER_VERSION {
            // Its pictures would corrupt the server's cache.
            let version = work.renderer_version.to_string();
            return Err(Interrupted::unknown("renderer", &version));
        }
        let mut targets = Vec::with_capacity(work.items.len());
        for item in &work.items {
            targets.push(match item.subject.target() {
                Some(source) => Some(self.target(source).await?),
                None => None,
            });
        }
        let (mesh, mut assets) = match work.frame.mesh {
            MeshSource::Target => self.scenery(&work, &targets).await?,
            MeshSource::Builtin | MeshSource::Uploaded(_) => {
                (self.mesh(&work).await?, self.scene_assets(&work).await?)
            }
        };
        let objects = self.objects(&work).await?;
        self.add_control_images(&work, &mut assets).await?;
        let (reply, done) = oneshot::channel();
        // Dropped with this future if the lease is lost.
        let _cancel = control.cancelled.clone().drop_guard();
        let closed = || Interrupted::Release("the render thread has ended".to_owned());
        let request = RenderRequest { work, targets, mesh, objects, assets, control, reply };
        self.requests.send(request).await.map_err(|_| closed())?;
        done.await.map_err(|_| closed())
    }

    /// Returns the parsed file of a target.
    async fn target(&self, source: &TargetSource) -> Result<Arc<LoadedTarget>, Interrupted> {
        if let Some(target) = self.renderer.targets.get(&source.hash) {
            return Ok(target);
        }
        if source.kind.parse::<TargetKind>().is_err() {
            return Err(Interrupted::unknown("target", &source.kind));
        }
        let bytes = self.client.target(&source.hash).await;
        let bytes = bytes.map_err(|error| Interrupted::by("download the target", error))?;
        let (renderer, source) = (self.renderer.clone(), source.clone());
        let read = move || renderer.targets.parse(&source, &bytes);
        tokio::task::spawn_blocking(read).await.map_err(failed)?.map_err(failed)
    }

    /// Returns the mesh of a job, unless a target's file has it.
    async fn mesh(&self, work: &RenderJob) -> Result<Arc<LoadedMesh>, Interrupted> {
        match work.frame.mesh {
            MeshSource::Builtin => match work.frame.scene().map_err(failed)?.builtin() {
                Some(name) => {
                    let renderer = self.renderer.clone();
                    let made = tokio::task::spawn_blocking(move || renderer.builtin(name)).await;
                    made.map_err(failed)
                }
                None => {
                    Err(failed("the scene refers to an uploaded mesh, the job to a built-in one"))
                }
            },
            MeshSource::Uploaded(hash) => self.uploaded(hash).await,
            MeshSource::Target => Err(failed("the mesh is in the file of a target")),
        }
    }

    /// Returns the uploaded meshes of a scene's other objects.
    async fn objects(&self, work: &RenderJob) -> Result<Vec<Arc<LoadedMesh>>, Interrupted> {
        let mut meshes = Vec::new();
        for object in &work.frame.objects {
            if let MeshSource::Uploaded(hash) = object.mesh {
                meshes.push(self.uploaded(hash).await?);
            }
        }
        Ok(meshes)
    }

    async fn uploaded(&self, hash: [u8; 32]) -> Result<Arc<LoadedMesh>, Interrupted> {
        if let Some(mesh) = self.renderer.uploaded(&hash) {
            return Ok(mesh);
        }
        let mesh = self.client.mesh(&hash).await;
        let mesh = mesh.map_err(|error| Interrupted::by("download the mesh", error))?;
        let renderer = self.renderer.clone();
        let keep = move || renderer.cache_uploaded(&hash, LoadedMesh::new(mesh));
        tokio::task::spawn_blocking(keep).await.map_err(failed)?.map_err(failed)
    }

    /// Returns the files that the scene of a job names.
    async fn scene_assets(&self, work: &RenderJob) -> Result<LightAssets, Interrupted> {
        let mut assets = LightAssets::default();
        // An unreadable scene is reported by the renderer.
        let Ok(scene) = work.frame.scene() else { return Ok(assets) };
        for (asset, _) in scene.assets() {
            let (AssetRef::Profile(name) | AssetRef::Environment(name) | AssetRef::Image(name)) =
                asset;
            self.add_asset(name, &mut assets).await?;
        }
        Ok(assets)
    }

    /// Adds the control images of the painted materials of a job.
    async fn add_control_images(
        &self,
        work: &RenderJob,
        assets: &mut LightAssets,
    ) -> Result<(), Interrupted> {
        let subjects = work.items.iter().flat_map(|item| item.subject.programs());
        let words = subjects.map(|program| &program.words);
        for words in words.chain(work.frame.objects.iter().map(|object| &object.words)) {
            // Unreadable words are reported by the renderer.
            let hashes = self.renderer.program(words).map(|program| program.images());
            for hash in hashes.unwrap_or_default() {
                self.add_asset(&hash.to_string(), assets).await?;
            }
        }
        Ok(())
    }

    /// Adds a file, from the cache or the server.
    async fn add_asset(&self, name: &str, assets: &mut LightAssets) -> Result<(), Interrupted> {
        if assets.contains(name) || self.asset_cache.add_to(name, assets) {
            return Ok(());
        }
        let file = self.client.light_asset(name).await;
        let file = file.map_err(|error| Interrupted::by("download a file of the scene", error))?;
        let LightAssetFile { kind, bytes } = file;
        let (asset_cache, own) = (self.asset_cache.clone(), name.to_owned());
        let mut all = std::mem::take(assets);
        let read = move || {
            asset_cache.parse_into(&own, kind, &bytes, &mut all)?;
            Ok::<_, String>(all)
        };
        *assets = tokio::task::spawn_blocking(read).await.map_err(failed)?.map_err(failed)?;
        Ok(())
    }

    /// Returns the mesh and the light assets of a job in the scene of a target's picture.
    async fn scenery(
        &self,
        work: &RenderJob,
        targets: &[Option<Arc<LoadedTarget>>],
    ) -> Result<(Arc<LoadedMesh>, LightAssets), Interrupted> {
        let source = work.items.first().and_then(|item| item.subject.target());
        let (Some(source), Some(Some(target))) = (source, targets.first()) else {
            return Err(failed(RenderError::NoTarget));
        };
        let (renderer, source, target) = (self.renderer.clone(), source.clone(), target.clone());
        let load = move || renderer.scenery(&source, &target);
        tokio::task::spawn_blocking(load).await.map_err(failed)?.map_err(failed)
    }
}

/// Returns the permanent failure with this reason.
fn failed(reason: impl ToString) -> Interrupted {
    Interrupted::Failed(reason.to_string())
}
