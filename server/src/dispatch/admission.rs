//! Admission of births: refused while the queue of their pictures is full. Otherwise births would
//! go on for which no picture comes in time.

use brood_protocol::Queue;

use super::Workers;
use super::render_queue::RenderQueue;
use crate::problem::ApiError;

/// Checks that a birth may add pictures to the queue. Without workers it may: its pictures are not
/// expected.
///
/// # Errors
/// 503 if the queue is full.
pub fn admit_birth(queue: &RenderQueue, workers: &Workers) -> Result<(), ApiError> {
    if queue.is_full(Queue::Interactive) && !workers.present().0.is_empty() {
        return Err(ApiError::busy("too many pictures are queued; retry later"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use brood_protocol::{
        Backend, Frame, MeshSource, PictureFormat, Queue, RenderJob, WorkerReport,
    };
    use brood_scene::Scene;

    use super::*;
    use crate::client::Client;

    #[test]
    fn birth_is_refused_while_the_queue_is_full_and_workers_are_there() {
        let (queue, workers) = (RenderQueue::default(), Workers::default());
        workers.seen("a", &WorkerReport::default());
        admit_birth(&queue, &workers).unwrap();
        let options = (PictureFormat::Png, Backend::Auto);
        let frame = Frame::new(&Scene::default(), MeshSource::Builtin, 16, 1, options);
        let work = RenderJob::new(frame, Vec::new());
        while queue.push(work.clone(), Queue::Interactive, Client::current()).is_ok() {}
        assert_eq!(admit_birth(&queue, &workers).unwrap_err().status(), 503);
        admit_birth(&queue, &Workers::default()).unwrap();
    }
}
