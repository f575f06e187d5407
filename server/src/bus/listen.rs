//! Effects of the messages of the other servers.

use brood_storage::{BusEvent, BusLink};
use tokio_util::sync::CancellationToken;

use super::message::Message;
use super::removal::forget_removed;
use crate::dispatch::JobKind;
use crate::state::App;

/// Receives the messages of the other servers and sends those of this one until `stop`, then sends
/// the messages that wait.
pub async fn exchange_messages(app: App, link: BusLink, stop: CancellationToken) {
    let on = |event| match event {
        BusEvent::Gap => {
            tracing::debug!("messages of other servers were lost");
            app.events.resync_all();
            forget_removed(&app);
            app.searches.lane(()).notify.notify_one();
            app.exports.lane(()).notify.notify_one();
        }
        BusEvent::Message(text) => match serde_json::from_str(&text) {
            Ok(Message::Event { topic, name, data }) => app.events.deliver(topic, name, data),
            Ok(Message::Missed(topic)) => app.events.resync(topic),
            Ok(Message::SearchWaits) => app.searches.lane(()).notify.notify_one(),
            Ok(Message::ExportWaits) => app.exports.lane(()).notify.notify_one(),
            Ok(Message::GenomesRemoved) => forget_removed(&app),
            // A server of another version sends what this one does not know.
            Err(error) => tracing::debug!(%error, "a message of another server is not known"),
        },
    };
    link.run(stop.cancelled(), on).await;
}
