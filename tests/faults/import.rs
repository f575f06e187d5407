//! Imports of long histories: others breed meanwhile, and one that is cut leaves nothing.

use std::time::{Duration, Instant};

use brood_tests::{TestLineage, TestServer, text_of};
use serde_json::{Value, json};
use tokio::time::{sleep, timeout};

use super::{draw, rounds};

const PATH: &str = "/v1/lineages/import";

/// File of a lineage in which this number of broods have 256 individuals of one genome.
pub async fn long_file(server: &TestServer, broods: u64) -> Value {
    let lineage = TestLineage::new(server).await;
    lineage.random(1).await;
    let mut file = server.get(&lineage.path("/file")).await.expect(200).json();
    let generation = file["generations"][0].clone();
    let child = generation["individuals"][0].clone();
    let with_id = |number: u64, slot: u64| -> Value {
        let mut child = child.clone();
        child["id"] = json!(format!("01900000-0000-7000-8000-{:012x}", 256 * number + slot));
        child["slot"] = json!(slot);
        child
    };
    let generations = (0..broods).map(|number| {
        let mut one = generation.clone();
        one["individuals"] = (0..256).map(|slot| with_id(number, slot)).collect();
        one
    });
    file["generations"] = generations.collect();
    let hash = text_of(&child["hash"]);
    file["genomes"] = json!({ &hash: file["genomes"][&hash] });
    file
}

/// Number of stored individuals.
async fn individuals(server: &TestServer) -> u64 {
    server.metric("brood_rows{table=\"individual\"}").await
}

/// Names of all lineages.
async fn names(server: &TestServer) -> Vec<String> {
    let mut names = Vec::new();
    for hidden in [false, true] {
        let path = format!("/v1/lineages?hidden={hidden}&limit=100");
        let listed = server.get(&path).await.expect(200).json();
        let items = listed["items"].as_array().unwrap().iter();
        names.extend(items.map(|one| text_of(&one["name"]).to_owned()));
    }
    names
}

#[tokio::test(flavor = "multi_thread")]
async fn import_that_is_cut_by_kill_9_leaves_nothing() {
    let mut server = TestServer::start();
    let mut file = long_file(&server, 391).await;
    file["name"] = json!("brought");
    let body = file.to_string();
    let (before, stored) = (names(&server).await, individuals(&server).await);
    let mut draw = draw(27);
    let (mut cut, mut finished, mut slowest) = (0, 0, Duration::ZERO);
    for _ in 0..rounds() / 2 {
        let request = server.post_bytes(PATH, "application/json", body.clone());
        let answer = timeout(Duration::from_millis(100 + draw(700)), request).await;
        server.kill9();
        server.restart();
        let listed = names(&server).await;
        if listed.len() > before.len() {
            // The file was imported before its answer came, or before the server was killed.
            finished += 1;
            let listed = server.get("/v1/lineages?search=brought").await.expect(200).json();
            assert_eq!(listed["items"][0]["generations"], 391);
            let id = text_of(&listed["items"][0]["id"]).to_owned();
            server.delete(&format!("/v1/lineages/{id}?purge=true")).await.expect(204);
            continue;
        }
        assert!(answer.is_err(), "an acknowledged import is lost");
        assert_eq!(listed, before);
        let start = Instant::now();
        while individuals(&server).await > stored {
            assert!(start.elapsed() < Duration::from_secs(60), "the rest of an import is kept");
            sleep(Duration::from_millis(50)).await;
        }
        slowest = slowest.max(start.elapsed());
        cut += 1;
    }
    assert!(cut > 0, "no import was cut");
    server.post_bytes(PATH, "application/json", body).await.expect(201);
    println!(
        "fault: imports: {cut} of 100,096 individuals cut by kill -9, {finished} finished, 0 in parts; \
         the rest removed within {} ms",
        slowest.as_millis()
    );
}

#[tokio::test(flavor = "multi_thread")]
async fn births_go_on_beside_an_import() {
    let server = TestServer::start();
    let body = long_file(&server, 391).await.to_string();
    let own = TestLineage::new(&server).await;
    let importing = async {
        let start = Instant::now();
        server.post_bytes(PATH, "application/json", body).await.expect(201);
        start.elapsed()
    };
    tokio::pin!(importing);
    let mut waits = Vec::new();
    let import = loop {
        let start = Instant::now();
        tokio::select! {
            elapsed = &mut importing => break elapsed,
            _ = own.random(4) => waits.push(start.elapsed()),
        }
    };
    waits.sort();
    let (median, longest) = (waits[waits.len() / 2], waits[waits.len() - 1]);
    println!(
        "fault: births beside an import: 100,096 individuals in {} ms, {} births, median {} ms, longest {} ms",
        import.as_millis(),
        waits.len(),
        median.as_millis(),
        longest.as_millis()
    );
    assert!(longest < import / 2, "a birth waits for the import: {longest:?} of {import:?}");
}
