//! Workers that sleep instead of rendering, to load servers in benchmarks: claims, downloads,
//! heartbeats and submissions are those of workers that render.

use std::net::{IpAddr, Ipv4Addr};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use brood_eval::encode_png;
use brood_protocol::{
    Backend, ClientError, PictureFormat, Queue, RenderJob, RenderOutcome, RenderStats,
    RenderedPicture, WorkerClient,
};
use brood_scene::PixelArea;
use tokio::sync::mpsc;
use tokio::task::JoinSet;
use tokio::time::Instant;
use tokio_util::sync::CancellationToken;

use crate::claim::{Claims, RESOLVE, Servers, claim_at_all};
use crate::job::RenderContext;
use crate::lease::{JobKind, WorkerError};
use crate::light_asset_cache::LightAssetCache;
use crate::render_thread::RenderRequest;
use crate::renderer::Renderer;

/// Cache for the meshes of all jobs, in bytes.
const CACHE_BYTES: u64 = 64 << 20;
/// Step of the runtime's timer. A longer delay is not made up for: the machine was busy.
const TIMER_STEP: Duration = Duration::from_millis(1);

/// Configuration of workers that sleep.
#[derive(Debug, Clone)]
pub struct SleeperConfig {
    /// URLs of the servers. Each worker claims jobs at all of them.
    pub servers: Vec<String>,
    /// Token with the scope `work`.
    pub token: String,
    /// Number of workers.
    pub workers: usize,
    /// Time for which a worker sleeps for each picture.
    pub picture: Duration,
}

/// Sums over all workers that sleep.
#[derive(Debug, Default)]
pub struct SleepCounters {
    /// Number of finished jobs.
    pub jobs: AtomicU64,
    /// Number of pictures of these jobs.
    pub pictures: AtomicU64,
    /// Time that was slept for these jobs, in microseconds.
    pub slept_us: AtomicU64,
}

/// Runs the workers. Each returns a transparent PNG for every picture. Ends only with an error; the
/// jobs of a dropped future run to their end.
///
/// # Errors
/// Returns [`WorkerError::Refused`] if a server rejects the token, [`WorkerError::Client`] if the
/// URL of a server is invalid.
pub async fn run_sleepers(
    config: SleeperConfig,
    counters: Arc<SleepCounters>,
) -> Result<(), WorkerError> {
    let renderer = Arc::new(Renderer::with_cache(Backend::Cpu, CACHE_BYTES));
    let shutdown = CancellationToken::new();
    let mut lanes = JoinSet::new();
    for number in 0..config.workers {
        // Each worker has connections of its own.
        let clients = config.servers.iter().map(|url| WorkerClient::new(url, &config.token));
        let clients: Result<Vec<_>, _> = clients.collect();
        let servers = Arc::new(ListedServers(clients.map_err(WorkerError::Client)?));
        for queue in [Queue::Interactive, Queue::Batch] {
            let (sender, requests) = mpsc::channel(1);
            tokio::spawn(sleep_for_jobs(requests, config.picture, counters.clone()));
            let context = RenderContext {
                client: servers.client(None).map_err(WorkerError::Client)?,
                queue,
                asset_cache: LightAssetCache::new(renderer.entries()),
                renderer: renderer.clone(),
                requests: sender,
                shutdown: shutdown.clone(),
            };
            let name = format!("sleeper-{number}");
            let claims = Claims::new(&name, context.concurrent(), shutdown.clone());
            let servers = servers.clone();
            lanes.spawn(async move { claim_at_all(&*servers, &claims, context, RESOLVE).await });
        }
    }
    while let Some(ended) = lanes.join_next().await {
        ended.map_err(std::io::Error::other)??;
    }
    Ok(())
}

/// Servers with different URLs. The address of a server is its number in the list.
struct ListedServers(Vec<WorkerClient>);

impl Servers for ListedServers {
    async fn resolve(&self) -> Vec<IpAddr> {
        (0_u32..).zip(&self.0).map(|(number, _)| Ipv4Addr::from(number).into()).collect()
    }

    fn client(&self, address: Option<IpAddr>) -> Result<WorkerClient, ClientError> {
        let number = match address {
            Some(IpAddr::V4(address)) => u32::from(address) as usize,
            Some(IpAddr::V6(_)) | None => 0,
        };
        Ok(self.0[number].clone())
    }
}

/// Sleeps for one job after the other, as long as its pictures take. What the timer adds to a sleep
/// is taken off the next one. Ends when all senders are dropped.
async fn sleep_for_jobs(
    mut requests: mpsc::Receiver<RenderRequest>,
    picture: Duration,
    counters: Arc<SleepCounters>,
) {
    let mut late = Duration::ZERO;
    while let Some(RenderRequest { work, reply, .. }) = requests.recv().await {
        if reply.is_closed() {
            continue;
        }
        let pictures = work.items.len();
        let time = picture.saturating_mul(u32::try_from(pictures).unwrap_or(u32::MAX));
        let wanted = time.saturating_sub(late);
        let start = Instant::now();
        tokio::time::sleep(wanted).await;
        let slept = start.elapsed();
        late = slept.saturating_sub(wanted).min(TIMER_STEP);
        let slept_us = u64::try_from(slept.as_micros()).unwrap_or(u64::MAX);
        counters.jobs.fetch_add(1, Ordering::Relaxed);
        counters.pictures.fetch_add(pictures as u64, Ordering::Relaxed);
        counters.slept_us.fetch_add(slept_us, Ordering::Relaxed);
        // A closed channel means that the lease was lost meanwhile.
        let _ = reply.send(transparent(&work, slept_us));
    }
}

/// Returns the outcome of a job with the same transparent file for each picture.
fn transparent(work: &RenderJob, busy_us: u64) -> RenderOutcome {
    if work.frame.format != PictureFormat::Png {
        return RenderOutcome::Failed("a worker that sleeps makes PNG files only".to_owned());
    }
    let area = work.frame.area.unwrap_or(PixelArea::whole(work.frame.size_px));
    let rgba = vec![0; 4 * area.width as usize * area.height as usize];
    let png = encode_png(area.width, area.height, &rgba);
    let picture = |key| RenderedPicture {
        key,
        bytes: png.clone(),
        exposure_ev: 0.0,
        samples: 0,
        operations: 0,
    };
    let pictures: Vec<_> = work.items.iter().map(|item| picture(item.key)).collect();
    let stats = RenderStats { pictures: pictures.len() as u64, busy_us, ..RenderStats::default() };
    RenderOutcome::Pictures(pictures, stats)
}

#[cfg(test)]
mod tests {
    use brood_protocol::{Frame, MeshSource, PackedProgram, PictureKey, RenderItem, Subject};
    use brood_scene::Scene;

    use super::*;

    fn job(format: PictureFormat, pictures: u8) -> RenderJob {
        let options = (format, Backend::Auto);
        let frame = Frame::new(&Scene::default(), MeshSource::Builtin, 16, 1, options);
        let item = |key| {
            let packed = PackedProgram { words: Vec::new(), operations_written: 0 };
            RenderItem { key: PictureKey([key; 32]), subject: Subject::Program(packed) }
        };
        RenderJob::new(frame, (0..pictures).map(item).collect())
    }

    #[test]
    fn each_picture_of_a_job_is_a_png_of_its_size() {
        let RenderOutcome::Pictures(pictures, stats) = transparent(&job(PictureFormat::Png, 3), 7)
        else {
            panic!("a job of PNG files succeeds")
        };
        assert_eq!((pictures.len(), stats.pictures, stats.busy_us), (3, 3, 7));
        let (width, height, _) = brood_eval::decode_png(&pictures[2].bytes).unwrap();
        assert_eq!((width, height, pictures[2].key), (16, 16, PictureKey([2; 32])));
        let refused = transparent(&job(PictureFormat::Exr, 1), 0);
        assert!(matches!(refused, RenderOutcome::Failed(_)));
    }

    #[tokio::test]
    async fn server_is_found_by_its_number() {
        let client = |port| WorkerClient::new(&format!("http://127.0.0.1:{port}"), "").unwrap();
        let servers = ListedServers(vec![client(1), client(2)]);
        let urls: Vec<_> = servers
            .resolve()
            .await
            .into_iter()
            .map(|address| servers.client(Some(address)).unwrap().server().to_owned())
            .collect();
        assert_eq!(urls, ["http://127.0.0.1:1", "http://127.0.0.1:2"]);
    }
}
