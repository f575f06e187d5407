//! Effects of the messages of the other servers.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use brood_storage::{BusEvent, BusLink};
use tokio_util::sync::CancellationToken;

use super::message::Message;
use super::removal::forget_removed;
use crate::dispatch::JobKind;
use crate::state::App;

/// Time in which unknown messages have one effect together.
const UNKNOWN_WINDOW: Duration = Duration::from_secs(2);

/// Receives the messages of the other servers and sends those of this one until `stop`, then sends
/// the messages that wait.
pub async fn exchange_messages(app: App, link: BusLink, stop: CancellationToken) {
    let is_unknown = Arc::<AtomicBool>::default();
    let on = |event| match event {
        BusEvent::Gap => {
            tracing::debug!("messages of other servers were lost");
            catch_up(&app);
        }
        BusEvent::Message(text) => match serde_json::from_str(&text) {
            Ok(Message::Event { topic, name, data }) => app.events.deliver(topic, name, data),
            Ok(Message::Missed(topic)) => app.events.resync(topic),
            Ok(Message::SearchWaits) => app.searches.lane(()).notify.notify_one(),
            Ok(Message::ExportWaits) => app.exports.lane(()).notify.notify_one(),
            Ok(Message::GenomesRemoved) => forget_removed(&app),
            // A server of a later version sends what this one does not know.
            Err(error) => {
                tracing::debug!(%error, "a message of another server is not known");
                if !is_unknown.swap(true, Ordering::Relaxed) {
                    let (app, is_unknown) = (app.clone(), is_unknown.clone());
                    tokio::spawn(async move {
                        tokio::time::sleep(UNKNOWN_WINDOW).await;
                        is_unknown.store(false, Ordering::Relaxed);
                        catch_up(&app);
                    });
                }
            }
        },
    };
    link.run(stop.cancelled(), on).await;
}

/// Does what lost or unknown messages may have asked for: empties caches, and makes clients and
/// workers look again.
fn catch_up(app: &App) {
    app.events.resync_all();
    forget_removed(app);
    app.searches.lane(()).notify.notify_one();
    app.exports.lane(()).notify.notify_one();
}
