//! Power cuts: after any of them, the disk holds every acknowledged generation.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::time::{Duration, Instant};

use brood_tests::{ServerOptions, TestLineage, TestServer, brood, seed_of};
use reqwest::Method;
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::layer::Layer;
use crate::{Request, all_generations, answer, compare, draw, rounds, send};

const CLIENTS: u64 = 3;
const BREEDING: Duration = Duration::from_secs(2);

/// Acknowledged generation, with the length of the trace when its answer came.
struct Acknowledged {
    request: Request,
    born: Value,
    traced: u64,
}

/// Breeds for a while. Pauses let the server write its log back.
async fn breed(server: &TestServer, layer: &Layer, path: &str, client: u64) -> Vec<Acknowledged> {
    let start = Instant::now();
    let mut acknowledged = Vec::new();
    for seed in client * 100_000.. {
        if start.elapsed() > BREEDING {
            break;
        }
        let request = Request {
            key: format!("key-{seed}"),
            seed,
            body: json!({"parents": [], "count": 5, "seed": seed}),
        };
        let one = server.request(Method::POST, path).header("idempotency-key", &request.key);
        let (status, born) = answer(one.json(&request.body)).await.expect("the server is there");
        assert_eq!(status, 201, "{born}");
        acknowledged.push(Acknowledged { request, born, traced: layer.traced_bytes() });
        if seed % 30 == 29 {
            tokio::time::sleep(Duration::from_millis(350)).await;
        }
    }
    acknowledged
}

#[tokio::test(flavor = "multi_thread")]
async fn no_acknowledged_generation_is_lost_when_the_power_is_cut() {
    let (layer, data) = (Layer::build(), TempDir::new().unwrap());
    let root = data.path().to_owned();
    let mut server = TestServer::start_on(layer.traced_options(&root), data);
    let path = TestLineage::new(&server).await.path("/generations");
    let made = layer.traced_bytes();
    let clients = (0..CLIENTS).map(|client| breed(&server, &layer, &path, client));
    let acknowledged: Vec<_> =
        futures::future::join_all(clients).await.into_iter().flatten().collect();
    server.kill9();
    let trace = layer.trace(&root);

    let first = (0..trace.len()).find(|records| trace.end(*records) >= made);
    let first = first.expect("the lineage is in the trace") as u64;
    let (rounds, mut next, mut kept) = (rounds(), draw(1), 0);
    for round in 0..rounds {
        // The last round cuts at the end: nothing acknowledged may be missing. Every fifth round
        // cuts during the first start, while the database is created.
        let records = match (round + 1 == rounds, round % 5) {
            (true, _) => trace.len(),
            (false, 0) => next(first) as usize,
            (false, _) => next(trace.len() as u64) as usize,
        };
        let left = TempDir::new().unwrap();
        trace.cut(records, left.path(), &mut next);
        let end = trace.end(records);
        let mut server = TestServer::start_on(ServerOptions::default(), left);
        if made > end {
            // The lineage itself may be missing; the directory can be used.
            TestLineage::new(&server).await.random(1).await;
            continue;
        }
        // Without an answer, a generation was committed or not; sent again, it is there once.
        let listed = all_generations(&server, &path).await;
        let mut births: BTreeMap<u64, Value> =
            listed.into_iter().map(|one| (seed_of(&one), one)).collect();
        let (due, open): (Vec<_>, Vec<_>) = acknowledged.iter().partition(|one| one.traced <= end);
        for one in open.into_iter().take(20) {
            let again = send(&server, &path, &one.request).await.expect(201).json();
            births.insert(one.request.seed, again);
        }
        births.extend(due.iter().map(|one| (one.request.seed, one.born.clone())));
        compare(&births, &all_generations(&server, &path).await, round);
        kept += due.len();
        assert_eq!(server.terminate(), 0);
        brood([OsStr::new("check"), OsStr::new("--data"), server.data().as_os_str()]).success();
    }
    println!(
        "fault: power cut: {rounds} cuts in {} changes of files, {kept} generations acknowledged before them, 0 lost",
        trace.len()
    );
}
