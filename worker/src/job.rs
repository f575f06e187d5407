//! A leased render job from grant to results: downloads, rendering, heartbeats, submission.

use std::sync::Arc;
use std::time::Duration;

use brood_protocol::{
    ClientError, LeaseGrant, LeaseResults, LeaseTicket, LightAssetFile, MeshSource, RenderJob,
    RenderOutcome, WorkerClient,
};
use brood_scene::{AssetRef, Light, LightAssets, MeshRef};
use tokio::sync::{mpsc, oneshot};
use tokio_util::sync::CancellationToken;

use crate::backoff::Backoff;
use crate::cache::LoadedMesh;
use crate::light_asset_cache::LightAssetCache;
use crate::render_thread::RenderRequest;
use crate::renderer::Renderer;

pub(crate) const HEARTBEAT: Duration = Duration::from_secs(5);

/// Resources that a worker shares among its render jobs.
#[derive(Clone)]
pub(crate) struct RenderContext {
    pub(crate) client: WorkerClient,
    pub(crate) renderer: Arc<Renderer>,
    pub(crate) requests: mpsc::Sender<RenderRequest>,
    pub(crate) asset_cache: LightAssetCache,
    pub(crate) shutdown: CancellationToken,
}

/// Reason for ending a job without submitting an outcome.
enum Abandoned {
    /// The lease is no longer valid; nothing is reported.
    Stale,
    /// The worker shuts down, or a download failed: the job is returned to the queue for another
    /// worker.
    Release(String),
}

impl RenderContext {
    /// Runs one job. Errors are handled here: the lease is returned or expires.
    pub(crate) async fn run(self, grant: LeaseGrant) {
        let LeaseGrant { ticket, job, ttl_ms, work } = grant;
        let ttl = Duration::from_millis(ttl_ms.into());
        let pictures = work.items.len();
        let outcome = tokio::select! {
            outcome = self.render(work) => outcome,
            lost = self.renew_lease(&ticket, ttl) => Err(lost),
            () = self.shutdown.cancelled() => Err(Abandoned::Release("shutting down".to_owned())),
        };
        match outcome {
            Ok(outcome) => {
                if let RenderOutcome::Failed(reason) = &outcome {
                    tracing::warn!(%job, reason, "job failed");
                }
                let results = LeaseResults { ticket, outcome };
                tokio::select! {
                    () = self.submit(&results, ttl) => {
                        tracing::debug!(%job, pictures, "results submitted");
                    }
                    _ = self.renew_lease(&ticket, ttl) => {
                        tracing::info!(%job, "lease lost while submitting results");
                    }
                }
            }
            Err(Abandoned::Stale) => {
                tracing::info!(%job, "the lease has expired or was granted to another worker")
            }
            Err(Abandoned::Release(reason)) => {
                tracing::info!(%job, reason, "job returned to the queue");
                if let Err(error) = self.client.release(&ticket).await {
                    tracing::debug!(%job, %error, "cannot return the lease; it will expire");
                }
            }
        }
    }

    async fn render(&self, work: RenderJob) -> Result<RenderOutcome, Abandoned> {
        let mesh = match self.mesh(&work).await {
            Ok(mesh) => mesh,
            Err(ClientError::Stale) => return Err(Abandoned::Stale),
            Err(ClientError::Status { status, detail }) if status.is_client_error() => {
                let reason = format!("cannot download the mesh ({status}): {detail}");
                return Ok(RenderOutcome::Failed(reason));
            }
            Err(ClientError::Wire(error)) => return Ok(RenderOutcome::Failed(error.to_string())),
            Err(error) => return Err(Abandoned::Release(error.to_string())),
        };
        let mesh = match mesh {
            Ok(mesh) => mesh,
            Err(reason) => return Ok(RenderOutcome::Failed(reason)),
        };
        let assets = match self.light_assets(&work).await {
            Ok(Ok(assets)) => assets,
            Ok(Err(reason)) => return Ok(RenderOutcome::Failed(reason)),
            Err(ClientError::Stale) => return Err(Abandoned::Stale),
            Err(error) => return Err(Abandoned::Release(error.to_string())),
        };
        let (reply, done) = oneshot::channel();
        let closed = || Abandoned::Release("the render thread has ended".to_owned());
        self.requests
            .send(RenderRequest { work, mesh, assets, reply })
            .await
            .map_err(|_| closed())?;
        done.await.map_err(|_| closed())
    }

    /// Returns the mesh of a job. The inner error is permanent: the job fails.
    async fn mesh(&self, work: &RenderJob) -> Result<Result<Arc<LoadedMesh>, String>, ClientError> {
        match work.frame.mesh {
            MeshSource::Builtin => Ok(match work.frame.scene().map(|scene| scene.mesh) {
                Ok(MeshRef::Builtin(name)) => {
                    let renderer = self.renderer.clone();
                    let made = tokio::task::spawn_blocking(move || renderer.builtin(name)).await;
                    made.map_err(|e| e.to_string())
                }
                Ok(MeshRef::Uploaded(_)) => {
                    Err("the scene refers to an uploaded mesh, the job to a built-in one"
                        .to_owned())
                }
                Err(error) => Err(error.to_string()),
            }),
            MeshSource::Uploaded(hash) => {
                if let Some(mesh) = self.renderer.uploaded(&hash) {
                    return Ok(Ok(mesh));
                }
                let mesh = self.client.mesh(&hash).await?;
                let renderer = self.renderer.clone();
                let keep = move || renderer.cache_uploaded(&hash, LoadedMesh::new(mesh));
                Ok(match tokio::task::spawn_blocking(keep).await {
                    Ok(kept) => kept.map_err(|e| e.to_string()),
                    Err(error) => Err(error.to_string()),
                })
            }
        }
    }

    /// Returns the light assets of a job. The inner error is permanent: the job fails.
    async fn light_assets(
        &self,
        work: &RenderJob,
    ) -> Result<Result<LightAssets, String>, ClientError> {
        let mut assets = LightAssets::default();
        // An unreadable scene is reported by the renderer.
        let lights = work.frame.scene().map(|scene| scene.lights).unwrap_or_default();
        for asset in lights.iter().filter_map(Light::asset) {
            let (AssetRef::Profile(name) | AssetRef::Environment(name)) = asset;
            if self.asset_cache.add_to(name, &mut assets) {
                continue;
            }
            let LightAssetFile { kind, bytes } = self.client.light_asset(name).await?;
            let (asset_cache, own) = (self.asset_cache.clone(), name.to_owned());
            let read = move || asset_cache.parse_and_insert(own, kind, &bytes);
            match tokio::task::spawn_blocking(read).await {
                Ok(Ok(())) => {}
                Ok(Err(reason)) => return Ok(Err(reason)),
                Err(error) => return Ok(Err(error.to_string())),
            }
            self.asset_cache.add_to(name, &mut assets);
        }
        Ok(Ok(assets))
    }

    /// Renews the lease periodically. Returns only if the lease is lost.
    async fn renew_lease(&self, ticket: &LeaseTicket, ttl: Duration) -> Abandoned {
        let period = HEARTBEAT.min(ttl / 4).max(Duration::from_millis(50));
        loop {
            tokio::time::sleep(period).await;
            match self.client.heartbeat(ticket).await {
                Ok(()) => {}
                Err(ClientError::Stale) => return Abandoned::Stale,
                Err(ClientError::Status { status, .. }) if status.as_u16() == 404 => {
                    return Abandoned::Stale;
                }
                // Not fatal: if the server was only slow, the next heartbeat arrives in time; if it
                // restarted, that heartbeat returns `Stale`.
                Err(error) => tracing::debug!(%error, "heartbeat failed"),
            }
        }
    }

    /// Submits the results, with retries for at most the duration of a lease.
    async fn submit(&self, results: &LeaseResults, ttl: Duration) {
        let deadline = tokio::time::Instant::now() + ttl;
        let mut backoff = Backoff::default();
        loop {
            let error = match self.client.results(results).await {
                Ok(()) => return,
                Err(ClientError::Stale) => {
                    tracing::info!(
                        "results rejected: the lease has expired or was granted to another worker"
                    );
                    return;
                }
                Err(error) => error,
            };
            let again = matches!(error, ClientError::Transport(_) | ClientError::Busy);
            let wait = backoff.next();
            if !again || tokio::time::Instant::now() + wait > deadline {
                tracing::warn!(%error, "cannot submit results; the lease will expire");
                return;
            }
            tokio::select! {
                () = tokio::time::sleep(wait) => {}
                () = self.shutdown.cancelled() => return,
            }
        }
    }
}
