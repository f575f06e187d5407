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
use brood_protocol::{
    Queue, RENDERER_VERSION, RenderItem, RenderJob, RenderOutcome, RenderStats, RenderedPicture,
    lower_thread_priority,
};
use tokio::sync::{mpsc, oneshot};

use crate::error::RenderError;
use crate::job_control::JobControl;
use crate::renderer::Renderer;
use crate::scene_view::LoadedMesh;
use crate::subject::LoadedSubject;
use crate::target_cache::LoadedTarget;

/// Job with its targets, mesh and light assets.
pub(crate) struct RenderRequest {
    pub(crate) work: RenderJob,
    /// Target of each item, if its subject has one.
    pub(crate) targets: Vec<Option<Arc<LoadedTarget>>>,
    pub(crate) mesh: Arc<LoadedMesh>,
    /// Uploaded meshes of the scene's other objects.
    pub(crate) objects: Vec<Arc<LoadedMesh>>,
    pub(crate) assets: LightAssets,
    pub(crate) control: JobControl,
    /// Channel for the outcome; closed if the lease was lost.
    pub(crate) reply: oneshot::Sender<RenderOutcome>,
}

/// Starts the thread for jobs of a queue; batch jobs have a low priority. It ends when all senders
/// are dropped.
pub(crate) fn start(
    renderer: Arc<Renderer>,
    queue: Queue,
    threads: Option<NonZeroUsize>,
) -> Result<mpsc::Sender<RenderRequest>, std::io::Error> {
    let lower = move || {
        if queue == Queue::Batch {
            lower_thread_priority();
        }
    };
    let name = match queue {
        Queue::Interactive => "render",
        Queue::Batch => "batch",
    };
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads.map_or(0, usize::from))
        .thread_name(move |index| format!("{name}-{index}"))
        .start_handler(move |_| lower())
        .build()
        .map_err(std::io::Error::other)?;
    let (sender, mut requests) = mpsc::channel::<RenderRequest>(1);
    std::thread::Builder::new().name(name.to_owned()).spawn(move || {
        lower();
        while let Some(request) = requests.blocking_recv() {
            if request.reply.is_closed() {
                continue;
            }
            let RenderRequest { work, targets, mesh, objects, assets, control, reply } = request;
            renderer.caches.set_control(control);
            renderer.set_light_assets(assets);
            renderer.set_object_meshes(objects);
            let outcome = pool.install(|| execute(&renderer, &work, targets, &mesh));
            // A closed channel means that the lease was lost meanwhile.
            let _ = reply.send(outcome);
        }
    })?;
    Ok(sender)
}

fn execute(
    renderer: &Renderer,
    work: &RenderJob,
    targets: Vec<Option<Arc<LoadedTarget>>>,
    mesh: &LoadedMesh,
) -> RenderOutcome {
    if work.renderer_version != RENDERER_VERSION {
        // Its pictures would corrupt the server's cache.
        return RenderOutcome::Failed("server and worker are of different versions".to_owned());
    }
    let start = Instant::now();
    // Discard the counters of an earlier job that failed.
    let _ = renderer.take_stats();
    let render = || {
        let load = |(item, target): (&RenderItem, _)| {
            let subject = item.subject.try_map(|program| renderer.program(&program.words))?;
            Ok(LoadedSubject { key: item.key, subject, target })
        };
        let subjects: Result<Vec<_>, RenderError> =
            work.items.iter().zip(targets).map(load).collect();
        let subjects = subjects?;
        let pictures = renderer.render_subjects(&work.frame, mesh, &subjects)?;
        let mut counters = counters(work, &subjects, &pictures);
        counters += renderer.take_stats();
        Ok::<_, RenderError>((pictures, counters))
    };
    match catch_unwind(AssertUnwindSafe(render)) {
        Ok(Ok((pictures, counters))) => {
            let busy_us = u64::try_from(start.elapsed().as_micros()).unwrap_or(u64::MAX);
            RenderOutcome::Pictures(pictures, RenderStats { busy_us, ..counters })
        }
        Ok(Err(RenderError::Missing(reason))) => RenderOutcome::Missing(reason),
        Ok(Err(error)) => RenderOutcome::Failed(error.to_string()),
        Err(_) => RenderOutcome::Failed("the renderer panicked".to_owned()),
    }
}

/// Sums the counters of the pictures, with the work that they would have taken without
/// optimisations.
fn counters(
    work: &RenderJob,
    subjects: &[LoadedSubject],
    pictures: &[RenderedPicture],
) -> RenderStats {
    let rays = work.frame.rays();
    let mut total = RenderStats::default();
    for ((item, loaded), picture) in work.items.iter().zip(subjects).zip(pictures) {
        let (packed, programs) = (item.subject.programs(), loaded.subject.programs());
        let written = packed.iter().map(|program| u64::from(program.operations_written));
        let inputs_read = programs.iter().map(|program| program.inputs().iter().count() as u64);
        total += RenderStats {
            pictures: 1,
            operations_written: written.sum::<u64>() * rays,
            operations_executed: picture.operations,
            inputs_known: (programs.len() * Input::SYMMETRIC) as u64,
            inputs_read: inputs_read.sum(),
            samples_lit: picture.samples,
            ..RenderStats::default()
        };
    }
    total
}
