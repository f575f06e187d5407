//! A leased render job from grant to results: downloads, rendering, heartbeats, submission.

use std::sync::Arc;
use std::time::Duration;

use brood_light::{AssetRef, Light, LightAssets};
use brood_protocol::{
    ClientError, LeaseGrant, LeaseRequest, LeaseResults, LightAssetFile, MeshSource, RenderJob,
    RenderOutcome, WorkerClient,
};
use brood_scene::MeshRef;
use tokio::sync::{mpsc, oneshot};
use tokio_util::sync::CancellationToken;

use crate::cache::LoadedMesh;
use crate::lease::{Interrupted, JobKind, RetryPolicy, renew_lease, send_with_retry};
use crate::light_asset_cache::LightAssetCache;
use crate::render_thread::RenderRequest;
use crate::renderer::Renderer;

/// Resources that a worker shares among its render jobs.
#[derive(Clone)]
pub(crate) struct RenderContext {
    pub(crate) client: WorkerClient,
    pub(crate) renderer: Arc<Renderer>,
    pub(crate) requests: mpsc::Sender<RenderRequest>,
    pub(crate) asset_cache: LightAssetCache,
    pub(crate) shutdown: CancellationToken,
}

impl JobKind for RenderContext {
    const NAME: &'static str = "render";
    /// One job renders while the next is downloaded and waits.
    const CONCURRENT: usize = 2;
    type Request = LeaseRequest;

    fn request(&self, worker: &str, wait_ms: u32) -> LeaseRequest {
        LeaseRequest { worker: worker.to_owned(), report: self.renderer.worker_report(), wait_ms }
    }

    async fn run(self, grant: LeaseGrant) {
        let LeaseGrant { ticket, job, ttl_ms, work } = grant;
        let ttl = Duration::from_millis(ttl_ms.into());
        let pictures = work.items.len();
        let outcome = tokio::select! {
            outcome = self.render(work) => outcome,
            () = renew_lease(&self.client, &ticket, ttl) => Err(Interrupted::Stale),
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
            () = renew_lease(&self.client, &ticket, ttl) => Err(ClientError::Stale),
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
    async fn render(&self, work: RenderJob) -> Result<RenderOutcome, Interrupted> {
        let mesh = self.mesh(&work).await?;
        let assets = self.light_assets(&work).await?;
        let (reply, done) = oneshot::channel();
        let closed = || Interrupted::Release("the render thread has ended".to_owned());
        let request = RenderRequest { work, mesh, assets, reply };
        self.requests.send(request).await.map_err(|_| closed())?;
        done.await.map_err(|_| closed())
    }

    /// Returns the mesh of a job.
    async fn mesh(&self, work: &RenderJob) -> Result<Arc<LoadedMesh>, Interrupted> {
        match work.frame.mesh {
            MeshSource::Builtin => match work.frame.scene().map_err(failed)?.mesh {
                MeshRef::Builtin(name) => {
                    let renderer = self.renderer.clone();
                    let made = tokio::task::spawn_blocking(move || renderer.builtin(name)).await;
                    made.map_err(failed)
                }
                MeshRef::Uploaded(_) => {
                    Err(failed("the scene refers to an uploaded mesh, the job to a built-in one"))
                }
            },
            MeshSource::Uploaded(hash) => {
                if let Some(mesh) = self.renderer.uploaded(&hash) {
                    return Ok(mesh);
                }
                let mesh = self.client.mesh(&hash).await;
                let mesh = mesh.map_err(|error| Interrupted::by("download the mesh", error))?;
                let renderer = self.renderer.clone();
                let keep = move || renderer.cache_uploaded(&hash, LoadedMesh::new(mesh));
                tokio::task::spawn_blocking(keep).await.map_err(failed)?.map_err(failed)
            }
        }
    }

    /// Returns the light assets of a job.
    async fn light_assets(&self, work: &RenderJob) -> Result<LightAssets, Interrupted> {
        let mut assets = LightAssets::default();
        // An unreadable scene is reported by the renderer.
        let lights = work.frame.scene().map(|scene| scene.lights).unwrap_or_default();
        for asset in lights.iter().filter_map(Light::asset) {
            let (AssetRef::Profile(name) | AssetRef::Environment(name)) = asset;
            if self.asset_cache.add_to(name, &mut assets) {
                continue;
            }
            let file = self.client.light_asset(name).await;
            let file = file.map_err(|error| Interrupted::by("download a light file", error))?;
            let LightAssetFile { kind, bytes } = file;
            let (asset_cache, own) = (self.asset_cache.clone(), name.to_owned());
            let read = move || asset_cache.parse_and_insert(own, kind, &bytes);
            tokio::task::spawn_blocking(read).await.map_err(failed)?.map_err(failed)?;
            self.asset_cache.add_to(name, &mut assets);
        }
        Ok(assets)
    }
}

/// Returns the permanent failure with this reason.
fn failed(reason: impl ToString) -> Interrupted {
    Interrupted::Failed(reason.to_string())
}
