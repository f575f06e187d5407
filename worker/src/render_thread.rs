//! Render thread: renders one job at a time on its own thread pool. Requests arrive through a
//! channel with room for one.
//!
//! CPU work stays off the async runtime, so that heartbeats are sent however long a picture takes.

use std::num::NonZeroUsize;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::Instant;

use brood_genome::Input;
use brood_light::LightAssets;
use brood_program::Program;
use brood_protocol::{RenderJob, RenderOutcome, RenderStats, RenderedPicture};
use tokio::sync::{mpsc, oneshot};

use crate::cache::LoadedMesh;
use crate::renderer::{RenderError, Renderer};

/// Job with its mesh and light assets.
pub(crate) struct RenderRequest {
    pub(crate) work: RenderJob,
    pub(crate) mesh: Arc<LoadedMesh>,
    pub(crate) assets: LightAssets,
    /// Channel for the outcome; closed if the lease was lost.
    pub(crate) reply: oneshot::Sender<RenderOutcome>,
}

/// Starts the thread. It ends when all senders are dropped.
pub(crate) fn start(
    renderer: Arc<Renderer>,
    threads: Option<NonZeroUsize>,
) -> Result<mpsc::Sender<RenderRequest>, std::io::Error> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads.map_or(0, usize::from))
        .thread_name(|index| format!("render-{index}"))
        .build()
        .map_err(std::io::Error::other)?;
    let (sender, mut requests) = mpsc::channel::<RenderRequest>(1);
    std::thread::Builder::new().name("render".to_owned()).spawn(move || {
        while let Some(request) = requests.blocking_recv() {
            if request.reply.is_closed() {
                continue;
            }
            renderer.set_light_assets(request.assets);
            let outcome = pool.install(|| execute(&renderer, &request.work, &request.mesh));
            // A closed channel means that the lease was lost meanwhile.
            let _ = request.reply.send(outcome);
        }
    })?;
    Ok(sender)
}

fn execute(renderer: &Renderer, work: &RenderJob, mesh: &LoadedMesh) -> RenderOutcome {
    let start = Instant::now();
    // Discard the counters of an earlier job that failed.
    let _ = renderer.take_stats();
    let render = || {
        let programs: Result<Vec<_>, RenderError> =
            work.items.iter().map(|item| renderer.program(&item.words)).collect();
        let programs = programs?;
        let programs: Vec<_> = programs.iter().map(AsRef::as_ref).collect();
        let pictures = renderer.render(&work.frame, mesh, &programs)?;
        let mut counters = counters(work, &programs, &pictures);
        counters += renderer.take_stats();
        Ok::<_, RenderError>((pictures, counters))
    };
    match catch_unwind(AssertUnwindSafe(render)) {
        Ok(Ok((pictures, counters))) => {
            // A picture with a wrong key would corrupt the server's cache.
            for (picture, item) in pictures.iter().zip(&work.items) {
                if picture.key != item.key {
                    return RenderOutcome::Failed(
                        "server and worker are of different versions".into(),
                    );
                }
            }
            let busy_us = u64::try_from(start.elapsed().as_micros()).unwrap_or(u64::MAX);
            RenderOutcome::Pictures(pictures, RenderStats { busy_us, ..counters })
        }
        Ok(Err(error)) => RenderOutcome::Failed(error.to_string()),
        Err(_) => RenderOutcome::Failed("the renderer panicked".to_owned()),
    }
}

/// Sums the counters of the pictures, with the work that they would have taken without
/// optimisations.
fn counters(work: &RenderJob, programs: &[&Program], pictures: &[RenderedPicture]) -> RenderStats {
    let rays = work.frame.rays();
    let mut total = RenderStats::default();
    for ((item, program), picture) in work.items.iter().zip(programs).zip(pictures) {
        total += RenderStats {
            pictures: 1,
            operations_written: u64::from(item.operations_written) * rays,
            operations_executed: picture.operations,
            inputs_known: Input::ALL.len() as u64,
            inputs_read: program.inputs().iter().count() as u64,
            samples_lit: picture.samples,
            ..RenderStats::default()
        };
    }
    total
}
