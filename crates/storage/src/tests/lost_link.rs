//! Tests of a link to PostgreSQL that loses answers. They do nothing without
//! `BROOD_TEST_DATABASE`, and with a database without TLS.

use std::time::Instant;

use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::tcp::{OwnedReadHalf, OwnedWriteHalf};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::watch;

use super::tls::Encrypted;
use super::*;

/// Longest time for the end of a statement whose answer is lost: a check each second, which waits
/// for 5 s.
const END: Duration = Duration::from_secs(9);

/// Link to PostgreSQL. After a cut, its connections stay open and carry nothing.
struct Link {
    port: u16,
    /// Number of cuts.
    cuts: watch::Sender<u32>,
}

impl Link {
    async fn to(port: u16) -> Self {
        let listener = TcpListener::bind(("127.0.0.1", 0)).await.unwrap();
        let own = listener.local_addr().unwrap().port();
        let cuts = watch::Sender::new(0);
        let cut = cuts.clone();
        tokio::spawn(async move {
            loop {
                let (near, _) = listener.accept().await.unwrap();
                let (near_read, near_write) = near.into_split();
                let far = TcpStream::connect(("127.0.0.1", port)).await.unwrap();
                let (far_read, far_write) = far.into_split();
                tokio::spawn(carry(near_read, far_write, cut.subscribe()));
                tokio::spawn(carry(far_read, near_write, cut.subscribe()));
            }
        });
        Self { port: own, cuts }
    }

    fn cut(&self) {
        self.cuts.send_modify(|cuts| *cuts += 1);
    }
}

/// Carries bytes until the next cut.
async fn carry(mut from: OwnedReadHalf, mut to: OwnedWriteHalf, mut cuts: watch::Receiver<u32>) {
    let mut bytes = vec![0; 1 << 16];
    loop {
        tokio::select! {
            biased;
            _ = cuts.changed() => std::future::pending().await,
            read = from.read(&mut bytes) => match read {
                Ok(0) | Err(_) => return,
                Ok(count) if to.write_all(&bytes[..count]).await.is_err() => return,
                Ok(_) => {}
            },
        }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn statement_whose_answer_is_lost_ends_and_keeps_no_connection() {
    let Some(Encrypted { address, port, .. }) = Encrypted::find().await else { return };
    let link = Link::to(port).await;
    let address = address.replace(&port.to_string(), &link.port.to_string());
    // Of one connection, a lost one would leave none.
    let address = DatabaseAddress::from(address).with_connections(1);
    let data = tempfile::tempdir().unwrap();
    let store = Store::connect(&address, data.path()).await.unwrap();
    let before = lineage(&store).await;

    let busy = store.clone();
    let write = tokio::spawn(async move {
        busy.write(|conn| {
            Box::pin(async move { query("SELECT pg_sleep(1)").execute(conn).await.map(|_| ()) })
        })
        .await
    });
    tokio::time::sleep(Duration::from_millis(300)).await;
    link.cut();
    let start = Instant::now();
    let lost = write.await.unwrap();
    let waited = start.elapsed();
    assert!(matches!(lost, Err(StorageError::Unreachable(_))), "{lost:?}");
    assert!(waited < END, "{waited:?}");

    // New connections are carried. The lock is taken again within a moment.
    let start = Instant::now();
    while store.lineage(before).await.is_err() {
        assert!(start.elapsed() < END);
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    lineage(&store).await;
    link.cut();
    let start = Instant::now();
    store.close().await.unwrap();
    assert!(start.elapsed() < END, "{:?}", start.elapsed());
}
