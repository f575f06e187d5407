//! Tests of large files in an object store: `BROOD_TEST_BLOBS` is the bucket of an S3 server, and
//! `AWS_ENDPOINT`, `AWS_ACCESS_KEY_ID` and `AWS_SECRET_ACCESS_KEY` are set. They do nothing without
//! it and `BROOD_TEST_DATABASE`.

use std::net::SocketAddr;
use std::sync::Mutex;

use brood_protocol::{LightAssetKind, MeshId, SearchState, TargetId};
use futures::TryStreamExt as _;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::watch;

use super::search::{claim, search, step, target};
use super::*;
use crate::blob::ROW_BYTES;
use crate::blob_store::{BlobKind, Blobs};
use crate::{BlobAddress, ClaimedSearch, NewTarget, SearchStep, StoredMesh};

/// Time to live of the leases.
const LEASE: Duration = Duration::from_secs(20);

/// Connections to the S3 server, which a test can cut.
struct Link {
    endpoint: SocketAddr,
    is_cut: watch::Sender<bool>,
}

impl Link {
    async fn to(server: SocketAddr) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let endpoint = listener.local_addr().unwrap();
        let (is_cut, cut) = watch::channel(false);
        tokio::spawn(async move {
            while let Ok((stream, _)) = listener.accept().await {
                if !*cut.borrow() {
                    tokio::spawn(relay(stream, server, cut.clone()));
                }
            }
        });
        Self { endpoint, is_cut }
    }

    /// Variables of a store that is reached through this link.
    fn variables(&self) -> Vec<(String, String)> {
        let own = ("AWS_ENDPOINT".to_owned(), format!("http://{}", self.endpoint));
        std::env::vars().filter(|(name, _)| *name != own.0).chain([own.clone()]).collect()
    }

    fn cut(&self, is_cut: bool) {
        self.is_cut.send_replace(is_cut);
    }
}

async fn relay(mut from: TcpStream, server: SocketAddr, mut cut: watch::Receiver<bool>) {
    let Ok(mut to) = TcpStream::connect(server).await else { return };
    let until_cut = async {
        while !*cut.borrow_and_update() {
            if cut.changed().await.is_err() {
                return;
            }
        }
    };
    tokio::select! {
        _ = tokio::io::copy_bidirectional(&mut from, &mut to) => {}
        () = until_cut => {}
    }
}

/// Database and object store of a test.
struct Fixture {
    database: DatabaseAddress,
    /// Data directories of the servers.
    data: Mutex<Vec<TempDir>>,
    link: Link,
    bucket: String,
    address: BlobAddress,
}

impl Fixture {
    /// `None` without an S3 server and PostgreSQL.
    async fn new() -> Option<Self> {
        let bucket = std::env::var("BROOD_TEST_BLOBS").ok()?;
        let Place::Schema(database, data) = Place::new().await else { return None };
        let endpoint = std::env::var("AWS_ENDPOINT").unwrap();
        let server = endpoint.strip_prefix("http://").unwrap().parse().unwrap();
        let link = Link::to(server).await;
        let address = folder(&bucket);
        Some(Self { database, data: Mutex::new(vec![data]), link, bucket, address })
    }

    /// Opens the store of a server that uses no object store.
    async fn plain(&self) -> Store {
        let data = tempfile::tempdir().unwrap();
        let store = Store::connect(&self.database, data.path()).await.unwrap();
        self.data.lock().unwrap().push(data);
        store
    }

    async fn open(&self) -> Store {
        self.open_with(Some(&self.address)).await.unwrap()
    }

    async fn open_with(&self, address: Option<&BlobAddress>) -> Result<Store, StorageError> {
        self.plain().await.with_blobs_at(address, self.link.variables()).await
    }
}

/// Address of an empty folder of a bucket.
fn folder(bucket: &str) -> BlobAddress {
    format!("{bucket}/{}", JobId::fresh()).parse().unwrap()
}

fn large(byte: u8) -> Vec<u8> {
    vec![byte; ROW_BYTES + 1]
}

fn blobs(store: &Store) -> &Blobs {
    store.blobs().unwrap()
}

/// Names of all objects.
async fn objects(store: &Store) -> Vec<String> {
    let pages: Vec<_> = blobs(store).list().try_collect().await.unwrap();
    pages.into_iter().flatten().map(|found| found.name).collect()
}

/// Waits until the store has this number of objects.
async fn objects_become(store: &Store, count: usize) -> Vec<String> {
    for _ in 0..200 {
        let names = objects(store).await;
        if names.len() == count {
            return names;
        }
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    panic!("{:?}", objects(store).await);
}

/// Removes all objects without a row. Returns their number.
async fn sweep_all(store: &Store) -> u64 {
    // The clock of the object store has seconds.
    tokio::time::sleep(Duration::from_millis(1100)).await;
    store.sweep_blobs(Duration::ZERO).await.unwrap()
}

fn new_target(name: &str, bytes: Vec<u8>) -> NewTarget {
    NewTarget { hash: hash(name), bytes, ..target() }
}

/// Step with a large checkpoint of one value.
fn large_step(claimed: &ClaimedSearch, generation: u32, byte: u8) -> SearchStep {
    let checkpoint = Some((large(byte), hash("state")));
    SearchStep { checkpoint, ..step(claimed, generation..=generation) }
}

/// Queues a search on a large target, with a large checkpoint. Returns target, lineage and search.
async fn waiting_search(store: &Store) -> (TargetId, LineageId, JobId) {
    let new = new_target("large", large(3));
    let of = new.target.id;
    store.create_target(new).await.unwrap();
    let lineage = lineage(store).await;
    let id = search(store, of, lineage).await;
    let claimed = claim(store).await;
    store.step_search(large_step(&claimed, 1, 1)).await.unwrap();
    store.release_search(id, claimed.epoch, false, 30).await.unwrap();
    (of, lineage, id)
}

#[tokio::test]
async fn large_files_are_objects_and_others_rows() {
    let Some(fixture) = Fixture::new().await else { return };
    let store = fixture.open().await;
    store.create_target(new_target("small", vec![1; ROW_BYTES])).await.unwrap();
    store.put_light_asset(hash("l"), LightAssetKind::Image, vec![2; ROW_BYTES]).await.unwrap();
    assert!(objects(&store).await.is_empty());

    let first = new_target("large", large(3));
    let id = first.target.id;
    store.create_target(first).await.unwrap();
    store.put_light_asset(hash("m"), LightAssetKind::Environment, large(4)).await.unwrap();
    let mesh = StoredMesh {
        id: MeshId::fresh(),
        content_hash: hash("cow"),
        vertices: 3,
        triangles: 1,
        has_uv: true,
        warnings_json: "[]".to_owned(),
    };
    assert_eq!(store.put_mesh(mesh.clone(), large(5)).await.unwrap(), mesh.id);
    let three = objects_become(&store, 3).await;
    // Another server reads them.
    let other = fixture.open().await;
    assert_eq!(other.target_file(hash("small")).await.unwrap(), vec![1; ROW_BYTES]);
    assert!(other.target_file(hash("large")).await.unwrap() == large(3));
    let (kind, bytes) = other.light_asset(hash("m")).await.unwrap();
    assert!(kind == LightAssetKind::Environment && bytes == large(4));
    assert!(other.mesh_data(hash("cow")).await.unwrap() == large(5));

    // Equal files are stored once. An object that was lost is replaced.
    for name in three {
        blobs(&store).remove(&name).await.unwrap();
    }
    let again = StoredMesh { id: MeshId::fresh(), ..mesh.clone() };
    assert_eq!(other.put_mesh(again, large(5)).await.unwrap(), mesh.id);
    other.put_light_asset(hash("m"), LightAssetKind::Environment, large(4)).await.unwrap();
    let twin = new_target("large", large(3));
    let twin_id = twin.target.id;
    other.create_target(twin).await.unwrap();
    objects_become(&store, 3).await;
    assert!(store.mesh_data(hash("cow")).await.unwrap() == large(5));
    assert!(store.light_asset(hash("m")).await.unwrap().1 == large(4));

    store.delete_target(id).await.unwrap();
    assert!(store.target_file(hash("large")).await.unwrap() == large(3));
    store.delete_target(twin_id).await.unwrap();
    assert!(matches!(store.target_file(hash("large")).await, Err(StorageError::NotFound)));
    assert_eq!((sweep_all(&store).await, objects(&store).await.len()), (1, 2));
}

#[tokio::test]
async fn checkpoint_replaces_the_one_before_whose_object_is_kept_for_a_while() {
    let Some(fixture) = Fixture::new().await else { return };
    let store = fixture.open().await;
    let new = target();
    let of = new.target.id;
    store.create_target(new).await.unwrap();
    let lineage = lineage(&store).await;
    let id = search(&store, of, lineage).await;
    let claimed = claim(&store).await;
    store.step_search(large_step(&claimed, 1, 1)).await.unwrap();
    store.step_search(large_step(&claimed, 2, 2)).await.unwrap();
    objects_become(&store, 2).await;

    // A step without a lease leaves no object.
    let stale = SearchStep { epoch: claimed.epoch + 1, ..large_step(&claimed, 3, 9) };
    let stale = store.step_search(stale).await;
    assert!(matches!(stale, Err(StorageError::Conflict { .. })), "{stale:?}");
    objects_become(&store, 2).await;
    assert_eq!(sweep_all(&store).await, 1);

    store.release_search(id, claimed.epoch, false, 30).await.unwrap();
    let claimed = claim(&fixture.open().await).await;
    assert_eq!(claimed.generation, 2);
    assert!(claimed.checkpoint.as_deref() == Some(&large(2)[..]));
    store.step_search(step(&claimed, 3..=3)).await.unwrap();
    assert_eq!(sweep_all(&store).await, 1);
    store.release_search(id, claimed.epoch, false, 30).await.unwrap();
    assert_eq!(claim(&store).await.checkpoint, Some(vec![5; 9]));
}

#[tokio::test]
async fn unreachable_store_refuses_files_and_lets_searches_wait() {
    let Some(fixture) = Fixture::new().await else { return };
    let store = fixture.open().await;
    let (of, lineage, with_object) = waiting_search(&store).await;
    let without = search(&store, of, lineage).await;

    fixture.link.cut(true);
    let refused = store.create_target(new_target("other", large(4))).await;
    assert!(matches!(refused, Err(StorageError::BlobsUnreachable(_))), "{refused:?}");
    store.create_target(new_target("small", vec![1])).await.unwrap();
    let unread = store.target_file(hash("large")).await;
    assert!(matches!(unread, Err(StorageError::BlobsUnreachable(_))), "{unread:?}");
    let failed = store.claim_search("worker", LEASE, 20).await;
    assert!(matches!(failed, Err(StorageError::BlobsUnreachable(_))), "{failed:?}");
    let waiting = store.search(with_object).await.unwrap();
    assert_eq!((waiting.state, waiting.deaths), (SearchState::Queued, 0));
    // It does not hold up others.
    let other = claim(&store).await;
    assert_eq!(other.id, without);
    let unsaved = store.step_search(large_step(&other, 1, 1)).await;
    assert!(matches!(unsaved, Err(StorageError::BlobsUnreachable(_))), "{unsaved:?}");
    // A server starts without the store.
    drop(fixture.open().await);

    fixture.link.cut(false);
    store.step_search(large_step(&other, 1, 1)).await.unwrap();
    let again = claim(&store).await;
    assert_eq!((again.id, again.generation), (with_object, 1));
    assert!(again.checkpoint.as_deref() == Some(&large(1)[..]));
    assert!(store.target_file(hash("large")).await.unwrap() == large(3));
}

#[tokio::test]
async fn sweep_removes_old_objects_without_a_row() {
    let Some(fixture) = Fixture::new().await else { return };
    let store = fixture.open().await;
    store.create_target(new_target("kept", large(3))).await.unwrap();
    let kept = objects_become(&store, 1).await;
    for kind in [BlobKind::Checkpoint, BlobKind::Target, BlobKind::Mesh] {
        blobs(&store).put(kind, vec![1; 9]).await.unwrap();
    }
    assert_eq!(store.sweep_blobs(Duration::from_secs(3600)).await.unwrap(), 0);
    assert_eq!(sweep_all(&store).await, 3);
    assert_eq!(objects(&store).await, kept);
    assert!(store.target_file(hash("kept")).await.unwrap() == large(3));
    fixture.link.cut(true);
    let unreachable = store.sweep_blobs(Duration::ZERO).await;
    assert!(matches!(unreachable, Err(StorageError::BlobsUnreachable(_))), "{unreachable:?}");
}

#[tokio::test]
async fn servers_of_a_database_have_the_same_store() {
    let Some(fixture) = Fixture::new().await else { return };
    let elsewhere = folder(&fixture.bucket);
    let first = fixture.open_with(Some(&elsewhere)).await.unwrap();
    // Nothing is stored there yet. The other database there stays the owner.
    assert_eq!(blobs(&first).claim("another").await.unwrap(), blobs(&first).owner().await.unwrap());
    let store = fixture.open().await;
    let late = first.create_target(new_target("large", large(3))).await;
    assert!(matches!(late, Err(StorageError::BlobsUnreachable(_))), "{late:?}");
    drop(fixture.open_with(None).await.unwrap());
    let unaware = fixture.plain().await;
    store.create_target(new_target("large", large(3))).await.unwrap();

    for other in [None, Some(&elsewhere)] {
        let refused = fixture.open_with(other).await.unwrap_err().to_string();
        let address = &fixture.address;
        let expected = format!(
            "files of the database are in the object store {address}; start this with --blobs \
             {address}"
        );
        assert_eq!(refused, expected);
    }
    // A server that has run since before cannot read the file, but loses nothing.
    let unread = unaware.target_file(hash("large")).await;
    assert!(matches!(unread, Err(StorageError::BlobsUnreachable(_))), "{unread:?}");
    let mut conn = store.reader().await.unwrap();
    let oldest = query("SELECT oldest FROM _brood_step WHERE version = 4");
    assert_eq!(oldest.fetch_value::<i64>(&mut conn).await.unwrap(), 4);
}

#[tokio::test]
async fn folder_of_another_database_is_refused() {
    let (Some(one), Some(other)) = (Fixture::new().await, Fixture::new().await) else { return };
    let store = one.open().await;
    let refused = other.open_with(Some(&one.address)).await.unwrap_err().to_string();
    assert!(refused.contains("belongs to another database"), "{refused}");
    drop(other.open_with(None).await.unwrap());
    // Its sweep removes nothing either.
    store.create_target(new_target("large", large(3))).await.unwrap();
    blobs(&store).overwrite("owner", "another").await;
    tokio::time::sleep(Duration::from_millis(1100)).await;
    let refused = store.sweep_blobs(Duration::ZERO).await;
    assert!(matches!(refused, Err(StorageError::BlobsUnreachable(_))), "{refused:?}");
    assert_eq!(objects(&store).await.len(), 1);
}

#[tokio::test]
async fn store_at_another_endpoint_gets_no_files() {
    let Some(fixture) = Fixture::new().await else { return };
    let store = fixture.open().await;
    let (_, _, id) = waiting_search(&store).await;
    // As at an endpoint with a bucket of the same name.
    let there = objects(&store).await;
    for name in there.iter().map(String::as_str).chain(["owner"]) {
        blobs(&store).remove(name).await.unwrap();
    }
    let other = fixture.open().await;
    let refused = other.create_target(new_target("other", large(4))).await;
    let words = refused.unwrap_err().to_string();
    assert!(words.contains("AWS_ENDPOINT"), "{words}");
    let unread = other.target_file(hash("large")).await;
    assert!(matches!(unread, Err(StorageError::BlobsUnreachable(_))), "{unread:?}");
    // The search waits for a server with the right endpoint.
    let failed = other.claim_search("worker", LEASE, 20).await;
    assert!(matches!(failed, Err(StorageError::BlobsUnreachable(_))), "{failed:?}");
    assert_eq!(other.search(id).await.unwrap().state, SearchState::Queued);

    // Where the database owns the folder, the checkpoint is lost.
    let owner = query("SELECT owner FROM blob_store");
    let owner: String = owner.fetch_value(&mut store.reader().await.unwrap()).await.unwrap();
    assert_eq!(blobs(&other).claim(&owner).await.unwrap(), Some(owner));
    assert!(claim(&other).await.lost_checkpoint.is_some());
}

#[tokio::test]
async fn store_that_takes_no_object_is_refused_at_its_first_use() {
    let Some(fixture) = Fixture::new().await else { return };
    fixture.link.cut(true);
    let refused = fixture.open_with(Some(&fixture.address)).await;
    assert!(matches!(refused, Err(StorageError::BlobsUnreachable(_))), "{refused:?}");
    fixture.link.cut(false);
    let mut variables = fixture.link.variables();
    variables.retain(|(name, _)| name != "AWS_SECRET_ACCESS_KEY");
    variables.push(("AWS_SECRET_ACCESS_KEY".to_owned(), "other".to_owned()));
    let store = fixture.plain().await;
    let refused = store.with_blobs_at(Some(&fixture.address), variables).await;
    assert!(matches!(refused, Err(StorageError::BlobsUnreachable(_))), "{refused:?}");
    drop(fixture.open_with(None).await.unwrap());
}

#[tokio::test]
async fn missing_and_changed_objects_are_found() {
    let Some(fixture) = Fixture::new().await else { return };
    let store = fixture.open().await;
    store.create_target(new_target("large", large(3))).await.unwrap();
    let whole = store.check(|_| ()).await.unwrap();
    assert_eq!((whole.files, whole.unread_files, whole.problems.len()), (1, 0, 0));
    let name = objects_become(&store, 1).await.remove(0);
    blobs(&store).remove(&name).await.unwrap();
    let lost = store.target_file(hash("large")).await;
    assert!(matches!(lost, Err(StorageError::BlobDamaged(_))), "{lost:?}");
    let damaged = store.check(|_| ()).await.unwrap();
    let problem = format!("a file of target_file is missing or damaged: {name}");
    assert_eq!((damaged.files, &damaged.problems), (1, &vec![problem]));
    blobs(&store).overwrite(&name, "changed").await;
    let changed = store.target_file(hash("large")).await;
    assert!(matches!(changed, Err(StorageError::BlobDamaged(_))), "{changed:?}");
    assert_eq!(store.check(|_| ()).await.unwrap().problems, damaged.problems);
    let unread = fixture.plain().await.check(|_| ()).await.unwrap();
    assert_eq!((unread.files, unread.unread_files, unread.problems.len()), (0, 1, 0));
}

#[tokio::test]
async fn data_directory_has_no_object_store() {
    let (_dir, store) = open_directory().await;
    let address = "s3://brood-test".parse().unwrap();
    let refused = store.with_blobs_at(Some(&address), Vec::new()).await.unwrap_err().to_string();
    assert!(refused.contains("only beside a PostgreSQL database"), "{refused}");
    let (_dir, store) = open_directory().await;
    assert!(store.with_blobs(None).await.unwrap().blobs().is_none());
}
