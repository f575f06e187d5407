//! Messages between the servers of one database: events of streams, jobs that wait, removed
//! genomes. They can be lost. A server that detects a loss clears its caches and sends `resync` to
//! its clients.

mod listen;
mod message;
mod removal;

use brood_storage::Bus;

use message::Message;

pub use listen::exchange_messages;
pub use message::Topic;
pub use removal::genomes_removed;

/// Sender of messages to the other servers. Does nothing if there can be none.
#[derive(Debug, Clone, Default)]
pub struct Peers {
    bus: Option<Bus>,
}

impl Peers {
    /// Sends over this bus.
    pub fn new(bus: Option<Bus>) -> Self {
        Self { bus }
    }

    /// Sends an event of a stream.
    pub fn tell_event(&self, topic: Topic, name: &str, data: &str) {
        let Some(bus) = &self.bus else { return };
        let (name, data) = (name.to_owned(), data.to_owned());
        let whole = Message::Event { topic, name, data };
        if !tell(bus, &whole) {
            tell(bus, &Message::Missed(topic));
        }
    }

    /// Says that a search waits for a worker.
    pub fn tell_search(&self) {
        self.tell(&Message::SearchWaits);
    }

    /// Says that an export waits for a worker.
    pub fn tell_export(&self) {
        self.tell(&Message::ExportWaits);
    }

    /// Says that genomes were removed.
    pub fn tell_removal(&self) {
        self.tell(&Message::GenomesRemoved);
    }

    fn tell(&self, message: &Message) {
        if let Some(bus) = &self.bus {
            tell(bus, message);
        }
    }
}

/// Sends a message. False if it is too long.
fn tell(bus: &Bus, message: &Message) -> bool {
    bus.tell(serde_json::to_string(message).expect("messages are plain data"))
}
