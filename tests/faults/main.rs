//! kill -9 of the server and of workers under load.
//!
//! Every generation answered with 201 is there afterwards, unchanged; a repeated request with the
//! same key is bred once; a killed worker loses no picture. Each test prints one line of figures.

#![expect(
    clippy::unwrap_used,
    reason = "this is a test; clippy only knows those with an attribute"
)]

#[cfg(target_os = "linux")]
mod calls;
#[cfg(target_os = "linux")]
mod clock;
#[cfg(target_os = "linux")]
mod cluster;
#[cfg(target_os = "linux")]
mod disk;
mod growth;
mod history;
#[cfg(target_os = "linux")]
mod import;
#[cfg(target_os = "linux")]
mod layer;
#[cfg(target_os = "linux")]
mod memory;
#[cfg(target_os = "linux")]
mod power;
#[cfg(target_os = "linux")]
mod search;

use std::collections::{BTreeMap, HashMap};
use std::fmt::Debug;
use std::sync::Arc;
use std::time::{Duration, Instant};

use brood_tests::{TestLineage, TestServer, hashes, ids, seed_of, text_of};
use reqwest::Method;
use serde_json::{Value, json};

/// Rounds of the short form.
const ROUNDS: u64 = 20;
const CLIENTS: u64 = 4;

/// Rounds of this run; `cargo xtask faults --long` multiplies them.
fn rounds() -> u64 {
    let factor = std::env::var("BROOD_FAULT_ROUNDS").ok().and_then(|text| text.parse::<u64>().ok());
    ROUNDS * factor.unwrap_or(1)
}

/// Returns a function that draws a number below its argument.
#[cfg(target_os = "linux")]
fn draw(seed: u64) -> impl FnMut(u64) -> u64 {
    let mut state = seed;
    move |below| {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) % below
    }
}

/// Request that can be sent again.
#[derive(Clone)]
struct Request {
    key: String,
    seed: u64,
    body: Value,
}

/// Answers that one client got before the server died.
#[derive(Default)]
struct Seen {
    acknowledged: Vec<(Request, Value)>,
    unanswered: Option<Request>,
}

#[tokio::test(flavor = "multi_thread")]
async fn no_acknowledged_generation_is_lost_when_the_server_is_killed_twenty_times() {
    let mut server = TestServer::start();
    let path = {
        let body = json!({"name": "under fire", "thumbnail_px": 16});
        TestLineage::with(&server, body).await.path("/generations")
    };
    let mut births: BTreeMap<u64, Value> = BTreeMap::new();
    let (mut retried, mut slowest) = (0, Duration::ZERO);
    let rounds = rounds();
    for round in 0..rounds {
        let unanswered = shoot(&mut server, &path, round, &mut births).await;
        let start = Instant::now();
        server.restart();
        slowest = slowest.max(start.elapsed());
        for request in unanswered {
            let again = send(&server, &path, &request).await.expect(201).json();
            assert_eq!(seed_of(&again), request.seed);
            births.insert(request.seed, again);
            retried += 1;
        }
        let listed = all_generations(&server, &path).await;
        compare(&births, &listed, round);
    }
    assert!(births.len() as u64 > rounds, "there was load: {} births", births.len());
    let pictures = decode_pictures(&server, &births).await;
    println!(
        "fault: kill -9: {rounds} rounds, {} generations acknowledged, 0 lost, 0 twice, {retried} sent again, \
         {pictures} pictures decoded, slowest start {} ms",
        births.len(),
        slowest.as_millis()
    );
}

/// The server ends with an error once its data is gone, and does not acknowledge what it cannot
/// keep.
#[cfg(unix)]
#[tokio::test(flavor = "multi_thread")]
async fn server_stops_when_its_data_directory_is_removed() {
    let mut server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    lineage.random(1).await;
    let path = lineage.path("/generations");
    std::fs::remove_dir_all(server.data()).unwrap();
    let body = json!({"parents": [], "seed": 2});
    let birth = server.request(Method::POST, &path).json(&body);
    assert_ne!(server.send(birth).await.status, 201);
    let status = server.wait();
    let log = server.log();
    assert!(status != 0 && log.contains("was removed from the data directory"), "{status}: {log}");
}

/// Returns the workers started by this process: those that render, or those that search.
#[cfg(target_os = "linux")]
fn workers_of(process: u32, that_search: bool) -> Vec<u32> {
    let all = std::fs::read_dir("/proc").unwrap().filter_map(|entry| {
        let id: u32 = entry.ok()?.file_name().to_str()?.parse().ok()?;
        // The process may have ended meanwhile.
        let status = std::fs::read_to_string(format!("/proc/{id}/status")).ok()?;
        let parent = status.lines().find_map(|line| line.strip_prefix("PPid:"))?;
        let command = std::fs::read_to_string(format!("/proc/{id}/cmdline")).ok()?;
        let is_it = command.contains("--searches") == that_search;
        (is_it && parent.trim() == process.to_string()).then_some(id)
    });
    all.collect()
}

/// Kills the worker shortly after a whole brood's pictures were requested; returns the numbers of
/// workers killed and of pictures received. The supervisor reports the death, so the pictures
/// arrive as soon as the next worker renders them.
#[cfg(target_os = "linux")]
async fn shoot_worker(moment: Duration) -> (usize, usize) {
    let server = TestServer::start();
    let body = json!({"name": "under fire", "thumbnail_px": 256});
    let lineage = TestLineage::with(&server, body).await;
    let generation = lineage.breed(json!({"parents": [], "count": 60, "seed": 1})).await;
    let children = generation["individuals"].as_array().unwrap();
    let pictures = children.iter().map(|child| async {
        let url = text_of(&child["thumbnail"]);
        let deadline = Instant::now() + Duration::from_secs(80);
        loop {
            let answer = server.get(&url).await;
            if answer.status != 503 {
                assert_eq!(answer.expect(200).picture().dimensions(), (256, 256));
                return;
            }
            assert!(!answer.header("retry-after").is_empty(), "{:?}", answer.headers);
            assert!(Instant::now() < deadline, "{url} never came");
        }
    });
    let shot = async {
        tokio::time::sleep(moment).await;
        let workers = workers_of(server.process(), false);
        for worker in &workers {
            // It may have ended by itself meanwhile.
            let _ = std::process::Command::new("kill").args(["-9", &worker.to_string()]).status();
        }
        workers.len()
    };
    let (pictures, killed) = futures::future::join(futures::future::join_all(pictures), shot).await;
    (killed, pictures.len())
}

#[cfg(target_os = "linux")]
#[tokio::test(flavor = "multi_thread")]
async fn every_picture_arrives_when_a_worker_is_killed_while_rendering() {
    let rounds = [5, 20, 45].map(|ms| shoot_worker(Duration::from_millis(ms)));
    let seen = futures::future::join_all(rounds).await;
    let killed: usize = seen.iter().map(|round| round.0).sum();
    let pictures: usize = seen.iter().map(|round| round.1).sum();
    assert_eq!((killed, pictures), (3, 3 * 60));
    println!("fault: kill -9 of workers: {killed} killed, all of {pictures} pictures came");
}

/// Returns the process of the worker that renders, once it waits for its next job: a picture has
/// arrived.
#[cfg(target_os = "linux")]
async fn idle_worker(server: &TestServer, lineage: &TestLineage<'_>) -> String {
    let first = lineage.breed(json!({"parents": [], "count": 1, "seed": 1})).await;
    server.get(&text_of(&first["individuals"][0]["thumbnail"])).await.expect(200);
    workers_of(server.process(), false)[0].to_string()
}

#[cfg(target_os = "linux")]
fn signal(process: &str, name: &str) {
    let sent = std::process::Command::new("kill").args([name, process]).status();
    assert!(sent.unwrap().success());
}

#[cfg(target_os = "linux")]
#[tokio::test(flavor = "multi_thread")]
async fn stopped_worker_is_replaced() {
    let server = TestServer::start();
    let lineage = TestLineage::with(&server, json!({"name": "frozen", "thumbnail_px": 32})).await;
    let worker = idle_worker(&server, &lineage).await;
    signal(&worker, "-STOP");
    let start = Instant::now();
    let second = lineage.breed(json!({"parents": [], "count": 2, "seed": 2})).await;
    for child in second["individuals"].as_array().unwrap() {
        let answer = server.get(&text_of(&child["thumbnail"])).await;
        assert_eq!(answer.expect(200).picture().dimensions(), (32, 32));
    }
    assert!(server.log().contains("no longer reports"), "{}", server.log());
    println!("fault: stopped worker: pictures after {} ms", start.elapsed().as_millis());
}

#[cfg(target_os = "linux")]
#[tokio::test(flavor = "multi_thread")]
async fn pictures_do_not_wait_for_the_lease_of_a_killed_worker() {
    let server = TestServer::start();
    let lineage = TestLineage::with(&server, json!({"name": "frozen", "thumbnail_px": 32})).await;
    let worker = idle_worker(&server, &lineage).await;
    signal(&worker, "-STOP");
    // The job is granted all the same: the server cannot see that the worker is stopped.
    let second = lineage.breed(json!({"parents": [], "count": 2, "seed": 2})).await;
    let start = Instant::now();
    signal(&worker, "-KILL");
    for child in second["individuals"].as_array().unwrap() {
        let answer = server.get(&text_of(&child["thumbnail"])).await;
        assert_eq!(answer.expect(200).picture().dimensions(), (32, 32));
    }
    let elapsed = start.elapsed();
    assert!(elapsed < Duration::from_secs(15), "a lease lasts 20 s: {elapsed:?}");
    println!("fault: kill -9 of a worker with a lease: pictures after {} ms", elapsed.as_millis());
}

#[cfg(target_os = "linux")]
#[tokio::test(flavor = "multi_thread")]
async fn picture_of_a_target_arrives_when_its_worker_is_killed() {
    let server = TestServer::start();
    let id = server.glossy_target().await;
    let place = |size: u32| format!("/v1/targets/{id}/render.png?size={size}");
    // Once a picture has arrived, the worker waits for its next job.
    server.get(&place(32)).await.expect(200);
    let worker = workers_of(server.process(), false)[0].to_string();
    let signal = |name: &str| {
        std::process::Command::new("kill").args([name, worker.as_str()]).status().unwrap();
    };
    signal("-STOP");
    let kill = async {
        // The job is granted to the stopped worker meanwhile.
        tokio::time::sleep(Duration::from_millis(300)).await;
        signal("-KILL");
    };
    let place = place(48);
    let (answer, ()) = futures::future::join(server.get(&place), kill).await;
    assert_eq!(answer.expect(200).picture().dimensions(), (48, 48));
}

/// Breeds with several clients at once and kills the server meanwhile; returns the requests without
/// an answer.
async fn shoot(
    server: &mut TestServer,
    path: &str,
    round: u64,
    births: &mut BTreeMap<u64, Value>,
) -> Vec<Request> {
    let parents = Arc::new(births.values().last().map(ids).unwrap_or_default());
    let clients = (0..CLIENTS).map(|client| {
        let first = (round * CLIENTS + client) * 100_000;
        let base = server.request(Method::POST, path);
        tokio::spawn(load(base, first, Arc::clone(&parents)))
    });
    let clients: Vec<_> = clients.collect();
    // A different moment in each round: early ones hit the first writes, late ones full load.
    let moment = Duration::from_millis(30 + (round * 7919) % 400);
    tokio::time::sleep(moment).await;
    server.kill9();
    let mut unanswered = Vec::new();
    for client in clients {
        let seen = client.await.unwrap();
        births.extend(seen.acknowledged.into_iter().map(|(request, born)| (request.seed, born)));
        unanswered.extend(seen.unanswered);
    }
    unanswered
}

/// Breeds one generation after the other until the server is gone.
async fn load(base: reqwest::RequestBuilder, first: u64, parents: Arc<Vec<String>>) -> Seen {
    let mut seen = Seen::default();
    for seed in first.. {
        let parents: Vec<&String> = parents.iter().take((seed % 3) as usize).collect();
        let body = json!({"parents": parents, "count": 5, "seed": seed});
        let request = Request { key: format!("key-{seed}"), seed, body };
        let one = base.try_clone().expect("a request without a stream can be copied");
        let one = one.header("idempotency-key", &request.key).json(&request.body);
        match answer(one).await {
            Some((201, born)) => seen.acknowledged.push((request, born)),
            Some((status, body)) => panic!("breeding was answered with {status}: {body}"),
            None => {
                seen.unanswered = Some(request);
                break;
            }
        }
    }
    seen
}

/// Returns status and body; `None` if the connection broke.
async fn answer(request: reqwest::RequestBuilder) -> Option<(u16, Value)> {
    let response = request.send().await.ok()?;
    let status = response.status().as_u16();
    let bytes = response.bytes().await.ok()?;
    Some((status, serde_json::from_slice(&bytes).unwrap_or(Value::Null)))
}

async fn send(server: &TestServer, path: &str, request: &Request) -> brood_tests::Answer {
    let post = server.request(Method::POST, path).header("idempotency-key", &request.key);
    server.send(post.json(&request.body)).await
}

async fn all_generations(server: &TestServer, path: &str) -> Vec<Value> {
    let mut all = Vec::new();
    let mut page = format!("{path}?limit=200");
    loop {
        let mut list = server.get(&page).await.expect(200).json();
        all.append(list["items"].as_array_mut().unwrap());
        match &list["next"] {
            Value::Null => return all,
            cursor => page = format!("{path}?limit=200&cursor={}", text_of(cursor)),
        }
    }
}

/// Asserts that every generation is listed once and equals its answer, and that indices have no
/// gap.
fn compare(births: &BTreeMap<u64, Value>, listed: &[Value], round: u64) {
    compare_by(births, listed, round, Value::clone);
}

/// As [`compare`], with something computed from each answer.
fn compare_by<T: PartialEq + Debug>(
    births: &BTreeMap<u64, T>,
    listed: &[Value],
    round: u64,
    of: impl Fn(&Value) -> T,
) {
    let mut by_seed = HashMap::new();
    for (position, generation) in listed.iter().enumerate() {
        assert_eq!(generation["index"], position, "round {round}: indices must have no gap");
        let twice = by_seed.insert(seed_of(generation), generation);
        assert!(twice.is_none(), "round {round}: seed {} was born twice", seed_of(generation));
    }
    for (seed, born) in births {
        let found = by_seed.remove(seed);
        let found = found.unwrap_or_else(|| panic!("round {round}: seed {seed} is lost: {born:?}"));
        assert_eq!(&of(found), born, "round {round}: seed {seed} has changed: {found}");
    }
    assert!(by_seed.is_empty(), "round {round}: bred without a request: {:?}", by_seed.keys());
}

/// Decodes the pictures of the last generations, as shown when the lineage is opened.
async fn decode_pictures(server: &TestServer, births: &BTreeMap<u64, Value>) -> usize {
    let mut count = 0;
    for generation in births.values().rev().take(10) {
        assert_eq!(hashes(generation).len(), 5);
        for child in generation["individuals"].as_array().unwrap() {
            let url = text_of(&child["thumbnail"]);
            let picture = server.get(&url).await.expect(200).picture();
            assert_eq!(picture.dimensions(), (16, 16));
            count += 1;
        }
    }
    count
}
