//! The thread that renders: one job at a time, on a pool of its own, fed through a channel that holds one job.
//!
//! CPU work stays off the async runtime, so heartbeats go out however long a picture takes.

use std::num::NonZeroUsize;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::Instant;

use brood_genome::Input;
use brood_program::Program;
use brood_protocol::{Outcome, RenderJob, RenderedPicture, Work};
use brood_scene::LightAssets;
use tokio::sync::{mpsc, oneshot};

use crate::cache::LoadedMesh;
use crate::renderer::{RenderError, Renderer};

/// A job whose mesh and light files are at hand.
pub(crate) struct Order {
    pub(crate) work: RenderJob,
    pub(crate) mesh: Arc<LoadedMesh>,
    pub(crate) assets: LightAssets,
    /// Closed where nobody wants the result any more.
    pub(crate) reply: oneshot::Sender<Outcome>,
}

/// Starts the thread; it ends when all senders are gone.
pub(crate) fn start(
    renderer: Arc<Renderer>,
    threads: Option<NonZeroUsize>,
) -> Result<mpsc::Sender<Order>, std::io::Error> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads.map_or(0, usize::from))
        .thread_name(|index| format!("render-{index}"))
        .build()
        .map_err(std::io::Error::other)?;
    let (sender, mut orders) = mpsc::channel::<Order>(1);
    std::thread::Builder::new().name("render".to_owned()).spawn(move || {
        while let Some(order) = orders.blocking_recv() {
            if order.reply.is_closed() {
                continue;
            }
            renderer.set_light_assets(order.assets);
            let outcome = pool.install(|| execute(&renderer, &order.work, &order.mesh));
            // A closed channel means that the lease was lost meanwhile.
            let _ = order.reply.send(outcome);
        }
    })?;
    Ok(sender)
}

fn execute(renderer: &Renderer, work: &RenderJob, mesh: &LoadedMesh) -> Outcome {
    let start = Instant::now();
    // What an earlier job that failed left behind is not this one's.
    let _ = renderer.take_work();
    let render = || {
        let programs: Result<Vec<_>, RenderError> =
            work.items.iter().map(|item| renderer.program(&item.words)).collect();
        let programs = programs?;
        let programs: Vec<_> = programs.iter().map(AsRef::as_ref).collect();
        let pictures = renderer.render(&work.frame, mesh, &programs)?;
        let mut took = took(work, &programs, &pictures);
        took += renderer.take_work();
        Ok::<_, RenderError>((pictures, took))
    };
    match catch_unwind(AssertUnwindSafe(render)) {
        Ok(Ok((pictures, took))) => {
            // A picture under a key it does not belong to must never reach a cache.
            for (picture, item) in pictures.iter().zip(&work.items) {
                if picture.key != item.key {
                    return Outcome::Failed("server and worker are of different versions".into());
                }
            }
            let busy_us = u64::try_from(start.elapsed().as_micros()).unwrap_or(u64::MAX);
            Outcome::Pictures(pictures, Work { busy_us, ..took })
        }
        Ok(Err(error)) => Outcome::Failed(error.to_string()),
        Err(_) => Outcome::Failed("the renderer panicked".to_owned()),
    }
}

/// What the pictures took, beside what they would have taken if nothing could be skipped.
fn took(work: &RenderJob, programs: &[&Program], pictures: &[RenderedPicture]) -> Work {
    let rays = work.frame.rays();
    let mut total = Work::default();
    for ((item, program), picture) in work.items.iter().zip(programs).zip(pictures) {
        total += Work {
            pictures: 1,
            operations_written: u64::from(item.operations_written) * rays,
            operations_executed: picture.operations,
            inputs_known: Input::ALL.len() as u64,
            inputs_read: program.inputs().iter().count() as u64,
            samples_lit: picture.samples,
            ..Work::default()
        };
    }
    total
}
