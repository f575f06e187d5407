//! Queue of render jobs, in the memory of the server that wants their pictures.
//!
//! A job is derived from stored rows. The queue is lost with the process; pictures are then
//! rendered when they are requested again. Knows neither workers nor leases: a job that is taken
//! belongs to its taker, who puts it back or ends it.

use std::collections::{BTreeMap, HashMap, VecDeque};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use brood_protocol::{JobId, PictureKey, Queue, RenderJob, encode};

use super::request::queue_for;
use super::turns::Turns;
use crate::client::Client;
use crate::limit;

/// A job is given up after this many workers died while running it.
const MAX_DEATHS: u32 = 3;
/// A job is given up after this many of its leases expired. A machine under load may stop a process
/// for longer than a lease.
const MAX_EXPIRED: u32 = 10;
/// Number of failed jobs whose state is kept.
const KEPT_FAILURES: usize = 100;

brood_genome::named_enum! {
    /// State of a job that has not succeeded.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
    pub enum JobState {
        /// Waiting for a worker.
        Queued => "queued",
        /// Leased to a worker.
        Leased => "leased",
        /// Failed for good.
        Failed => "failed",
        /// Given up: its workers died repeatedly.
        Dead => "dead",
    }
}

/// Reason for the return of an unfinished job.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Returned {
    /// The worker gave the job back, or never got it.
    Released,
    /// The lease expired: the worker was stopped, cut off or has died.
    Expired,
    /// The worker has died, or sent what is no picture.
    Died,
}

/// Render job. It belongs to the queue, or to the lease of a worker.
#[derive(Debug)]
pub struct QueuedJob {
    /// Id of the job.
    pub id: JobId,
    /// Queue that it waits in, or comes from.
    pub queue: Queue,
    /// Pictures to render.
    pub work: RenderJob,
    /// Number of leases so far.
    pub epoch: u64,
    created: Instant,
    /// Size of the encoded work.
    bytes: usize,
    turn: u64,
    deaths: u32,
    expired: u32,
}

impl QueuedJob {
    fn new(work: RenderJob, queue: Queue) -> Self {
        let (id, created, bytes) = (JobId::fresh(), Instant::now(), encode(&work).len());
        Self { id, queue, work, epoch: 0, created, bytes, turn: 0, deaths: 0, expired: 0 }
    }

    /// Time since the job was made.
    pub fn age(&self) -> Duration {
        self.created.elapsed()
    }

    /// Place in its queue: by turn, jobs of one turn by id.
    fn place(&self) -> (u64, JobId) {
        (self.turn, self.id)
    }
}

/// Error of a queue that takes no more jobs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("too many render jobs are queued")]
pub struct QueueFull;

/// State of a job that is known by its id.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Known {
    /// Queue of the job.
    pub queue: Queue,
    /// State of the job.
    pub state: JobState,
    /// Reason of a failure.
    pub reason: Option<String>,
}

/// Waiting jobs, by queue and place, and the states of all jobs that have not succeeded.
#[derive(Debug, Default)]
pub struct RenderQueue {
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    waiting: HashMap<Queue, Waiting>,
    turns: Turns,
    known: HashMap<JobId, Known>,
    /// Failed jobs, the oldest first.
    failures: VecDeque<JobId>,
}

/// Waiting jobs of one queue.
#[derive(Debug, Default)]
struct Waiting {
    jobs: BTreeMap<(u64, JobId), QueuedJob>,
    bytes: usize,
}

impl RenderQueue {
    /// Queues a job for a client. Returns its id.
    ///
    /// # Errors
    /// [`QueueFull`] if [`limit::QUEUED_JOBS`] jobs wait in the queue, or jobs of
    /// [`limit::QUEUED_BYTES`].
    pub fn push(&self, work: RenderJob, queue: Queue, client: Client) -> Result<JobId, QueueFull> {
        let mut job = QueuedJob::new(work, queue);
        let mut state = self.lock();
        if state.is_full(queue) {
            return Err(QueueFull);
        }
        state.assign_turn(&mut job, client);
        let id = job.id;
        state.insert(job);
        Ok(id)
    }

    /// Makes a job that a worker has got already.
    pub fn take_new(&self, work: RenderJob, queue: Queue, client: Client) -> QueuedJob {
        let mut job = QueuedJob::new(work, queue);
        let mut state = self.lock();
        state.assign_turn(&mut job, client);
        state.turns.claimed(queue, job.turn);
        state.lease(&mut job);
        job
    }

    /// Takes the next job of a queue.
    pub fn take(&self, queue: Queue) -> Option<QueuedJob> {
        let mut guard = self.lock();
        let state = &mut *guard;
        let waiting = state.waiting.get_mut(&queue)?;
        let (_, mut job) = waiting.jobs.pop_first()?;
        waiting.bytes -= job.bytes;
        state.turns.claimed(queue, job.turn);
        state.lease(&mut job);
        Some(job)
    }

    /// Moves the waiting batch job of a picture to the interactive queue, as a job of this client,
    /// if it is small enough for that queue and the queue takes more jobs. Returns true if it has
    /// moved.
    pub fn move_to_interactive(&self, key: PictureKey, client: Client) -> bool {
        let mut state = self.lock();
        if state.is_full(Queue::Interactive) {
            return false;
        }
        let Some(batch) = state.waiting.get_mut(&Queue::Batch) else { return false };
        let has = |job: &QueuedJob| job.work.items.iter().any(|item| item.key == key);
        let mut own = batch.jobs.iter().filter(|(_, job)| has(job));
        let own = own.find(|(_, job)| queue_for(job.work.rays()) == Queue::Interactive);
        let Some(place) = own.map(|(place, _)| *place) else { return false };
        let Some(mut job) = batch.jobs.remove(&place) else { return false };
        batch.bytes -= job.bytes;
        job.queue = Queue::Interactive;
        state.assign_turn(&mut job, client);
        state.insert(job);
        true
    }

    /// Returns an unfinished job to the front of its queue, which may exceed its limits. Returns
    /// the job if it is given up, after the third death of a worker or the tenth expired lease.
    pub fn put_back(&self, mut job: QueuedJob, returned: Returned) -> Option<QueuedJob> {
        job.deaths += u32::from(returned == Returned::Died);
        job.expired += u32::from(returned == Returned::Expired);
        let mut state = self.lock();
        if job.deaths < MAX_DEATHS && job.expired < MAX_EXPIRED {
            state.insert(job);
            return None;
        }
        state.fail(&job, JobState::Dead, "worker_lost");
        Some(job)
    }

    /// Notes that a taken job has failed for good.
    pub fn fail(&self, job: &QueuedJob, reason: &str) {
        self.lock().fail(job, JobState::Failed, reason);
    }

    /// Forgets a job that has succeeded or is not wanted any more.
    pub fn forget(&self, id: JobId) {
        self.lock().known.remove(&id);
    }

    /// True if no job waits in a queue.
    pub fn is_empty(&self, queue: Queue) -> bool {
        self.lock().waiting.get(&queue).is_none_or(|waiting| waiting.jobs.is_empty())
    }

    /// True if a queue takes no more jobs.
    pub fn is_full(&self, queue: Queue) -> bool {
        self.lock().is_full(queue)
    }

    /// Age of the oldest waiting job of a queue; `None` if it is empty.
    pub fn oldest(&self, queue: Queue) -> Option<Duration> {
        let state = self.lock();
        state.waiting.get(&queue)?.jobs.values().map(QueuedJob::age).max()
    }

    /// State of a job that has not succeeded; `None` if it is unknown.
    pub fn known(&self, id: JobId) -> Option<Known> {
        self.lock().known.get(&id).cloned()
    }

    /// Number of jobs of a queue in a state.
    pub fn count(&self, queue: Queue, state: JobState) -> usize {
        let known = &self.lock().known;
        known.values().filter(|known| (known.queue, known.state) == (queue, state)).count()
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    fn is_full(&self, queue: Queue) -> bool {
        self.waiting.get(&queue).is_some_and(|waiting| {
            waiting.jobs.len() >= limit::QUEUED_JOBS || waiting.bytes >= limit::QUEUED_BYTES
        })
    }

    /// Gives a new job of a client its turn.
    fn assign_turn(&mut self, job: &mut QueuedJob, client: Client) {
        job.turn = self.turns.next(job.queue, client, job.work.rays());
    }

    fn insert(&mut self, job: QueuedJob) {
        let known = Known { queue: job.queue, state: JobState::Queued, reason: None };
        self.known.insert(job.id, known);
        let waiting = self.waiting.entry(job.queue).or_default();
        waiting.bytes += job.bytes;
        waiting.jobs.insert(job.place(), job);
    }

    fn lease(&mut self, job: &mut QueuedJob) {
        job.epoch += 1;
        let known = Known { queue: job.queue, state: JobState::Leased, reason: None };
        self.known.insert(job.id, known);
    }

    fn fail(&mut self, job: &QueuedJob, state: JobState, reason: &str) {
        let known = Known { queue: job.queue, state, reason: Some(reason.to_owned()) };
        self.known.insert(job.id, known);
        self.failures.push_back(job.id);
        if self.failures.len() > KEPT_FAILURES
            && let Some(oldest) = self.failures.pop_front()
        {
            self.known.remove(&oldest);
        }
    }
}

#[cfg(test)]
mod tests {
    use brood_protocol::{
        Backend, Frame, MeshSource, PackedProgram, PictureFormat, PictureKey, RenderItem, Subject,
    };
    use brood_scene::Scene;

    use super::*;

    const CLIENT: Client = Client::Token([7; 32]);

    fn work() -> RenderJob {
        let options = (PictureFormat::Png, Backend::Auto);
        RenderJob::new(Frame::new(&Scene::default(), MeshSource::Builtin, 16, 1, options), vec![])
    }

    fn push(jobs: &RenderQueue, queue: Queue) -> JobId {
        jobs.push(work(), queue, CLIENT).unwrap()
    }

    fn state(jobs: &RenderQueue, id: JobId) -> Option<JobState> {
        jobs.known(id).map(|known| known.state)
    }

    #[test]
    fn jobs_are_taken_once_in_their_order_from_their_queue() {
        let jobs = RenderQueue::default();
        assert!(jobs.take(Queue::Batch).is_none() && jobs.is_empty(Queue::Batch));
        let batch = push(&jobs, Queue::Batch);
        let ids = [(); 3].map(|()| push(&jobs, Queue::Interactive));
        assert_eq!(jobs.count(Queue::Interactive, JobState::Queued), 3);
        let taken: Vec<_> =
            std::iter::from_fn(|| jobs.take(Queue::Interactive)).map(|job| job.id).collect();
        assert_eq!(taken, ids);
        assert_eq!(state(&jobs, ids[0]), Some(JobState::Leased));
        assert!(jobs.is_empty(Queue::Interactive) && !jobs.is_empty(Queue::Batch));
        jobs.forget(ids[0]);
        assert_eq!(state(&jobs, ids[0]), None);
        assert_eq!(jobs.take(Queue::Batch).unwrap().id, batch);
    }

    #[test]
    fn batch_job_of_a_picture_moves_to_the_interactive_queue_unless_it_is_large() {
        let jobs = RenderQueue::default();
        let of = |key: u8, size_px: u32| {
            let options = (PictureFormat::Png, Backend::Auto);
            let frame = Frame::new(&Scene::default(), MeshSource::Builtin, size_px, 4, options);
            let packed = PackedProgram { words: Vec::new(), operations_written: 0 };
            let subject = Subject::Program(packed);
            RenderJob::new(frame, vec![RenderItem { key: PictureKey([key; 32]), subject }])
        };
        let [small, large] =
            [of(1, 512), of(2, 2048)].map(|work| jobs.push(work, Queue::Batch, CLIENT).unwrap());
        let moved = [1, 2, 3, 1].map(|key| jobs.move_to_interactive(PictureKey([key; 32]), CLIENT));
        assert_eq!(moved, [true, false, false, false]);
        assert_eq!(jobs.take(Queue::Interactive).unwrap().id, small);
        assert_eq!(jobs.take(Queue::Batch).unwrap().id, large);
        assert_eq!(jobs.lock().waiting[&Queue::Batch].bytes, 0);
    }

    #[test]
    fn job_returns_to_the_front_of_its_queue_with_another_epoch() {
        let jobs = RenderQueue::default();
        let first = push(&jobs, Queue::Interactive);
        let second = push(&jobs, Queue::Interactive);
        let taken = jobs.take(Queue::Interactive).unwrap();
        assert_eq!((taken.id, taken.epoch), (first, 1));
        assert!(jobs.put_back(taken, Returned::Released).is_none());
        assert_eq!(state(&jobs, first), Some(JobState::Queued));
        let again = jobs.take(Queue::Interactive).unwrap();
        assert_eq!((again.id, again.epoch), (first, 2));
        assert_eq!(jobs.take(Queue::Interactive).unwrap().id, second);
    }

    #[test]
    fn oldest_waiting_job_keeps_its_age_when_it_returns() {
        let jobs = RenderQueue::default();
        let oldest = || jobs.oldest(Queue::Interactive);
        assert_eq!(oldest(), None);
        push(&jobs, Queue::Interactive);
        let wait = Duration::from_millis(5);
        std::thread::sleep(wait);
        push(&jobs, Queue::Interactive);
        assert!(oldest().is_some_and(|age| age >= wait));
        assert_eq!(jobs.oldest(Queue::Batch), None);
        let taken = [(); 2].map(|()| jobs.take(Queue::Interactive).unwrap());
        assert_eq!(oldest(), None);
        for job in taken {
            assert!(jobs.put_back(job, Returned::Released).is_none());
        }
        assert!(oldest().is_some_and(|age| age >= wait));
    }

    #[test]
    fn job_is_given_up_after_the_third_death_or_the_tenth_expired_lease() {
        use Returned::{Died, Expired, Released};
        for returns in [vec![Died, Expired, Released, Died, Died], vec![Expired; 10]] {
            let jobs = RenderQueue::default();
            let id = push(&jobs, Queue::Interactive);
            let mut dead = None;
            for returned in returns {
                assert!(dead.is_none());
                let taken = jobs.take(Queue::Interactive).unwrap();
                dead = jobs.put_back(taken, returned);
            }
            assert_eq!(dead.unwrap().id, id);
            let known = jobs.known(id).unwrap();
            let lost = (JobState::Dead, Some("worker_lost"));
            assert_eq!((known.state, known.reason.as_deref()), lost);
            assert!(jobs.is_empty(Queue::Interactive));
        }
    }

    #[test]
    fn oldest_failures_are_forgotten() {
        let jobs = RenderQueue::default();
        let mut ids = Vec::new();
        for _ in 0..=KEPT_FAILURES {
            ids.push(push(&jobs, Queue::Batch));
            jobs.fail(&jobs.take(Queue::Batch).unwrap(), "no such mesh");
        }
        assert_eq!(jobs.count(Queue::Batch, JobState::Failed), KEPT_FAILURES);
        assert_eq!(jobs.known(ids[0]), None);
        assert_eq!(jobs.known(ids[1]).unwrap().reason.as_deref(), Some("no such mesh"));
    }

    #[test]
    fn queues_have_separate_limits_and_returned_jobs_always_fit() {
        let jobs = RenderQueue::default();
        push(&jobs, Queue::Batch);
        let taken = jobs.take(Queue::Batch).unwrap();
        for _ in 0..limit::QUEUED_JOBS {
            push(&jobs, Queue::Batch);
        }
        assert!(jobs.is_full(Queue::Batch) && !jobs.is_full(Queue::Interactive));
        assert_eq!(jobs.push(work(), Queue::Batch, CLIENT), Err(QueueFull));
        assert!(jobs.put_back(taken, Returned::Released).is_none());
        push(&jobs, Queue::Interactive);
    }

    #[test]
    fn large_jobs_fill_a_queue_by_their_bytes() {
        let jobs = RenderQueue::default();
        let scene = Scene::default();
        let large = || {
            let options = (PictureFormat::Png, Backend::Auto);
            let frame = Frame::new(&scene, MeshSource::Builtin, 16, 1, options);
            let packed = PackedProgram { words: vec![u32::MAX; 1 << 20], operations_written: 0 };
            let subject = Subject::Program(packed);
            let key = PictureKey([1; 32]);
            RenderJob::new(frame, vec![RenderItem { key, subject }])
        };
        let mut count = 0;
        while jobs.push(large(), Queue::Batch, CLIENT).is_ok() {
            count += 1;
        }
        assert!((5..100).contains(&count), "{count} jobs of 4 to 5 MiB");
        while jobs.take(Queue::Batch).is_some() {}
        jobs.push(large(), Queue::Batch, CLIENT).unwrap();
    }

    #[test]
    fn work_done_at_once_does_not_put_a_client_behind() {
        let jobs = RenderQueue::default();
        for _ in 0..100 {
            jobs.take_new(work(), Queue::Interactive, CLIENT);
        }
        let other = Client::Token([8; 32]);
        for _ in 0..9 {
            jobs.push(work(), Queue::Interactive, other).unwrap();
        }
        let own = push(&jobs, Queue::Interactive);
        let next = [(); 3].map(|()| jobs.take(Queue::Interactive).unwrap().id);
        assert!(next.contains(&own));
    }

    #[test]
    fn client_with_many_jobs_does_not_keep_another_waiting() {
        let jobs = RenderQueue::default();
        for _ in 0..9 {
            push(&jobs, Queue::Interactive);
        }
        let first = jobs.take(Queue::Interactive).unwrap();
        let other = jobs.push(work(), Queue::Interactive, Client::Token([8; 32])).unwrap();
        let next = [(); 2].map(|()| jobs.take(Queue::Interactive).unwrap().id);
        assert!(next.contains(&other) && !next.contains(&first.id));
    }
}
