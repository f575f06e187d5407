//! Messages between the servers of one database, by LISTEN and NOTIFY.
//!
//! A NOTIFY inside the transaction of a fact takes a lock of the whole database until the disk has
//! answered. Messages are therefore sent after it, in batches, on a connection of their own. They
//! can be lost; then the receivers get [`BusEvent::Gap`].

mod seen;

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use brood_protocol::RequestId;
use sqlx::postgres::{PgConnectOptions, PgListener, PgPoolOptions};
use sqlx::{ConnectOptions, Connection, PgConnection};
use tokio::sync::mpsc;
use tokio::time::{sleep, timeout};

use crate::StorageError;
use crate::error::{Result, postgres_error};
use seen::{SILENCE, Seen};

/// Largest batch in bytes. PostgreSQL refuses 8000.
const BATCH_BYTES: usize = 7900;
/// Longest message in bytes.
const MESSAGE_BYTES: usize = 7800;
/// Time for which messages are collected.
const BATCH_WINDOW: Duration = Duration::from_millis(2);
/// Messages that wait to be sent. If there are more, the others get a gap.
const WAITING: usize = 4096;
/// Interval between batches without messages.
const PING: Duration = Duration::from_secs(2);
/// Time for PostgreSQL to answer, after which a connection is replaced.
const ANSWER: Duration = Duration::from_secs(5);
/// Time between attempts to send or connect, and between checks for lost messages.
const RETRY: Duration = Duration::from_millis(500);
/// Time for sending the last messages.
const FLUSH: Duration = Duration::from_secs(2);
/// Statement that returns the channel of a schema.
const CHANNEL: &str = "SELECT 'brood_' || md5(current_schema())";

/// Result of a call of PostgreSQL.
type Called<T> = std::result::Result<T, sqlx::Error>;

/// Event of the bus.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum BusEvent {
    /// Message of another server.
    Message(String),
    /// Unknown messages were lost, or the last ones of a server that has ended.
    Gap,
}

/// Sender of messages to the other servers.
#[derive(Debug, Clone)]
pub struct Bus {
    waiting: mpsc::Sender<String>,
    lost: Arc<AtomicU64>,
}

impl Bus {
    /// Sends a message, a text without line breaks, to the other servers soon. Returns false if it
    /// is too long. It may be lost; then the others get [`BusEvent::Gap`].
    pub fn tell(&self, message: String) -> bool {
        debug_assert!(!message.contains('\n'), "messages are lines");
        if message.len() > MESSAGE_BYTES {
            return false;
        }
        if self.waiting.try_send(message).is_err() {
            self.lost.fetch_add(1, Ordering::Relaxed);
        }
        true
    }
}

/// Connection of a server with the others.
#[derive(Debug)]
pub struct BusLink {
    sender: Sender,
    receiver: Receiver,
}

impl BusLink {
    /// Connects to the bus of a schema.
    pub(super) async fn join(options: PgConnectOptions) -> Result<(Bus, Self)> {
        let connect = async {
            let mut conn = options.connect().await?;
            let channel: String = sqlx::query_scalar(CHANNEL).fetch_one(&mut conn).await?;
            let listener = listen(&options, &channel).await?;
            Ok::<_, sqlx::Error>((conn, channel, listener))
        };
        let connected = timeout(ANSWER, connect).await;
        let connected =
            connected.map_err(|_| StorageError::Unreachable("it does not answer".to_owned()))?;
        let (conn, channel, listener) = connected.map_err(postgres_error)?;
        let (waiting, messages) = mpsc::channel(WAITING);
        let (lost, name) = (Arc::<AtomicU64>::default(), RequestId::fresh().to_string());
        let bus = Bus { waiting, lost: lost.clone() };
        let sender = Sender {
            name: name.clone(),
            channel: channel.clone(),
            options: options.clone(),
            conn: Some(conn),
            waiting: messages,
            lost,
            number: 0,
            next: None,
            batch: None,
        };
        let receiver = Receiver { own: name, channel, options, listener, seen: Seen::default() };
        Ok((bus, Self { sender, receiver }))
    }

    /// Sends and receives until `stop`, then sends the messages that wait, for at most 2 s. Calls
    /// `on` for each message, and for each gap within a few seconds.
    pub async fn run(self, stop: impl Future<Output = ()>, on: impl FnMut(BusEvent)) {
        let Self { mut sender, receiver } = self;
        tokio::select! {
            () = sender.run() => {}
            () = receiver.run(on) => {}
            () = stop => {}
        }
        if timeout(FLUSH, sender.flush()).await.is_err() {
            tracing::warn!("other servers miss the last messages of this one");
        }
    }
}

/// Listens on a new connection. It has a pool of its own: closing a connection that hangs would
/// keep its place.
async fn listen(options: &PgConnectOptions, channel: &str) -> Called<PgListener> {
    let pool = PgPoolOptions::new().max_connections(1).acquire_timeout(ANSWER);
    let mut listener = PgListener::connect_with(&pool.connect_lazy_with(options.clone())).await?;
    // The receiver replaces the whole listener.
    listener.eager_reconnect(false);
    listener.listen(channel).await?;
    Ok(listener)
}

#[derive(Debug)]
struct Sender {
    /// Random name of this server.
    name: String,
    channel: String,
    options: PgConnectOptions,
    /// `None` while it is used, and after an error.
    conn: Option<PgConnection>,
    waiting: mpsc::Receiver<String>,
    lost: Arc<AtomicU64>,
    /// Number of the last batch.
    number: u64,
    /// First message of the next batch.
    next: Option<String>,
    /// Batch that is not sent yet. It is sent again with the same number if the answer is missing.
    batch: Option<String>,
}

impl Sender {
    /// Sends until the future is dropped, which loses no message.
    async fn run(&mut self) {
        loop {
            if self.next.is_none() {
                tokio::select! {
                    Some(message) = self.waiting.recv() => self.next = Some(message),
                    // The batch is empty.
                    () = sleep(PING) => {}
                }
            }
            sleep(BATCH_WINDOW).await;
            self.fill();
            self.send().await;
        }
    }

    /// Sends all messages that wait, and closes the connection.
    async fn flush(&mut self) {
        loop {
            self.send().await;
            self.next = self.next.take().or_else(|| self.waiting.try_recv().ok());
            if self.next.is_none() {
                break;
            }
            self.fill();
        }
        if let Some(conn) = self.conn.take()
            && let Err(error) = conn.close().await
        {
            tracing::debug!(%error, "cannot close a connection of the bus");
        }
    }

    /// Makes a batch of the messages that wait.
    fn fill(&mut self) {
        self.number += 1 + self.lost.swap(0, Ordering::Relaxed);
        let mut batch = format!("{} {}", self.name, self.number);
        while let Some(message) = self.next.take().or_else(|| self.waiting.try_recv().ok()) {
            if batch.len() + 1 + message.len() > BATCH_BYTES {
                self.next = Some(message);
                break;
            }
            batch.push('\n');
            batch.push_str(&message);
        }
        self.batch = Some(batch);
    }

    /// Sends the batch, if there is one, until PostgreSQL has taken it.
    async fn send(&mut self) {
        let mut fails = false;
        while let Some(batch) = self.batch.clone() {
            let error = match timeout(ANSWER, self.notify(batch)).await {
                Ok(Ok(())) => {
                    self.batch = None;
                    break;
                }
                Ok(Err(error)) => error.to_string(),
                Err(_) => "no answer in time".to_owned(),
            };
            if !fails {
                tracing::warn!(error, "cannot send to the other servers; trying again");
            }
            fails = true;
            sleep(RETRY).await;
        }
        if fails {
            tracing::info!("messages reach the other servers again");
        }
    }

    /// Sends a batch. The connection is kept only if PostgreSQL has answered.
    async fn notify(&mut self, batch: String) -> Called<()> {
        let mut conn = match self.conn.take() {
            Some(conn) => conn,
            None => self.options.connect().await?,
        };
        let notify = sqlx::query("SELECT pg_notify($1, $2)");
        notify.bind(self.channel.as_str()).bind(batch).execute(&mut conn).await?;
        self.conn = Some(conn);
        Ok(())
    }
}

#[derive(Debug)]
struct Receiver {
    /// Name of this server.
    own: String,
    channel: String,
    options: PgConnectOptions,
    listener: PgListener,
    seen: Seen,
}

impl Receiver {
    /// Receives until the future is dropped.
    async fn run(mut self, mut on: impl FnMut(BusEvent)) {
        loop {
            self.receive(&mut on).await;
            tracing::warn!("the connection with the other servers is lost; connecting again");
            self.listener = loop {
                match timeout(ANSWER, listen(&self.options, &self.channel)).await {
                    Ok(Ok(again)) => break again,
                    Ok(Err(error)) => tracing::debug!(%error, "cannot connect to the bus"),
                    Err(_) => tracing::debug!("cannot connect to the bus in time"),
                }
                sleep(RETRY).await;
            };
            self.seen.lose_all(Instant::now());
        }
    }

    /// Receives until the connection is lost: it is closed, or without any batch, the own ones
    /// included, for [`SILENCE`].
    async fn receive(&mut self, on: &mut impl FnMut(BusEvent)) {
        let mut last = Instant::now();
        loop {
            match timeout(RETRY, self.listener.try_recv()).await {
                Ok(Ok(Some(batch))) => {
                    last = Instant::now();
                    self.take(batch.payload(), on);
                }
                Ok(_) => return,
                Err(_) if last.elapsed() > SILENCE => return,
                Err(_) => {}
            }
            if self.seen.take_loss(Instant::now()) {
                on(BusEvent::Gap);
            }
        }
    }

    fn take(&mut self, batch: &str, on: &mut impl FnMut(BusEvent)) {
        let mut lines = batch.split('\n');
        let head = lines.next().and_then(|head| head.split_once(' '));
        let Some((name, Ok(number))) = head.map(|(name, number)| (name, number.parse::<u64>()))
        else {
            return tracing::warn!("a message on the bus is not one of brood");
        };
        if name != self.own && self.seen.note(name, number, Instant::now()) {
            for message in lines {
                on(BusEvent::Message(message.to_owned()));
            }
        }
    }
}
