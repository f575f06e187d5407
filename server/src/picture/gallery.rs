//! Pictures in memory, and those under way: one rendering a key, whoever waits for it.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Duration;

use brood_protocol::{IndividualId, LineageId, PictureKey};
use brood_storage::PictureRow;
use bytes::Bytes;
use moka::policy::EvictionPolicy;
use moka::sync::Cache;
use tokio::sync::{mpsc, watch};

use super::Disk;

/// Keys whose meaning is kept at hand.
const RECIPES: u64 = 100_000;
/// Keys that somebody wants to hear of.
const INTERESTS: u64 = 20_000;
const INTEREST_TIME: Duration = Duration::from_secs(600);
/// Pictures that wait to be written to disk.
const WRITES: usize = 1024;

/// Why a picture is not to be had.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Failure {
    /// The worker says that it cannot be rendered.
    Render(Arc<str>),
    /// Too much is waiting, or its job was never written: trying again may help.
    Busy,
    /// Something inside went wrong; the reason was logged.
    Internal,
}

/// How a flight ends.
pub type Landing = Result<Bytes, Failure>;

type Waiter = watch::Receiver<Option<Landing>>;

/// What somebody who wants a picture gets.
#[derive(Debug)]
pub enum Boarding {
    /// The picture.
    Here(Bytes),
    /// It is under way.
    Wait(Waiter),
    /// Nobody else is after it: the caller has to see to it that it lands.
    Lead(Waiter),
}

/// Pictures that are there or under way.
pub struct Gallery {
    memory: Cache<PictureKey, Bytes>,
    disk: Arc<Disk>,
    writes: mpsc::Sender<(PictureKey, Bytes)>,
    recipes: Cache<PictureKey, Arc<PictureRow>>,
    flights: Mutex<HashMap<PictureKey, watch::Sender<Option<Landing>>>>,
    interests: Cache<PictureKey, Vec<(LineageId, IndividualId)>>,
}

impl Gallery {
    /// A gallery over a cache on disk, and the queue of what is to be written there.
    pub fn new(disk: Disk, memory_bytes: u64) -> (Self, mpsc::Receiver<(PictureKey, Bytes)>) {
        let weigh = |_: &PictureKey, bytes: &Bytes| u32::try_from(bytes.len()).unwrap_or(u32::MAX);
        // The newest picture is the one that will be asked for, even where older ones were asked for more often.
        let memory = Cache::builder().max_capacity(memory_bytes).weigher(weigh);
        let memory = memory.eviction_policy(EvictionPolicy::lru());
        let (writes, queue) = mpsc::channel(WRITES);
        let interests = Cache::builder().max_capacity(INTERESTS).time_to_live(INTEREST_TIME);
        let gallery = Self {
            memory: memory.build(),
            disk: Arc::new(disk),
            writes,
            recipes: Cache::new(RECIPES),
            flights: Mutex::default(),
            interests: interests.build(),
        };
        (gallery, queue)
    }

    /// The cache on disk.
    pub fn disk(&self) -> &Arc<Disk> {
        &self.disk
    }

    /// Whether a picture need not be rendered.
    pub fn has(&self, key: PictureKey) -> bool {
        self.memory.contains_key(&key) || self.disk.contains(key)
    }

    /// Keeps what a key stands for at hand.
    pub fn learn(&self, row: &Arc<PictureRow>) {
        self.recipes.insert(row.key, row.clone());
    }

    /// What a key stands for, where it is at hand.
    pub fn recipe(&self, key: PictureKey) -> Option<Arc<PictureRow>> {
        self.recipes.get(&key)
    }

    /// Takes the keys that are neither there nor under way under way; the caller sees to it that they land.
    pub fn depart(&self, keys: impl IntoIterator<Item = PictureKey>) -> Vec<PictureKey> {
        let mut flights = self.lock();
        let mut departed = Vec::new();
        for key in keys {
            if !self.has(key) && !flights.contains_key(&key) {
                flights.insert(key, watch::Sender::new(None));
                departed.push(key);
            }
        }
        departed
    }

    /// The picture, or a way to wait for it.
    pub fn board(&self, key: PictureKey) -> Boarding {
        if let Some(bytes) = self.memory.get(&key) {
            return Boarding::Here(bytes);
        }
        let mut flights = self.lock();
        if let Some(flight) = flights.get(&key) {
            return Boarding::Wait(flight.subscribe());
        }
        // It may have landed between the first look and the lock.
        if let Some(bytes) = self.memory.get(&key) {
            return Boarding::Here(bytes);
        }
        let flight = watch::Sender::new(None);
        let waiter = flight.subscribe();
        flights.insert(key, flight);
        Boarding::Lead(waiter)
    }

    /// A new picture: kept, written to disk in the background, and given to all who wait.
    pub fn land(&self, key: PictureKey, bytes: Bytes) {
        if self.writes.try_send((key, bytes.clone())).is_err() {
            tracing::warn!(%key, "the disk is slower than the workers; a picture is kept in memory only");
        }
        self.recall(key, bytes);
    }

    /// A picture that was on disk already.
    pub fn recall(&self, key: PictureKey, bytes: Bytes) {
        self.memory.insert(key, bytes.clone());
        if let Some(flight) = self.lock().remove(&key) {
            flight.send_replace(Some(Ok(bytes)));
        }
    }

    /// Lands a picture that is in memory or on disk; false where it has to be rendered. Reads the disk.
    pub fn land_if_there(&self, key: PictureKey) -> bool {
        let bytes = self.memory.get(&key).or_else(|| self.disk.read(key));
        let there = bytes.is_some();
        if let Some(bytes) = bytes {
            self.recall(key, bytes);
        }
        there
    }

    /// Forgets what keys stand for: after a purge the store says what is still there.
    pub fn forget_recipes(&self) {
        self.recipes.invalidate_all();
    }

    /// Ends flights that will not land.
    pub fn crash(&self, keys: impl IntoIterator<Item = PictureKey>, failure: &Failure) {
        let mut flights = self.lock();
        for key in keys {
            if let Some(flight) = flights.remove(&key) {
                flight.send_replace(Some(Err(failure.clone())));
            }
        }
    }

    /// Notes that a lineage's listeners want to hear when a picture is there.
    pub fn interest(&self, key: PictureKey, lineage: LineageId, individual: IndividualId) {
        self.interests.entry(key).and_upsert_with(|entry| {
            let mut all = entry.map(moka::Entry::into_value).unwrap_or_default();
            if all.len() < 64 && !all.contains(&(lineage, individual)) {
                all.push((lineage, individual));
            }
            all
        });
    }

    /// Who wanted to hear of a picture.
    pub fn take_interests(&self, key: PictureKey) -> Vec<(LineageId, IndividualId)> {
        self.interests.remove(&key).unwrap_or_default()
    }

    /// Pictures under way, and bytes in memory.
    pub fn size(&self) -> (usize, u64) {
        (self.lock().len(), self.memory.weighted_size())
    }

    fn lock(&self) -> MutexGuard<'_, HashMap<PictureKey, watch::Sender<Option<Landing>>>> {
        self.flights.lock().expect("nothing panics under this lock")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gallery() -> (tempfile::TempDir, Gallery, mpsc::Receiver<(PictureKey, Bytes)>) {
        let dir = tempfile::tempdir().unwrap();
        let (gallery, queue) = Gallery::new(Disk::open(dir.path(), 1 << 20).unwrap(), 1 << 20);
        (dir, gallery, queue)
    }

    fn key(n: u8) -> PictureKey {
        PictureKey([n; 32])
    }

    #[tokio::test]
    async fn second_waiter_joins_the_flight_of_the_first() {
        let (_dir, gallery, mut queue) = gallery();
        let Boarding::Lead(mut first) = gallery.board(key(1)) else { panic!("nobody leads") };
        let Boarding::Wait(mut second) = gallery.board(key(1)) else { panic!("two lead") };
        gallery.land(key(1), Bytes::from_static(b"picture"));
        for waiter in [&mut first, &mut second] {
            let landing = waiter.wait_for(Option::is_some).await.unwrap().clone().unwrap();
            assert_eq!(landing.unwrap(), "picture");
        }
        assert!(matches!(gallery.board(key(1)), Boarding::Here(_)));
        assert_eq!(queue.recv().await.unwrap().0, key(1));
    }

    #[tokio::test]
    async fn flight_can_be_led_again_when_it_crashed() {
        let (_dir, gallery, _queue) = gallery();
        let Boarding::Lead(mut waiter) = gallery.board(key(1)) else { panic!("nobody leads") };
        gallery.crash([key(1)], &Failure::Busy);
        let landing = waiter.wait_for(Option::is_some).await.unwrap().clone().unwrap();
        assert_eq!(landing, Err(Failure::Busy));
        assert!(matches!(gallery.board(key(1)), Boarding::Lead(_)));
    }

    #[tokio::test]
    async fn waiter_gets_what_turned_up_on_disk_while_its_job_was_queued() {
        let (_dir, gallery, _queue) = gallery();
        let Boarding::Lead(mut waiter) = gallery.board(key(1)) else { panic!("nobody leads") };
        assert!(!gallery.land_if_there(key(1)));
        gallery.disk().write(key(1), b"picture");
        assert!(gallery.land_if_there(key(1)));
        let landing = waiter.wait_for(Option::is_some).await.unwrap().clone().unwrap();
        assert_eq!(landing.unwrap(), "picture");
        assert_eq!(gallery.size().0, 0);
    }

    #[test]
    fn only_new_keys_depart() {
        let (_dir, gallery, _queue) = gallery();
        gallery.land(key(1), Bytes::from_static(b"picture"));
        gallery.disk().write(key(2), b"picture");
        assert_eq!(gallery.depart([1, 2, 3, 3, 4].map(key)), [3, 4].map(key));
        assert_eq!(gallery.depart([3, 4, 5].map(key)), [5].map(key));
    }

    #[test]
    fn interests_are_handed_out_once() {
        let (_dir, gallery, _queue) = gallery();
        let (lineage, individual) = (LineageId::fresh(), IndividualId::fresh());
        gallery.interest(key(1), lineage, individual);
        gallery.interest(key(1), lineage, individual);
        assert_eq!(gallery.take_interests(key(1)), [(lineage, individual)]);
        assert!(gallery.take_interests(key(1)).is_empty());
    }
}
