//! Pictures in memory and renders in flight: one render per key, however many requests wait for it.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::{Duration, Instant};

use brood_protocol::{IndividualId, LineageId, PictureKey, Queue};
use brood_storage::StoredPicture;
use bytes::Bytes;
use moka::policy::EvictionPolicy;
use moka::sync::Cache;
use tokio::sync::{mpsc, watch};

use super::DiskCache;

/// Number of picture rows kept in memory.
const ROWS: u64 = 100_000;
/// Number of keys with event listeners.
const LISTENERS: u64 = 20_000;
/// Time after which a listener is dropped.
const LISTENER_TTL: Duration = Duration::from_secs(600);
/// Number of missing subjects kept.
const MISSING: u64 = 10_000;
/// Number of pictures queued for the disk.
const WRITES: usize = 1024;

/// Reason why a picture is not available.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Failure {
    /// The worker cannot render it.
    Render(Arc<str>),
    /// The subject cannot be drawn in the frame.
    Refused(Arc<str>),
    /// The subject does not exist.
    Missing(Arc<str>),
    /// Too many pictures are queued, or its job was not written; a retry may help.
    Busy,
    /// The job of the picture cannot be made now, for this reason; a retry may help.
    Unavailable(Arc<str>),
    /// Internal error; the reason was logged.
    Internal,
}

/// Outcome of a render in flight.
pub type RenderResult = Result<Bytes, Failure>;

type Waiter = watch::Receiver<Option<RenderResult>>;

/// A render in flight.
struct InFlight {
    result: watch::Sender<Option<RenderResult>>,
    /// Time until which it is wanted though no request waits for it: always for the pictures of a
    /// brood, and for a while after a request was answered that it should be repeated.
    wanted: Wanted,
    /// Share that is rendered, 0 to 1.
    progress: f32,
    /// True if a client that waits for it asked for an interactive job.
    is_urgent: bool,
}

/// Time until which a picture is wanted without a request.
#[derive(Debug, Clone, Copy)]
enum Wanted {
    Always,
    Until(Instant),
}

impl InFlight {
    fn new(wanted: Wanted) -> Self {
        Self { result: watch::Sender::new(None), wanted, progress: 0.0, is_urgent: false }
    }

    fn is_abandoned(&self) -> bool {
        let is_wanted = match self.wanted {
            Wanted::Always => true,
            Wanted::Until(time) => Instant::now() < time,
        };
        !is_wanted && self.result.receiver_count() == 0
    }
}

/// Result of a cache lookup.
#[derive(Debug)]
pub enum Lookup {
    /// Cached picture.
    Cached(Bytes),
    /// The subject does not exist; the reason.
    Missing(Arc<str>),
    /// Already being rendered by another request.
    InFlight(Waiter),
    /// Not being rendered yet; the caller must complete or fail it.
    Leader(Waiter),
}

/// Cache of pictures over the disk, and the renders in flight.
pub struct PictureCache {
    memory: Cache<PictureKey, Bytes>,
    disk: Arc<DiskCache>,
    writes: mpsc::Sender<(PictureKey, Bytes)>,
    rows: Cache<PictureKey, Arc<StoredPicture>>,
    /// Reasons why subjects do not exist. A key determines its subject, so they stay true.
    missing: Cache<PictureKey, Arc<str>>,
    in_flight: Mutex<HashMap<PictureKey, InFlight>>,
    listeners: Cache<PictureKey, Vec<(LineageId, IndividualId)>>,
}

impl PictureCache {
    /// Creates a cache over the disk, and the queue of pictures to write there.
    pub fn new(disk: DiskCache, memory_bytes: u64) -> (Self, mpsc::Receiver<(PictureKey, Bytes)>) {
        let weigh = |_: &PictureKey, bytes: &Bytes| u32::try_from(bytes.len()).unwrap_or(u32::MAX);
        // LRU, not the default LFU: the newest picture is the most likely to be requested.
        let memory = Cache::builder().max_capacity(memory_bytes).weigher(weigh);
        let memory = memory.eviction_policy(EvictionPolicy::lru());
        let (writes, queue) = mpsc::channel(WRITES);
        let listeners = Cache::builder().max_capacity(LISTENERS).time_to_live(LISTENER_TTL);
        let picture_cache = Self {
            memory: memory.build(),
            disk: Arc::new(disk),
            writes,
            rows: Cache::new(ROWS),
            missing: Cache::new(MISSING),
            in_flight: Mutex::default(),
            listeners: listeners.build(),
        };
        (picture_cache, queue)
    }

    /// Cache on disk.
    pub fn disk(&self) -> &Arc<DiskCache> {
        &self.disk
    }

    /// Returns true if a picture is in memory or on disk.
    pub fn has(&self, key: PictureKey) -> bool {
        self.memory.contains_key(&key) || self.disk.contains(key)
    }

    /// Caches a picture row.
    pub fn insert_row(&self, row: &Arc<StoredPicture>) {
        self.rows.insert(row.key, row.clone());
    }

    /// Returns the cached row of a key.
    pub fn row(&self, key: PictureKey) -> Option<Arc<StoredPicture>> {
        self.rows.get(&key)
    }

    /// Marks the keys that are neither cached nor in flight as in flight; the caller must complete
    /// or fail them.
    pub fn reserve(&self, keys: impl IntoIterator<Item = PictureKey>) -> Vec<PictureKey> {
        let mut in_flight = self.lock();
        let mut reserved = Vec::new();
        for key in keys {
            if !self.has(key) && !in_flight.contains_key(&key) {
                in_flight.insert(key, InFlight::new(Wanted::Always));
                reserved.push(key);
            }
        }
        reserved
    }

    /// True if a client that waits for one of these pictures asked for an interactive job.
    pub fn any_urgent(&self, keys: &[PictureKey]) -> bool {
        let in_flight = self.lock();
        keys.iter().any(|key| in_flight.get(key).is_some_and(|render| render.is_urgent))
    }

    /// Returns the picture, or a receiver for its result, from a client that asks for a job of this
    /// queue.
    pub fn subscribe(&self, key: PictureKey, queue: Queue) -> Lookup {
        if let Some(bytes) = self.memory.get(&key) {
            return Lookup::Cached(bytes);
        }
        if let Some(reason) = self.missing.get(&key) {
            return Lookup::Missing(reason);
        }
        let mut in_flight = self.lock();
        if let Some(render) = in_flight.get_mut(&key) {
            render.is_urgent |= queue == Queue::Interactive;
            return Lookup::InFlight(render.result.subscribe());
        }
        // The picture may have been completed between the first check and the lock.
        if let Some(bytes) = self.memory.get(&key) {
            return Lookup::Cached(bytes);
        }
        let mut render = InFlight::new(Wanted::Until(Instant::now()));
        render.is_urgent = queue == Queue::Interactive;
        let waiter = render.result.subscribe();
        in_flight.insert(key, render);
        Lookup::Leader(waiter)
    }

    /// Keeps a render in flight wanted for this time: a client was asked to come again.
    pub fn keep_wanted(&self, key: PictureKey, time: Duration) {
        if let Some(render) = self.lock().get_mut(&key)
            && let Wanted::Until(until) = &mut render.wanted
        {
            *until = (*until).max(Instant::now() + time);
        }
    }

    /// Notes the share of renders in flight that is done, 0 to 1.
    pub fn note_progress(&self, keys: &[PictureKey], progress: f32) {
        let mut in_flight = self.lock();
        for key in keys {
            if let Some(render) = in_flight.get_mut(key) {
                // A worker may send any bits.
                render.progress = if progress.is_nan() { 0.0 } else { progress.clamp(0.0, 1.0) };
            }
        }
    }

    /// Returns the share of a render in flight that is done; 0 if there is none.
    pub fn progress(&self, key: PictureKey) -> f32 {
        self.lock().get(&key).map_or(0.0, |render| render.progress)
    }

    /// Ends renders in flight if no client waits for any of them any more; false if one is wanted.
    /// Later requests begin new ones.
    pub fn end_if_abandoned(&self, keys: &[PictureKey]) -> bool {
        let mut in_flight = self.lock();
        let is_abandoned = |key| in_flight.get(key).is_some_and(InFlight::is_abandoned);
        let all = keys.iter().all(is_abandoned);
        if all {
            keys.iter().for_each(|key| drop(in_flight.remove(key)));
        }
        all
    }

    /// Completes a new picture: caches it, queues it for the disk and answers all waiting requests.
    pub fn complete(&self, key: PictureKey, bytes: Bytes) {
        if self.writes.try_send((key, bytes.clone())).is_err() {
            tracing::warn!(%key, "the queue of the picture cache is full: a picture is kept in memory only");
        }
        self.complete_from_disk(key, bytes);
    }

    /// Completes a picture that is already on disk.
    pub fn complete_from_disk(&self, key: PictureKey, bytes: Bytes) {
        self.memory.insert(key, bytes.clone());
        if let Some(render) = self.lock().remove(&key) {
            render.result.send_replace(Some(Ok(bytes)));
        }
    }

    /// Completes a picture from memory or disk; false if it must be rendered. Reads the disk.
    pub fn complete_if_cached(&self, key: PictureKey) -> bool {
        let bytes = self.memory.get(&key).or_else(|| self.disk.read(key));
        let there = bytes.is_some();
        if let Some(bytes) = bytes {
            self.complete_from_disk(key, bytes);
        }
        there
    }

    /// Drops all picture rows. Called after a purge, as the store may have lost some of them.
    pub fn clear_rows(&self) {
        self.rows.invalidate_all();
    }

    /// Fails renders in flight.
    pub fn fail(&self, keys: impl IntoIterator<Item = PictureKey>, failure: &Failure) {
        let mut in_flight = self.lock();
        for key in keys {
            if let Failure::Missing(reason) = failure {
                self.missing.insert(key, reason.clone());
            }
            if let Some(render) = in_flight.remove(&key) {
                render.result.send_replace(Some(Err(failure.clone())));
            }
        }
    }

    /// Registers an individual whose lineage gets an event when the picture is complete.
    pub fn add_listener(&self, key: PictureKey, lineage: LineageId, individual: IndividualId) {
        self.listeners.entry(key).and_upsert_with(|entry| {
            let mut all = entry.map(moka::Entry::into_value).unwrap_or_default();
            if all.len() < 64 && !all.contains(&(lineage, individual)) {
                all.push((lineage, individual));
            }
            all
        });
    }

    /// Removes and returns the individuals registered for a picture.
    pub fn take_listeners(&self, key: PictureKey) -> Vec<(LineageId, IndividualId)> {
        self.listeners.remove(&key).unwrap_or_default()
    }

    /// Number of renders in flight, and bytes in memory.
    pub fn size(&self) -> (usize, u64) {
        (self.lock().len(), self.memory.weighted_size())
    }

    fn lock(&self) -> MutexGuard<'_, HashMap<PictureKey, InFlight>> {
        self.in_flight.lock().expect("nothing panics under this lock")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture_cache() -> (tempfile::TempDir, PictureCache, mpsc::Receiver<(PictureKey, Bytes)>) {
        let dir = tempfile::tempdir().unwrap();
        let (picture_cache, queue) =
            PictureCache::new(DiskCache::open(dir.path(), 1 << 20).unwrap(), 1 << 20);
        (dir, picture_cache, queue)
    }

    fn key(n: u8) -> PictureKey {
        PictureKey([n; 32])
    }

    #[tokio::test]
    async fn second_request_waits_for_the_render_of_the_first() {
        let (_dir, picture_cache, mut queue) = picture_cache();
        let Lookup::Leader(mut first) = picture_cache.subscribe(key(1), Queue::Interactive) else {
            panic!("the first request must lead")
        };
        let Lookup::InFlight(mut second) = picture_cache.subscribe(key(1), Queue::Interactive)
        else {
            panic!("the second request must wait")
        };
        picture_cache.complete(key(1), Bytes::from_static(b"picture"));
        for waiter in [&mut first, &mut second] {
            let outcome = waiter.wait_for(Option::is_some).await.unwrap().clone().unwrap();
            assert_eq!(outcome.unwrap(), "picture");
        }
        assert!(matches!(picture_cache.subscribe(key(1), Queue::Interactive), Lookup::Cached(_)));
        assert_eq!(queue.recv().await.unwrap().0, key(1));
    }

    #[tokio::test]
    async fn picture_can_be_requested_again_when_its_render_failed() {
        let (_dir, picture_cache, _queue) = picture_cache();
        let Lookup::Leader(mut waiter) = picture_cache.subscribe(key(1), Queue::Interactive) else {
            panic!("the first request must lead")
        };
        picture_cache.fail([key(1)], &Failure::Busy);
        let outcome = waiter.wait_for(Option::is_some).await.unwrap().clone().unwrap();
        assert_eq!(outcome, Err(Failure::Busy));
        assert!(matches!(picture_cache.subscribe(key(1), Queue::Interactive), Lookup::Leader(_)));
    }

    #[test]
    fn progress_of_a_worker_is_a_share_whatever_it_sends() {
        let (_dir, picture_cache, _queue) = picture_cache();
        let waiter = picture_cache.subscribe(key(1), Queue::Batch);
        for (sent, kept) in [(0.5, 0.5), (f32::NAN, 0.0), (-3.0, 0.0), (f32::INFINITY, 1.0)] {
            picture_cache.note_progress(&[key(1), key(2)], sent);
            assert_eq!(
                (picture_cache.progress(key(1)), picture_cache.progress(key(2))),
                (kept, 0.0)
            );
        }
        assert!(!picture_cache.any_urgent(&[key(1), key(2)]));
        drop(picture_cache.subscribe(key(1), Queue::Interactive));
        assert!(picture_cache.any_urgent(&[key(1), key(2)]));
        drop(waiter);
    }

    #[test]
    fn render_is_abandoned_when_its_clients_have_gone() {
        let (_dir, picture_cache, _queue) = picture_cache();
        let first = picture_cache.subscribe(key(1), Queue::Interactive);
        let second = picture_cache.subscribe(key(1), Queue::Interactive);
        drop(first);
        assert!(!picture_cache.end_if_abandoned(&[key(1)]), "a client still waits");
        drop(second);
        assert!(picture_cache.end_if_abandoned(&[key(1)]));
        assert!(!picture_cache.end_if_abandoned(&[key(1)]), "it is not in flight any more");
        drop(picture_cache.subscribe(key(1), Queue::Interactive));
        picture_cache.keep_wanted(key(1), Duration::from_secs(60));
        assert!(!picture_cache.end_if_abandoned(&[key(1)]), "the client comes again");
        picture_cache.reserve([key(2)]);
        drop(picture_cache.subscribe(key(2), Queue::Interactive));
        assert!(!picture_cache.end_if_abandoned(&[key(2)]), "a brood's pictures are always wanted");
    }

    #[test]
    fn missing_subject_is_not_requested_again() {
        let (_dir, picture_cache, _queue) = picture_cache();
        assert!(matches!(picture_cache.subscribe(key(1), Queue::Interactive), Lookup::Leader(_)));
        picture_cache.fail([key(1)], &Failure::Missing("no mask".into()));
        let again = picture_cache.subscribe(key(1), Queue::Interactive);
        assert!(matches!(&again, Lookup::Missing(reason) if **reason == *"no mask"), "{again:?}");
    }

    #[tokio::test]
    async fn request_gets_a_picture_that_reached_the_disk_while_its_job_was_queued() {
        let (_dir, picture_cache, _queue) = picture_cache();
        let Lookup::Leader(mut waiter) = picture_cache.subscribe(key(1), Queue::Interactive) else {
            panic!("the first request must lead")
        };
        assert!(!picture_cache.complete_if_cached(key(1)));
        picture_cache.disk().write(key(1), b"picture");
        assert!(picture_cache.complete_if_cached(key(1)));
        let outcome = waiter.wait_for(Option::is_some).await.unwrap().clone().unwrap();
        assert_eq!(outcome.unwrap(), "picture");
        assert_eq!(picture_cache.size().0, 0);
    }

    #[test]
    fn only_new_keys_are_reserved() {
        let (_dir, picture_cache, _queue) = picture_cache();
        picture_cache.complete(key(1), Bytes::from_static(b"picture"));
        picture_cache.disk().write(key(2), b"picture");
        assert_eq!(picture_cache.reserve([1, 2, 3, 3, 4].map(key)), [3, 4].map(key));
        assert_eq!(picture_cache.reserve([3, 4, 5].map(key)), [5].map(key));
    }

    #[test]
    fn listeners_are_returned_once() {
        let (_dir, picture_cache, _queue) = picture_cache();
        let (lineage, individual) = (LineageId::fresh(), IndividualId::fresh());
        picture_cache.add_listener(key(1), lineage, individual);
        picture_cache.add_listener(key(1), lineage, individual);
        assert_eq!(picture_cache.take_listeners(key(1)), [(lineage, individual)]);
        assert!(picture_cache.take_listeners(key(1)).is_empty());
    }
}
