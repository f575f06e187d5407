//! Tests of several writers on one PostgreSQL database. They do nothing without
//! `BROOD_TEST_DATABASE`.

use std::time::{Duration, Instant};

use super::*;
use crate::BusEvent;
use crate::sql::query;
use crate::write::operation;

/// Opens two stores of one new schema; `None` without PostgreSQL.
async fn two_stores() -> Option<[Store; 2]> {
    let place @ Place::Schema(address, _) = &Place::new().await else { return None };
    Some([place.open().await, Store::connect_shared(address).await.unwrap()])
}

/// Generation of children with these genomes, in this order.
fn brood(lineage: LineageId, names: impl IntoIterator<Item = String>) -> NewGeneration {
    let mut new = new_generation(lineage, &[], "unused");
    new.individuals = (0..).zip(names).map(|(slot, name)| child(slot, &name)).collect();
    new
}

#[tokio::test]
async fn servers_share_a_database_but_no_data_directory() {
    let Place::Schema(address, data) = Place::new().await else { return };
    let store = Store::connect(&address, data.path()).await.unwrap();
    let other_data = tempfile::tempdir().unwrap();
    let other = Store::connect(&address, other_data.path()).await.unwrap();
    let third = Store::connect(&address, data.path()).await;
    assert!(matches!(third, Err(StorageError::Locked)), "{third:?}");
    let on_sqlite = Store::open(data.path()).await;
    assert!(matches!(on_sqlite, Err(StorageError::Locked)), "{on_sqlite:?}");
    Store::connect_shared(&address).await.unwrap().close().await.unwrap();
    let lineage = lineage(&store).await;
    assert_eq!(other.lineage(lineage).await.unwrap().id, lineage);
    store.close().await.unwrap();
    Store::connect(&address, data.path()).await.unwrap();
}

#[tokio::test]
async fn role_with_rights_on_rows_alone_uses_the_tables_of_another() {
    let place @ Place::Schema(address, data) = &Place::new().await else { return };
    place.open().await.close().await.unwrap();
    let schema = address.as_str().rsplit('=').next().unwrap();
    let role = format!("rows_of_{schema}");
    let mut owner = sqlx::PgConnection::connect(address.as_str()).await.unwrap();
    let grant = format!(
        "CREATE ROLE {role} LOGIN PASSWORD 'secret';
         GRANT USAGE ON SCHEMA {schema} TO {role};
         GRANT SELECT, INSERT, UPDATE, DELETE ON ALL TABLES IN SCHEMA {schema} TO {role}"
    );
    sqlx::raw_sql(sqlx::AssertSqlSafe(grant)).execute(&mut owner).await.unwrap();
    let own = DatabaseAddress::from(format!("{}&user={role}&password=secret", address.as_str()));
    let store = Store::connect(&own, data.path()).await.unwrap();
    let lineage = lineage(&store).await;
    generation(&store, lineage, &[], "first").await;
    store.create_token("laptop", crate::Scope::Read, hash("t"), None).await.unwrap();
    store.purge_lineage(lineage).await.unwrap();
    store.close().await.unwrap();
    let remove = format!("DROP OWNED BY {role}; DROP ROLE {role}");
    sqlx::raw_sql(sqlx::AssertSqlSafe(remove)).execute(&mut owner).await.unwrap();
}

#[tokio::test]
async fn generations_of_one_lineage_have_positions_without_gaps() {
    let Some(stores) = two_stores().await else { return };
    let lineage = lineage(&stores[0]).await;
    let births = (0..40).map(|n| {
        let store = stores[n % 2].clone();
        let new = brood(lineage, [format!("only {n}")]);
        tokio::spawn(async move { store.create_generation(new).await.unwrap().index })
    });
    let mut indices = Vec::new();
    for birth in births.collect::<Vec<_>>() {
        indices.push(birth.await.unwrap());
    }
    indices.sort_unstable();
    assert_eq!(indices, (0..40).collect::<Vec<u64>>());
}

#[tokio::test]
async fn broods_with_the_same_genomes_in_other_orders_do_not_wait_for_each_other() {
    let Some(stores) = two_stores().await else { return };
    for round in 0..3 {
        let names: Vec<_> = (0..1500).map(|n| format!("shared {round} {n}")).collect();
        let births = (0..6).map(|n| {
            let (store, mut names) = (stores[n % 2].clone(), names.clone());
            names.rotate_left(n * 200);
            if n % 2 == 1 {
                names.reverse();
            }
            tokio::spawn(async move {
                let place = lineage(&store).await;
                store.create_generation(brood(place, names)).await.unwrap();
            })
        });
        for birth in births.collect::<Vec<_>>() {
            birth.await.unwrap();
        }
    }
}

#[tokio::test]
async fn genomes_that_a_birth_found_stored_are_not_removed_before_it_ends() {
    let Some(stores) = two_stores().await else { return };
    let names = || (0..20).map(|n| format!("common {n}"));
    let kept = lineage(&stores[1]).await;
    for _ in 0..20 {
        let removed = lineage(&stores[0]).await;
        stores[0].create_generation(brood(removed, names())).await.unwrap();
        let (purged, born) = tokio::join!(
            stores[0].purge_lineage(removed),
            stores[1].create_generation(brood(kept, names())),
        );
        purged.unwrap();
        born.unwrap();
        let other = lineage(&stores[1]).await;
        stores[1].purge_lineage(kept).await.unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(stores[0].counts().await.unwrap().genomes, 0);
        let again = Lineage { id: kept, ..new_lineage("kept", scene(&stores[1]).await, 7) };
        stores[1].create_lineage(again, None).await.unwrap();
        stores[1].purge_lineage(other).await.unwrap();
    }
}

#[tokio::test]
async fn lineage_that_two_servers_remove_at_once_is_removed_by_one_of_them() {
    let Some(stores) = two_stores().await else { return };
    for round in 0..20 {
        let removed = lineage(&stores[0]).await;
        for n in 0..6 {
            let names = (0..20).map(|name| format!("{round} {n} {name}"));
            stores[n % 2].create_generation(brood(removed, names)).await.unwrap();
        }
        let (one, other) =
            tokio::join!(stores[0].purge_lineage(removed), stores[1].purge_lineage(removed));
        let is_removed = |ended: &Result<(), StorageError>| match ended {
            Ok(()) => true,
            Err(StorageError::NotFound) => false,
            Err(error) => panic!("{error}"),
        };
        assert!(is_removed(&one) || is_removed(&other));
        assert_eq!(stores[0].counts().await.unwrap().genomes, 0);
    }
}

#[tokio::test]
async fn writer_that_is_cut_off_holds_a_lineage_for_seconds_only() {
    let Some([cut_off, other]) = two_stores().await else { return };
    let lineage = lineage(&other).await;
    let (locked, is_locked) = tokio::sync::oneshot::channel();
    let hanging = tokio::spawn(async move {
        let hangs = cut_off.write(operation!(|conn| {
            crate::lineage::lock(conn, lineage).await?;
            locked.send(()).unwrap();
            // Nothing more is sent, and the connection stays open.
            std::future::pending::<()>().await;
            Ok(())
        }));
        hangs.await
    });
    is_locked.await.unwrap();
    let start = Instant::now();
    other.create_generation(brood(lineage, ["a".to_owned()])).await.unwrap();
    assert!(start.elapsed() < Duration::from_secs(5), "{:?}", start.elapsed());
    hanging.abort();
}

#[tokio::test]
async fn write_whose_connection_breaks_is_unreachable_and_the_next_one_works() {
    let Some([store, _]) = two_stores().await else { return };
    let broken: Result<(), _> = store
        .write(operation!(|conn| {
            query("SELECT pg_terminate_backend(pg_backend_pid())").execute(conn).await?;
            Ok(())
        }))
        .await;
    assert!(matches!(broken, Err(StorageError::Unreachable(_))), "{broken:?}");
    lineage(&store).await;
}

#[tokio::test]
async fn writes_are_refused_when_too_many_wait() {
    let Some([store, _]) = two_stores().await else { return };
    let writes = (0..400).map(|_| {
        let store = store.clone();
        tokio::spawn(async move {
            let start = Instant::now();
            let wait = store.write(operation!(|_conn| {
                tokio::time::sleep(Duration::from_millis(400)).await;
                Ok(())
            }));
            (wait.await, start.elapsed())
        })
    });
    let mut refused = 0;
    for write in writes.collect::<Vec<_>>() {
        match write.await.unwrap() {
            (Err(StorageError::Busy), after) if after < Duration::from_millis(400) => refused += 1,
            (other, after) => assert!(other.is_ok(), "{other:?} after {after:?}"),
        }
    }
    assert!((100..150).contains(&refused), "{refused}");
    assert_eq!(store.refused_writes(), refused);
}

#[tokio::test]
async fn rows_of_large_tables_are_estimated() {
    let Some([store, _]) = two_stores().await else { return };
    for sql in [
        "INSERT INTO token (name, scope, hash) SELECT CAST(n AS TEXT), 'read', \
         decode(lpad(to_hex(n), 64, '0'), 'hex') FROM generate_series(1, 20000) AS n",
        "ANALYZE token",
        // Rows that a count would see are not counted.
        "UPDATE pg_class SET reltuples = 1000000 WHERE oid = CAST('token' AS regclass)",
    ] {
        execute(&store, sql).await;
    }
    let counts = store.counts().await.unwrap();
    assert_eq!((counts.tokens, counts.lineages), (1_000_000, 0));
}

#[tokio::test]
async fn access_stays_closed_when_the_last_tokens_are_revoked_together() {
    let Some([one, other]) = two_stores().await else { return };
    for round in 0..10 {
        for name in ["a", "b"] {
            let hash = hash(&format!("{name} {round}"));
            one.create_token(name, crate::Scope::Read, hash, None).await.unwrap();
        }
        execute(&one, "DELETE FROM closed").await;
        let (first, second) = tokio::join!(one.revoke_token("a", 1), other.revoke_token("b", 1));
        assert!(first.unwrap() != second.unwrap());
        assert!(one.needs_token().await.unwrap());
    }
}

#[tokio::test]
async fn genome_that_a_scene_keeps_is_not_removed() {
    let Some([one, other]) = two_stores().await else { return };
    for round in 0..20 {
        let removed = lineage(&one).await;
        let name = format!("kept {round}");
        one.create_generation(brood(removed, [name.clone()])).await.unwrap();
        let json = format!("{{\"round\": {round}}}");
        let materials = [genome(&name)];
        let (purged, scene) = tokio::join!(
            one.purge_lineage(removed),
            other.put_scene(&json, hash(&json), &materials, 1),
        );
        purged.unwrap();
        let is_stored = one.genome(genome(&name)).await.is_ok();
        assert_eq!(scene.is_ok(), is_stored, "{scene:?}");
    }
}

#[tokio::test]
async fn servers_of_one_database_hear_each_other_and_know_of_losses() {
    let (place, store) = open().await;
    let Place::Schema(address, _) = &place else {
        assert!(store.join_bus().await.unwrap().is_none(), "a directory has one server");
        return;
    };
    let other = Store::connect_shared(address).await.unwrap();
    let (first, link) = store.join_bus().await.unwrap().unwrap();
    let (second, other_link) = other.join_bus().await.unwrap().unwrap();
    let (heard, mut first_hears) = tokio::sync::mpsc::unbounded_channel();
    let (told, mut second_hears) = tokio::sync::mpsc::unbounded_channel();
    let (stop, stopped) = tokio::sync::oneshot::channel::<()>();
    let stopped = async move { stopped.await.unwrap() };
    let link = tokio::spawn(link.run(stopped, move |event| heard.send(event).unwrap()));
    let other_link = other_link.run(std::future::pending(), move |event| told.send(event).unwrap());
    let other_link = tokio::spawn(other_link);
    // More than a batch holds.
    let messages: Vec<_> = (0..50).map(|n| format!("{n} {}", "ä".repeat(500))).collect();
    for message in &messages {
        assert!(first.tell(message.clone()));
    }
    assert!(!first.tell("x".repeat(8000)), "longer than a batch");
    for message in messages {
        assert_eq!(second_hears.recv().await.unwrap(), BusEvent::Message(message));
    }
    assert!(second.tell("answer".to_owned()));
    assert_eq!(first_hears.recv().await.unwrap(), BusEvent::Message("answer".to_owned()));
    assert!(first_hears.try_recv().is_err(), "a server does not hear itself");

    let closed = store.write(operation!(|conn| {
        let close = "SELECT pg_terminate_backend(pid) FROM pg_stat_activity
            WHERE query = 'LISTEN \"brood_' || md5(current_schema()) || '\"'";
        query(close).execute(conn).await
    }));
    assert_eq!(closed.await.unwrap(), 2);
    assert_eq!(second_hears.recv().await.unwrap(), BusEvent::Gap);
    // The connection of the first may still be open.
    loop {
        first.tell("again".to_owned());
        if second_hears.recv().await.unwrap() == BusEvent::Message("again".to_owned()) {
            break;
        }
    }
    // A server that stops sends the messages that wait.
    first.tell("last".to_owned());
    stop.send(()).unwrap();
    link.await.unwrap();
    while second_hears.recv().await.unwrap() != BusEvent::Message("last".to_owned()) {}
    assert_eq!(second_hears.recv().await.unwrap(), BusEvent::Gap, "the first is silent");
    other_link.abort();
}

#[tokio::test]
async fn store_closes_although_a_statement_has_no_answer() {
    let Some([store, other]) = two_stores().await else { return };
    let (begun, has_begun) = tokio::sync::oneshot::channel();
    let waiting = store.clone();
    let waits = tokio::spawn(async move {
        let hangs = waiting.write(operation!(|_conn| {
            begun.send(()).unwrap();
            std::future::pending::<()>().await;
            Ok(())
        }));
        hangs.await
    });
    has_begun.await.unwrap();
    let start = Instant::now();
    store.close().await.unwrap();
    assert!(start.elapsed() < Duration::from_secs(9), "{:?}", start.elapsed());
    waits.abort();
    other.close().await.unwrap();
}
