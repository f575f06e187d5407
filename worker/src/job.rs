//! One leased job from grant to results: mesh, rendering, heartbeats, hand-over.
//!
//! It refuses to know how jobs are found and how pictures are made.

use std::sync::Arc;
use std::time::Duration;

use brood_protocol::{
    ClientError, LeaseGrant, LeaseResults, LeaseTicket, LightAssetFile, MeshSource, Outcome,
    RenderJob, WorkerClient,
};
use brood_scene::{AssetRef, Light, LightAssets, MeshRef};
use tokio::sync::{mpsc, oneshot};
use tokio_util::sync::CancellationToken;

use crate::backoff::Backoff;
use crate::cache::LoadedMesh;
use crate::lamp::Lamps;
use crate::render_thread::Order;
use crate::renderer::Renderer;

pub(crate) const HEARTBEAT: Duration = Duration::from_secs(5);

/// What a job needs from its worker.
#[derive(Clone)]
pub(crate) struct Desk {
    pub(crate) client: WorkerClient,
    pub(crate) renderer: Arc<Renderer>,
    pub(crate) orders: mpsc::Sender<Order>,
    pub(crate) lamps: Lamps,
    pub(crate) shutdown: CancellationToken,
}

/// Why a job ended without results of its own.
enum Abandoned {
    /// The lease has passed on: nothing to tell the server.
    Stale,
    /// The worker stops, or the server could not give the mesh: somebody else may try.
    Release(String),
}

impl Desk {
    /// Works off one grant. Errors end here: the lease is handed back or left to lapse.
    pub(crate) async fn work(self, grant: LeaseGrant) {
        let LeaseGrant { ticket, job, ttl_ms, work } = grant;
        let ttl = Duration::from_millis(ttl_ms.into());
        let pictures = work.items.len();
        let outcome = tokio::select! {
            outcome = self.render(work) => outcome,
            lost = self.keep(&ticket, ttl) => Err(lost),
            () = self.shutdown.cancelled() => Err(Abandoned::Release("stopping".to_owned())),
        };
        match outcome {
            Ok(outcome) => {
                if let Outcome::Failed(reason) = &outcome {
                    tracing::warn!(%job, reason, "job failed");
                }
                let results = LeaseResults { ticket, outcome };
                tokio::select! {
                    () = self.hand_over(&results, ttl) => tracing::debug!(%job, pictures, "handed over"),
                    _ = self.keep(&ticket, ttl) => tracing::info!(%job, "lease lost at hand-over"),
                }
            }
            Err(Abandoned::Stale) => tracing::info!(%job, "lease passed to someone else"),
            Err(Abandoned::Release(reason)) => {
                tracing::info!(%job, reason, "job given back");
                if let Err(error) = self.client.release(&ticket).await {
                    tracing::debug!(%job, %error, "lease left to lapse");
                }
            }
        }
    }

    async fn render(&self, work: RenderJob) -> Result<Outcome, Abandoned> {
        let mesh = match self.mesh(&work).await {
            Ok(mesh) => mesh,
            Err(ClientError::Stale) => return Err(Abandoned::Stale),
            Err(ClientError::Status { status, detail }) if status.is_client_error() => {
                let reason = format!("the mesh cannot be had ({status}): {detail}");
                return Ok(Outcome::Failed(reason));
            }
            Err(ClientError::Wire(error)) => return Ok(Outcome::Failed(error.to_string())),
            Err(error) => return Err(Abandoned::Release(error.to_string())),
        };
        let mesh = match mesh {
            Ok(mesh) => mesh,
            Err(reason) => return Ok(Outcome::Failed(reason)),
        };
        let assets = match self.light_assets(&work).await {
            Ok(Ok(assets)) => assets,
            Ok(Err(reason)) => return Ok(Outcome::Failed(reason)),
            Err(ClientError::Stale) => return Err(Abandoned::Stale),
            Err(error) => return Err(Abandoned::Release(error.to_string())),
        };
        let (reply, done) = oneshot::channel();
        let gone = || Abandoned::Release("the render thread is gone".to_owned());
        self.orders.send(Order { work, mesh, assets, reply }).await.map_err(|_| gone())?;
        done.await.map_err(|_| gone())
    }

    /// The mesh of a job; the inner error is one that trying again would not help.
    async fn mesh(&self, work: &RenderJob) -> Result<Result<Arc<LoadedMesh>, String>, ClientError> {
        match work.frame.mesh {
            MeshSource::Builtin => Ok(match work.frame.scene().map(|scene| scene.mesh) {
                Ok(MeshRef::Builtin(name)) => {
                    let renderer = self.renderer.clone();
                    let made = tokio::task::spawn_blocking(move || renderer.builtin(name)).await;
                    made.map_err(|e| e.to_string())
                }
                Ok(MeshRef::Uploaded(_)) => Err("the scene names no built-in mesh".to_owned()),
                Err(error) => Err(error.to_string()),
            }),
            MeshSource::Uploaded(hash) => {
                if let Some(mesh) = self.renderer.uploaded(&hash) {
                    return Ok(Ok(mesh));
                }
                let mesh = self.client.mesh(&hash).await?;
                let renderer = self.renderer.clone();
                let keep = move || renderer.keep_uploaded(&hash, LoadedMesh::new(mesh));
                Ok(match tokio::task::spawn_blocking(keep).await {
                    Ok(kept) => kept.map_err(|e| e.to_string()),
                    Err(error) => Err(error.to_string()),
                })
            }
        }
    }

    /// What the lights of a job refer to; the inner error is one that trying again would not help.
    async fn light_assets(
        &self,
        work: &RenderJob,
    ) -> Result<Result<LightAssets, String>, ClientError> {
        let mut assets = LightAssets::default();
        // A scene that cannot be read is told where it is rendered.
        let lights = work.frame.scene().map(|scene| scene.lights).unwrap_or_default();
        for asset in lights.iter().filter_map(Light::asset) {
            let (AssetRef::Profile(name) | AssetRef::Environment(name)) = asset;
            if self.lamps.take(name, &mut assets) {
                continue;
            }
            let LightAssetFile { kind, bytes } = self.client.light_asset(name).await?;
            let (lamps, own) = (self.lamps.clone(), name.to_owned());
            let read = move || lamps.keep(own, kind, &bytes);
            match tokio::task::spawn_blocking(read).await {
                Ok(Ok(())) => {}
                Ok(Err(reason)) => return Ok(Err(reason)),
                Err(error) => return Ok(Err(error.to_string())),
            }
            self.lamps.take(name, &mut assets);
        }
        Ok(Ok(assets))
    }

    /// Renews the lease for ever; ends only when it is lost.
    async fn keep(&self, ticket: &LeaseTicket, ttl: Duration) -> Abandoned {
        let period = HEARTBEAT.min(ttl / 4).max(Duration::from_millis(50));
        loop {
            tokio::time::sleep(period).await;
            match self.client.heartbeat(ticket).await {
                Ok(()) => {}
                Err(ClientError::Stale) => return Abandoned::Stale,
                Err(ClientError::Status { status, .. }) if status.as_u16() == 404 => {
                    return Abandoned::Stale;
                }
                // A server that restarts forgets leases; if it is only slow, the next beat is in time.
                Err(error) => tracing::debug!(%error, "heartbeat unanswered"),
            }
        }
    }

    /// Sends the results until they are taken or refused, for at most the time a lease lasts.
    async fn hand_over(&self, results: &LeaseResults, ttl: Duration) {
        let deadline = tokio::time::Instant::now() + ttl;
        let mut backoff = Backoff::default();
        loop {
            let error = match self.client.results(results).await {
                Ok(()) => return,
                Err(ClientError::Stale) => {
                    tracing::info!("results came too late; the lease passed to someone else");
                    return;
                }
                Err(error) => error,
            };
            let again = matches!(error, ClientError::Transport(_) | ClientError::Busy);
            let wait = backoff.next();
            if !again || tokio::time::Instant::now() + wait > deadline {
                tracing::warn!(%error, "results not taken; the lease is left to lapse");
                return;
            }
            tokio::select! {
                () = tokio::time::sleep(wait) => {}
                () = self.shutdown.cancelled() => return,
            }
        }
    }
}
