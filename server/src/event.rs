//! Event hubs, one per lineage or search that clients listen to, with a bounded history for clients
//! that reconnect.

use std::borrow::Cow;
use std::collections::{HashMap, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::{Duration, Instant};

use brood_protocol::{GenerationId, IndividualId, JobId, LineageId};
use brood_storage::StoredIndividual;
use serde_json::{Value, json};
use tokio::sync::{OwnedSemaphorePermit, Semaphore, broadcast};

use crate::bus::Peers;
use crate::limit;

pub use crate::bus::Topic;

/// Events kept per hub, and the most that a listener may lag behind.
const HUB_EVENTS: usize = 1024;
/// Time without listeners and events after which a hub is dropped.
const HUB_TTL: Duration = Duration::from_secs(600);
/// Most hubs; each takes 32 KB. If there are more, the one without listeners that was unused the
/// longest is dropped.
const HUBS: usize = 2 * limit::EVENT_STREAMS;

/// Type of the event that asks a client to read the state again.
pub const RESYNC: &str = "resync";

/// Event of a lineage or a search.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Event {
    /// Number of the hub, unique within the process.
    pub hub: u64,
    /// Number of the event within the hub.
    pub number: u64,
    /// Event type on the wire.
    pub name: Cow<'static, str>,
    /// Event data as JSON.
    pub data: String,
}

/// Hubs of lineages and searches that have listeners, or had some lately.
#[derive(Debug)]
pub struct Events {
    /// Random id of this process, which invalidates event ids from before a restart.
    process: String,
    hubs: Mutex<Hubs>,
    /// The other servers, whose clients may listen to the same subjects.
    peers: Peers,
    stream_permits: Arc<Semaphore>,
}

#[derive(Debug, Default)]
struct Hubs {
    by_topic: HashMap<Topic, Hub>,
    /// Number of hubs created so far, including dropped ones.
    made: u64,
}

#[derive(Debug)]
struct Hub {
    /// Number of the hub, which invalidates event ids of a dropped hub.
    id: u64,
    sender: broadcast::Sender<Arc<Event>>,
    recent: VecDeque<Arc<Event>>,
    next: u64,
    used: Instant,
}

/// Start of an event stream.
#[derive(Debug)]
pub struct Subscription {
    /// True if events were missed that are no longer kept.
    pub resync: bool,
    /// Events since the id given by the client.
    pub missed: Vec<Arc<Event>>,
    /// Receiver of later events.
    pub receiver: broadcast::Receiver<Arc<Event>>,
}

impl Events {
    /// Creates an empty set of hubs. Events go to the other servers, too.
    pub fn new(peers: Peers) -> Self {
        let process = brood_protocol::RequestId::fresh().to_string();
        let stream_permits = Arc::new(Semaphore::new(limit::EVENT_STREAMS));
        let process = process.replace('-', "");
        Self { process, hubs: Mutex::default(), peers, stream_permits }
    }

    /// Returns the sender of messages to the other servers.
    pub fn peers(&self) -> &Peers {
        &self.peers
    }

    /// Returns a permit for one more open stream; `None` if there are too many.
    pub fn stream_permit(&self) -> Option<OwnedSemaphorePermit> {
        self.stream_permits.clone().try_acquire_owned().ok()
    }

    /// Returns an event's id on the wire.
    pub fn id(&self, event: &Event) -> String {
        format!("{}-{}-{}", self.process, event.hub, event.number)
    }

    /// Publishes a new generation.
    pub fn generation(&self, lineage: LineageId, id: GenerationId) {
        self.publish(lineage, "generation", &json!({ "id": id }));
    }

    /// Publishes a change of a lineage's name, scene or defaults.
    pub fn lineage(&self, id: LineageId, version: u64) {
        self.publish(id, "lineage", &json!({ "version": version }));
    }

    /// Publishes a change of an individual's favourite mark or note.
    pub fn individual(&self, of: &StoredIndividual) {
        let data = json!({ "id": of.id, "favourite": of.favourite, "note": of.note, "version": of.version });
        self.publish(of.lineage, "individual", &data);
    }

    /// Publishes a new picture.
    pub fn thumbnail(&self, lineage: LineageId, individual: IndividualId, url: &str) {
        self.publish(lineage, "thumbnail", &json!({ "individual": individual, "url": url }));
    }

    /// Publishes an event of a search to its own stream.
    pub fn job(&self, id: JobId, name: &'static str, data: &Value) {
        self.publish(id, name, data);
    }

    /// Publishes an event of a search to its lineage's stream.
    pub fn job_in(&self, lineage: LineageId, data: &Value) {
        self.publish(lineage, "job", data);
    }

    /// Subscribes to a topic, starting after the event `last_id`.
    pub fn subscribe(&self, topic: impl Into<Topic>, last_id: Option<&str>) -> Subscription {
        let mut hubs = self.lock();
        let hub = hubs.of(topic.into());
        let receiver = hub.sender.subscribe();
        let Some(last_id) = last_id else {
            return Subscription { resync: false, missed: Vec::new(), receiver };
        };
        let number = last_id.strip_prefix(&format!("{}-{}-", self.process, hub.id));
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

    /// Drops unused hubs.
    pub fn sweep(&self) {
        self.drop_unused(HUB_TTL);
    }

    fn drop_unused(&self, after: Duration) {
        let is_used = |hub: &Hub| hub.sender.receiver_count() > 0 || hub.used.elapsed() < after;
        self.lock().by_topic.retain(|_, hub| is_used(hub));
    }

    /// Delivers an event of another server to the listeners of this one.
    pub fn deliver(&self, topic: Topic, name: impl Into<Cow<'static, str>>, data: String) {
        // Without a listener so far, there is none who can have missed it.
        if let Some(hub) = self.lock().by_topic.get_mut(&topic) {
            hub.send(name.into(), data);
        }
    }

    /// Asks the listeners of a topic to read its state again.
    pub fn resync(&self, topic: Topic) {
        self.deliver(topic, RESYNC, "{}".to_owned());
    }

    /// Asks all listeners to read the state of their topics again.
    pub fn resync_all(&self) {
        for hub in self.lock().by_topic.values_mut() {
            hub.send(RESYNC.into(), "{}".to_owned());
        }
    }

    fn publish(&self, topic: impl Into<Topic>, name: &'static str, data: &Value) {
        let (topic, data) = (topic.into(), data.to_string());
        self.peers.tell_event(topic, name, &data);
        self.deliver(topic, name, data);
    }

    fn lock(&self) -> MutexGuard<'_, Hubs> {
        self.hubs.lock().expect("nothing panics under this lock")
    }
}

impl Hubs {
    /// Returns the topic's hub, created if missing.
    fn of(&mut self, topic: Topic) -> &mut Hub {
        if self.by_topic.len() >= HUBS && !self.by_topic.contains_key(&topic) {
            let unused = self.by_topic.iter().filter(|(_, hub)| hub.sender.receiver_count() == 0);
            let oldest = unused.min_by_key(|(_, hub)| hub.used).map(|(topic, _)| *topic);
            oldest.and_then(|topic| self.by_topic.remove(&topic));
        }
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
            sender: broadcast::Sender::new(HUB_EVENTS),
            recent: VecDeque::new(),
            next: 1,
            used: Instant::now(),
        }
    }

    fn send(&mut self, name: Cow<'static, str>, data: String) {
        self.used = Instant::now();
        let event = Arc::new(Event { hub: self.id, number: self.next, name, data });
        self.next += 1;
        self.recent.push_back(event.clone());
        if self.recent.len() > HUB_EVENTS {
            self.recent.pop_front();
        }
        // Without listeners, sending fails; this is fine.
        let _ = self.sender.send(event);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn listener_gets_missed_events_when_it_reconnects() {
        let events = Events::new(Peers::default());
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
    fn subscription_asks_to_resync_when_events_are_lost() {
        let events = Events::new(Peers::default());
        let lineage = LineageId::fresh();
        events.subscribe(lineage, None);
        events.generation(lineage, GenerationId::fresh());
        let first = events.id(&events.lock().by_topic[&Topic::Lineage(lineage)].recent[0]);
        for _ in 0..HUB_EVENTS + 1 {
            events.generation(lineage, GenerationId::fresh());
        }
        assert!(events.subscribe(lineage, Some(&first)).resync, "an event that is no longer kept");
        assert!(events.subscribe(lineage, Some("0-1")).resync, "an id of another process");
        assert!(events.subscribe(lineage, Some("x")).resync, "a malformed id");
        let future = format!("{}-1-99999", events.process);
        assert!(events.subscribe(lineage, Some(&future)).resync, "an id of the future");
    }

    #[tokio::test]
    async fn subscription_asks_to_resync_when_its_hub_was_dropped() {
        let events = Events::new(Peers::default());
        let lineage = LineageId::fresh();
        let mut first = events.subscribe(lineage, None);
        events.generation(lineage, GenerationId::fresh());
        let seen = events.id(&first.receiver.recv().await.unwrap());
        events.drop_unused(Duration::ZERO);
        assert!(!events.subscribe(lineage, Some(&seen)).resync, "a hub with a listener is kept");
        drop(first);
        events.drop_unused(Duration::ZERO);
        assert!(events.subscribe(lineage, Some(&seen)).resync, "before the next event");
        for _ in 0..3 {
            events.generation(lineage, GenerationId::fresh());
        }
        let again = events.subscribe(lineage, Some(&seen));
        assert!(
            again.resync && again.missed.is_empty(),
            "an id of the dropped hub, whose number the new hub also has"
        );
    }

    #[test]
    fn only_lineages_with_listeners_have_hubs_and_their_number_is_bounded() {
        let events = Events::new(Peers::default());
        events.generation(LineageId::fresh(), GenerationId::fresh());
        assert!(events.lock().by_topic.is_empty());
        let kept = LineageId::fresh();
        let listener = events.subscribe(kept, None);
        for _ in 0..2 * HUBS {
            events.subscribe(LineageId::fresh(), None);
        }
        assert_eq!(events.lock().by_topic.len(), HUBS);
        events.generation(kept, GenerationId::fresh());
        assert_eq!(listener.receiver.len(), 1, "a hub with a listener stays");
    }

    #[test]
    fn place_is_refused_until_a_stream_ends_when_too_many_are_open() {
        let events = Events::new(Peers::default());
        let mut stream_permits: Vec<_> =
            (0..limit::EVENT_STREAMS).map_while(|_| events.stream_permit()).collect();
        assert_eq!(stream_permits.len(), limit::EVENT_STREAMS);
        assert!(events.stream_permit().is_none());
        stream_permits.pop();
        assert!(events.stream_permit().is_some());
    }

    #[tokio::test]
    async fn slow_listener_lags_instead_of_blocking() {
        let events = Events::new(Peers::default());
        let lineage = LineageId::fresh();
        let mut slow = events.subscribe(lineage, None).receiver;
        for _ in 0..2 * HUB_EVENTS {
            events.generation(lineage, GenerationId::fresh());
        }
        assert!(matches!(slow.recv().await, Err(broadcast::error::RecvError::Lagged(_))));
    }
}
