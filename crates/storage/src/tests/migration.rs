//! Tests of copies into PostgreSQL. All but the first do nothing without `BROOD_TEST_DATABASE`.

use std::path::Path;

use super::*;
use crate::migrate::copied_columns;
use crate::sql::{Conn, query};
use crate::{DatabaseAddress, Migrated, migrate};

async fn copy(from: &Path, to: &DatabaseAddress) -> Result<Migrated, StorageError> {
    migrate(from, to, |_| {}).await
}

/// Fills a store with rows in most tables. Returns the lineage.
async fn fill(store: &Store) -> LineageId {
    let lineage = lineage(store).await;
    let first = generation(store, lineage, &[], "first").await;
    let parent = first.individuals[1].id;
    let mut new = new_generation(lineage, &[ParentRef::Individual(parent)], "second");
    new.centre = Some(parent);
    let scene = scene(store).await;
    new.pictures = vec![picture("p", "second 0", scene)];
    new.idempotency = Some(idempotency("k"));
    store.create_generation(new).await.unwrap();
    let cover =
        brood_protocol::PatchLineage { cover_individual: Some(Some(parent)), ..Default::default() };
    store.patch_lineage(lineage, 1, cover).await.unwrap();
    store.create_token("laptop", crate::Scope::Read, hash("t"), Some(9)).await.unwrap();
    store.put_light_asset(hash("l"), brood_protocol::LightAssetKind::Image, vec![1]).await.unwrap();
    lineage
}

#[tokio::test]
async fn all_columns_are_copied() {
    let (_place, store) = open().await;
    let mut conn = store.reader().await.unwrap();
    let sql = match conn {
        Conn::Sqlite(_) => {
            "SELECT t.name || '.' || c.name AS name
             FROM sqlite_schema AS t, pragma_table_info(t.name) AS c WHERE t.type = 'table'"
        }
        Conn::Postgres(_) => {
            "SELECT table_name || '.' || column_name AS name FROM information_schema.columns
             WHERE table_schema = current_schema()"
        }
    };
    let rows = query(sql).fetch_all(&mut conn).await.unwrap();
    let names = rows.iter().map(|row| row.column::<String>("name").unwrap());
    let names = names.filter(|name| !name.starts_with('_') && !name.starts_with("sqlite_"));
    // Only PostgreSQL has files of exports, and an object store.
    let names =
        names.filter(|name| !name.starts_with("export_blob.") && !name.starts_with("blob_store."));
    assert_eq!(names.collect::<std::collections::BTreeSet<_>>(), copied_columns());
}

#[tokio::test]
async fn copy_has_every_row_and_can_be_repeated() {
    let Place::Schema(address, data) = Place::new().await else { return };
    let (dir, store) = open_directory().await;
    let lineage = fill(&store).await;
    execute(&store, "UPDATE lineage SET notes = 'a' || char(0) || 'b'").await;
    store.close().await.unwrap();
    let first = copy(dir.path(), &address).await.unwrap();
    assert_eq!((first.rows, first.changed_texts), (21, 1));
    assert_eq!(copy(dir.path(), &address).await.unwrap(), first);

    let (from, to) = (
        Store::open(dir.path()).await.unwrap(),
        Store::connect(&address, data.path()).await.unwrap(),
    );
    assert_eq!(from.counts().await.unwrap(), to.counts().await.unwrap());
    let (was, is) = (from.lineage(lineage).await.unwrap(), to.lineage(lineage).await.unwrap());
    assert_eq!(is.notes, "a\u{fffd}b");
    assert_eq!(Lineage { notes: was.notes.clone(), ..is }, was);
    let history = async |store: &Store| store.list_generations(lineage, None, 9).await.unwrap();
    assert_eq!(history(&from).await, history(&to).await);
    assert!(history(&to).await[1].centre.is_some());
    assert_eq!(from.list_tokens().await.unwrap(), to.list_tokens().await.unwrap());
    to.close().await.unwrap();
}

#[tokio::test]
async fn copy_that_was_stopped_goes_on() {
    let Place::Schema(address, data) = Place::new().await else { return };
    let (dir, store) = open_directory().await;
    let lineage = fill(&store).await;
    store.close().await.unwrap();
    copy(dir.path(), &address).await.unwrap();
    let to = Store::connect(&address, data.path()).await.unwrap();
    for sql in [
        "UPDATE lineage SET cover_id = NULL",
        "UPDATE generation SET centre_id = NULL",
        "DELETE FROM picture",
        "DELETE FROM generation_parent",
        "DELETE FROM individual WHERE slot = 2 AND id = (SELECT id FROM individual \
         ORDER BY id DESC LIMIT 1)",
    ] {
        execute(&to, sql).await;
    }
    to.close().await.unwrap();
    assert_eq!(copy(dir.path(), &address).await.unwrap().rows, 21);
    // A database that went its own way is not changed.
    let to = Store::connect(&address, data.path()).await.unwrap();
    execute(&to, "UPDATE lineage SET cover_id = NULL, version = version + 1").await;
    to.close().await.unwrap();
    let mixed = copy(dir.path(), &address).await;
    assert!(matches!(mixed, Err(StorageError::Mixed { table: "lineage" })), "{mixed:?}");
    let to = Store::connect(&address, data.path()).await.unwrap();
    assert!(to.lineage(lineage).await.unwrap().cover_individual.is_none());
    to.close().await.unwrap();
}

#[tokio::test]
async fn copy_into_a_database_with_other_rows_is_refused() {
    let Place::Schema(address, data) = Place::new().await else { return };
    let to = Store::connect(&address, data.path()).await.unwrap();
    fill(&to).await;
    let (dir, store) = open_directory().await;
    fill(&store).await;
    store.close().await.unwrap();
    let used = copy(dir.path(), &address).await.unwrap_err().to_string();
    assert_eq!(used, "a server or a command uses the database; stop it first");
    to.close().await.unwrap();
    let mixed = copy(dir.path(), &address).await;
    assert!(matches!(mixed, Err(StorageError::Mixed { .. })), "{mixed:?}");
}
