//! A big history: lists stay short. Prints their times; the goal is 50 ms.

use std::time::{Duration, Instant};

use brood_tests::{TestLineage, TestServer, text_of};
use serde_json::json;
use sqlx::sqlite::SqliteConnectOptions;
use sqlx::{Connection, SqliteConnection};

use crate::rounds;

/// Individuals of the short form, in broods of eight.
const INDIVIDUALS: u64 = 100_000;
const CHILDREN: u64 = 8;
/// Requests of each list.
const REQUESTS: usize = 40;

/// Copies the first generation and its children; each copy is bred from the one before. Ids are
/// numbers.
const COPIES: [&str; 3] = [
    "INSERT INTO generation (id, lineage_id, position, seed_bits, mutation, recombination, curation,
         steer_json, created_ms)
     WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < ?1)
     SELECT unhex(printf('%032x', i)), lineage_id, i, i, mutation, recombination, curation,
         steer_json, created_ms + i
     FROM n JOIN generation ON position = 0",
    "INSERT INTO individual (id, lineage_id, generation_id, slot, genome_hash, operator, attempts,
         twin, favourite)
     WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < ?1)
     SELECT unhex(printf('%016x%016x', slot + 1, i)), individual.lineage_id,
         unhex(printf('%032x', i)), slot, genome_hash, 'mutate', 1, 0, i % 100 = 0
     FROM n JOIN generation ON position = 0 JOIN individual ON generation_id = generation.id",
    "INSERT INTO generation_parent
         (generation_id, place, genome_hash, individual_id, parent_generation_id)
     SELECT generation.id, 0, parent.genome_hash, parent.id, parent.generation_id
     FROM generation JOIN individual AS parent
         ON parent.generation_id = unhex(printf('%032x', position - 1)) AND parent.slot = 0
     WHERE position > 1 AND ?1 > 0",
];

/// Sends a GET again and again; returns the median and the largest time in milliseconds.
async fn time(server: &TestServer, path: &str) -> (f64, f64) {
    let mut times = Vec::new();
    for _ in 0..REQUESTS {
        let start = Instant::now();
        server.get(path).await.expect(200);
        times.push(start.elapsed());
    }
    times.sort();
    let ms = |time: Duration| time.as_secs_f64() * 1000.0;
    (ms(times[REQUESTS / 2]), ms(times[REQUESTS - 1]))
}

#[tokio::test(flavor = "multi_thread")]
async fn lists_of_a_big_history_are_complete_and_short() {
    let mut server = TestServer::start();
    let id = {
        let lineage = TestLineage::with(&server, json!({"name": "long", "thumbnail_px": 16})).await;
        lineage.breed(json!({"parents": [], "count": CHILDREN, "seed": 1})).await;
        lineage.id
    };
    assert_eq!(server.terminate(), 0);
    let generations = INDIVIDUALS / CHILDREN * rounds().div_ceil(crate::ROUNDS);
    let options = SqliteConnectOptions::new().filename(server.data().join("brood.db"));
    let mut database = SqliteConnection::connect_with(&options).await.unwrap();
    for sql in COPIES {
        let count = i64::try_from(generations).unwrap();
        sqlx::query(sql).bind(count).execute(&mut database).await.unwrap();
    }
    database.close().await.unwrap();
    server.restart();

    let lineage = server.get(&format!("/v1/lineages/{id}")).await.expect(200).json();
    assert_eq!(lineage["generations"], generations + 1);
    let last = format!("/v1/lineages/{id}/generations?cursor={}", generations - 1);
    let last = server.get(&last).await.expect(200).json();
    let newest = text_of(&last["items"][0]["individuals"][0]["id"]);
    let ancestors = server.get(&format!("/v1/individuals/{newest}/ancestry?depth=50")).await;
    assert_eq!(ancestors.expect(200).json()["items"].as_array().unwrap().len(), 50);
    let oldest = uuid::Uuid::from_u128(1 << 64 | 1);
    let middle = generations / 2;
    let paths = [
        "/v1/lineages?limit=200".to_owned(),
        "/v1/lineages?search=long".to_owned(),
        format!("/v1/lineages/{id}"),
        format!("/v1/lineages/{id}/generations?limit=200&cursor={middle}"),
        format!("/v1/lineages/{id}/outlines?limit=200&cursor={middle}"),
        format!("/v1/individuals?favourite=true&lineage={id}"),
        format!("/v1/individuals/{oldest}/descendants?limit=200"),
        format!("/v1/individuals/{newest}/ancestry?depth=100"),
    ];
    let mut slowest = (0.0, 0.0, String::new());
    for path in paths {
        // The first request registers the pictures of its individuals.
        server.get(&path).await.expect(200);
        let (median, largest) = time(&server, &path).await;
        if largest > slowest.1 {
            slowest = (median, largest, path.replace(&id, "ID"));
        }
    }
    let (median, largest, path) = slowest;
    println!(
        "fault: big history: {} individuals; the slowest list takes {median:.0} ms, {largest:.0} ms at most \
         (goal 50): {path}",
        (generations + 1) * CHILDREN
    );
}
