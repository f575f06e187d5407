//! Event streams: one hub a lineage or search, with a bounded memory for listeners that come back.

use std::collections::{HashMap, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::{Duration, Instant};

use brood_protocol::{GenerationId, IndividualId, JobId, LineageId};
use brood_storage::StoredIndividual;
use serde_json::{Value, json};
use tokio::sync::{OwnedSemaphorePermit, Semaphore, broadcast};

use crate::limit;

/// Events that a hub remembers, and that a listener may be behind.
const REMEMBERED: usize = 1024;
/// A hub that nobody listens to is forgotten after this time.
const FORGET: Duration = Duration::from_secs(600);

/// What a stream tells of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Topic {
    /// A lineage.
    Lineage(LineageId),
    /// A search.
    Job(JobId),
}

impl From<LineageId> for Topic {
    fn from(id: LineageId) -> Self {
        Self::Lineage(id)
    }
}

impl From<JobId> for Topic {
    fn from(id: JobId) -> Self {
        Self::Job(id)
    }
}

/// Something that happened in a lineage or to a search.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Event {
    /// The hub, counted up within the process.
    pub hub: u64,
    /// Counted up within the hub.
    pub number: u64,
    /// The kind, as the stream names it.
    pub name: &'static str,
    /// JSON.
    pub data: String,
}

/// The hubs of all lineages and searches.
#[derive(Debug)]
pub struct Events {
    /// Tells ids of this process from those of the one before.
    life: String,
    hubs: Mutex<Hubs>,
    places: Arc<Semaphore>,
}

#[derive(Debug, Default)]
struct Hubs {
    by_topic: HashMap<Topic, Hub>,
    /// How many there have been, those that are forgotten too.
    made: u64,
}

#[derive(Debug)]
struct Hub {
    /// Tells ids of this hub from those of one that was forgotten.
    id: u64,
    sender: broadcast::Sender<Arc<Event>>,
    recent: VecDeque<Arc<Event>>,
    next: u64,
    used: Instant,
}

/// What a new listener gets.
#[derive(Debug)]
pub struct Subscription {
    /// Whether events were missed that nobody remembers.
    pub resync: bool,
    /// Events since the id that the listener named.
    pub missed: Vec<Arc<Event>>,
    /// Events from now on.
    pub receiver: broadcast::Receiver<Arc<Event>>,
}

impl Events {
    /// No hubs yet.
    pub fn new() -> Self {
        let life = brood_protocol::RequestId::fresh().to_string();
        let places = Arc::new(Semaphore::new(limit::EVENT_STREAMS));
        Self { life: life.replace('-', ""), hubs: Mutex::default(), places }
    }

    /// A place for one more stream, held as long as the stream is open; none where too many are.
    pub fn place(&self) -> Option<OwnedSemaphorePermit> {
        self.places.clone().try_acquire_owned().ok()
    }

    /// The id of an event on the wire.
    pub fn id(&self, event: &Event) -> String {
        format!("{}-{}-{}", self.life, event.hub, event.number)
    }

    /// Tells that a generation was born.
    pub fn generation(&self, lineage: LineageId, id: GenerationId) {
        self.publish(lineage, "generation", &json!({ "id": id }));
    }

    /// Tells that a lineage's name, scene or defaults were changed.
    pub fn lineage(&self, id: LineageId, version: u64) {
        self.publish(id, "lineage", &json!({ "version": version }));
    }

    /// Tells that a person has marked an individual.
    pub fn individual(&self, of: &StoredIndividual) {
        let data = json!({ "id": of.id, "favourite": of.favourite, "note": of.note, "version": of.version });
        self.publish(of.lineage, "individual", &data);
    }

    /// Tells that a picture is there.
    pub fn thumbnail(&self, lineage: LineageId, individual: IndividualId, url: &str) {
        self.publish(lineage, "thumbnail", &json!({ "individual": individual, "url": url }));
    }

    /// Tells those who listen to a search.
    pub fn job(&self, id: JobId, name: &'static str, data: &Value) {
        self.publish(id, name, data);
    }

    /// Tells of a search where its results are born.
    pub fn job_in(&self, lineage: LineageId, data: &Value) {
        self.publish(lineage, "job", data);
    }

    /// Listens, from the event after `last_id` on.
    pub fn subscribe(&self, topic: impl Into<Topic>, last_id: Option<&str>) -> Subscription {
        let mut hubs = self.lock();
        let hub = hubs.of(topic.into());
        let receiver = hub.sender.subscribe();
        let Some(last_id) = last_id else {
            return Subscription { resync: false, missed: Vec::new(), receiver };
        };
        let number = last_id.strip_prefix(&format!("{}-{}-", self.life, hub.id));
        let number = number.and_then(|number| number.parse::<u64>().ok());
        let oldest = hub.next - hub.recent.len() as u64;
        match number.filter(|number| number + 1 >= oldest && *number < hub.next) {
            Some(number) => {
                let missed = hub.recent.iter().filter(|event| event.number > number);
                Subscription { resync: false, missed: missed.cloned().collect(), receiver }
            }
            None => Subscription { resync: true, missed: Vec::new(), receiver },
        }
    }

    /// Forgets hubs that nobody uses.
    pub fn sweep(&self) {
        self.forget(FORGET);
    }

    fn forget(&self, after: Duration) {
        let wanted = |hub: &Hub| hub.sender.receiver_count() > 0 || hub.used.elapsed() < after;
        self.lock().by_topic.retain(|_, hub| wanted(hub));
    }

    fn publish(&self, topic: impl Into<Topic>, name: &'static str, data: &Value) {
        let mut hubs = self.lock();
        let hub = hubs.of(topic.into());
        let event = Arc::new(Event { hub: hub.id, number: hub.next, name, data: data.to_string() });
        hub.next += 1;
        hub.recent.push_back(event.clone());
        if hub.recent.len() > REMEMBERED {
            hub.recent.pop_front();
        }
        // Without a listener there is nobody to miss it.
        let _ = hub.sender.send(event);
    }

    fn lock(&self) -> MutexGuard<'_, Hubs> {
        self.hubs.lock().expect("nothing panics under this lock")
    }
}

impl Hubs {
    /// The topic's hub, made where there is none.
    fn of(&mut self, topic: Topic) -> &mut Hub {
        let hub = self.by_topic.entry(topic).or_insert_with(|| {
            self.made += 1;
            Hub::new(self.made)
        });
        hub.used = Instant::now();
        hub
    }
}

impl Hub {
    fn new(id: u64) -> Self {
        Self {
            id,
            sender: broadcast::Sender::new(REMEMBERED),
            recent: VecDeque::new(),
            next: 1,
            used: Instant::now(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn listener_gets_what_it_missed_when_it_comes_back() {
        let events = Events::new();
        let lineage = LineageId::fresh();
        let mut first = events.subscribe(lineage, None);
        let ids: Vec<_> = (0..3).map(|_| GenerationId::fresh()).collect();
        ids.iter().for_each(|id| events.generation(lineage, *id));
        let seen = events.id(&first.receiver.recv().await.unwrap());
        drop(first);
        let again = events.subscribe(lineage, Some(&seen));
        assert!(!again.resync);
        let data: Vec<_> = again.missed.iter().map(|event| event.data.clone()).collect();
        assert_eq!(
            data,
            ids[1..].iter().map(|id| format!("{{\"id\":\"{id}\"}}")).collect::<Vec<_>>()
        );
    }

    #[test]
    fn listener_is_told_to_resync_when_events_are_lost() {
        let events = Events::new();
        let lineage = LineageId::fresh();
        events.generation(lineage, GenerationId::fresh());
        let first = events.id(&events.lock().by_topic[&Topic::Lineage(lineage)].recent[0]);
        for _ in 0..REMEMBERED + 1 {
            events.generation(lineage, GenerationId::fresh());
        }
        assert!(events.subscribe(lineage, Some(&first)).resync, "forgotten");
        assert!(events.subscribe(lineage, Some("0-1")).resync, "of another life");
        assert!(events.subscribe(lineage, Some("x")).resync, "no id at all");
        let future = format!("{}-1-99999", events.life);
        assert!(events.subscribe(lineage, Some(&future)).resync, "of the future");
    }

    #[tokio::test]
    async fn listener_is_told_to_resync_when_its_hub_was_forgotten() {
        let events = Events::new();
        let lineage = LineageId::fresh();
        let mut first = events.subscribe(lineage, None);
        events.generation(lineage, GenerationId::fresh());
        let seen = events.id(&first.receiver.recv().await.unwrap());
        events.forget(Duration::ZERO);
        assert!(!events.subscribe(lineage, Some(&seen)).resync, "kept while somebody listens");
        drop(first);
        events.forget(Duration::ZERO);
        assert!(events.subscribe(lineage, Some(&seen)).resync, "before anything is told again");
        for _ in 0..3 {
            events.generation(lineage, GenerationId::fresh());
        }
        let again = events.subscribe(lineage, Some(&seen));
        assert!(again.resync && again.missed.is_empty(), "the new hub has that number too");
    }

    #[test]
    fn place_is_refused_until_a_stream_ends_when_too_many_are_open() {
        let events = Events::new();
        let mut places: Vec<_> = (0..limit::EVENT_STREAMS).map_while(|_| events.place()).collect();
        assert_eq!(places.len(), limit::EVENT_STREAMS);
        assert!(events.place().is_none());
        places.pop();
        assert!(events.place().is_some());
    }

    #[tokio::test]
    async fn slow_listener_lags_instead_of_blocking() {
        let events = Events::new();
        let lineage = LineageId::fresh();
        let mut slow = events.subscribe(lineage, None).receiver;
        for _ in 0..2 * REMEMBERED {
            events.generation(lineage, GenerationId::fresh());
        }
        assert!(matches!(slow.recv().await, Err(broadcast::error::RecvError::Lagged(_))));
    }
}
