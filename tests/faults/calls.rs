//! Calls of the operating system that fail: no answer is wrong, nothing acknowledged is lost, and
//! the server goes on or stops with an error.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};
use std::time::Duration;

use brood_tests::{TestLineage, TestServer, binary, brood};
use reqwest::Method;
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::layer::{FAULTS, Layer};
use crate::{Request, all_generations, answer, compare, rounds, send};

/// Breeds five generations in a row; returns the requests without a 201, and adds the others to
/// `births`.
async fn breed(
    server: &TestServer,
    path: &str,
    first: u64,
    births: &mut BTreeMap<u64, Value>,
) -> Vec<Request> {
    let mut failed = Vec::new();
    for seed in first..first + 5 {
        let body = json!({"parents": [], "count": 5, "seed": seed});
        let request = Request { key: format!("key-{seed}"), seed, body };
        let one = server.request(Method::POST, path).header("idempotency-key", &request.key);
        match answer(one.json(&request.body)).await {
            Some((201, born)) => {
                births.insert(seed, born);
            }
            Some((500 | 503 | 507, _)) | None => failed.push(request),
            Some((status, body)) => panic!("breeding was answered with {status}: {body}"),
        }
    }
    failed
}

/// Waits until the server breeds again, or has stopped with an error; returns true if it stopped.
async fn settle(server: &mut TestServer, path: &str, request: &Request) -> bool {
    for _ in 0..100 {
        if let Some(code) = server.ended() {
            assert_ne!(code, 0, "a failed disk is an error");
            return true;
        }
        let one = server.request(Method::POST, path).header("idempotency-key", &request.key);
        if let Some((201, _)) = answer(one.json(&request.body)).await {
            return false;
        }
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
    panic!("the server neither breeds nor stops\n{}", server.log());
}

#[tokio::test(flavor = "multi_thread")]
async fn no_acknowledged_generation_is_lost_when_calls_fail() {
    let (layer, data) = (Layer::build(), TempDir::new().unwrap());
    let options = layer.options(data.path());
    let mut server = TestServer::start_on(options, data);
    let path = TestLineage::new(&server).await.path("/generations");
    let mut births = BTreeMap::new();
    let (mut calls, mut refused, mut stops) = (0, 0, 0);
    let rounds = rounds().next_multiple_of(FAULTS.len() as u64);
    for round in 0..rounds {
        let fault = FAULTS[(round % FAULTS.len() as u64) as usize];
        let turn = round / FAULTS.len() as u64;
        // One call, or all from the first on; a later call with each turn.
        let count = if turn.is_multiple_of(2) { 1 } else { u64::MAX };
        layer.arm(fault, 1 + turn * turn, count);
        let failed = breed(&server, &path, round * 100, &mut births).await;
        // Time to write the log back.
        tokio::time::sleep(Duration::from_millis(400)).await;
        calls += layer.disarm();
        refused += failed.len();
        let again = failed.first().cloned().unwrap_or_else(|| Request {
            key: format!("key-{}", round * 100 + 50),
            seed: round * 100 + 50,
            body: json!({"parents": [], "count": 5, "seed": round * 100 + 50}),
        });
        if settle(&mut server, &path, &again).await {
            stops += 1;
            server.restart();
        }
        for request in failed.into_iter().chain([again]) {
            let born = send(&server, &path, &request).await.expect(201).json();
            births.insert(request.seed, born);
        }
        compare(&births, &all_generations(&server, &path).await, round);
    }
    assert!(!server.log().contains("panicked"), "{}", server.log());
    assert_eq!(server.terminate(), 0);
    brood([OsStr::new("check"), OsStr::new("--data"), server.data().as_os_str()]).success();
    assert!(calls > rounds, "calls have failed: {calls}");
    println!(
        "fault: failing calls: {rounds} rounds of {} kinds, {calls} calls failed, {refused} generations refused, \
         {stops} stops, {} acknowledged, 0 lost",
        FAULTS.len(),
        births.len()
    );
}

/// Starts a server whose calls fail; true if it listens, false if it stops with an error.
fn starts(layer: &Layer, server: &TestServer) -> bool {
    let options = layer.options(server.data());
    let mut child = Command::new(binary())
        .args(["serve", "--listen", "127.0.0.1:0", "--backend", "cpu", "--workers", "1", "--data"])
        .arg(server.data())
        .envs(options.environment)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let first = BufReader::new(child.stdout.take().unwrap()).lines().next();
    if first.is_some_and(|line| line.unwrap().contains("is listening")) {
        child.kill().unwrap();
        child.wait().unwrap();
        return true;
    }
    let finished = child.wait_with_output().unwrap();
    let error = String::from_utf8_lossy(&finished.stderr);
    assert!(finished.status.code().is_some_and(|code| code > 0), "{:?}", finished.status);
    assert!(error.contains("error: ") && !error.contains("panicked"), "{error}");
    false
}

#[tokio::test(flavor = "multi_thread")]
async fn start_on_a_failing_disk_ends_with_an_error_and_loses_nothing() {
    let layer = Layer::build();
    let mut server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let path = lineage.path("/generations");
    for seed in 0..20 {
        lineage.random(seed).await;
    }
    let listed = all_generations(&server, &path).await;
    server.kill9();
    let (mut failed, mut refused) = (0, 0);
    let each = rounds().div_ceil(FAULTS.len() as u64);
    for fault in FAULTS {
        for step in 0..each {
            layer.arm(
                fault,
                1 + step * (step + 1) / 2,
                if step.is_multiple_of(2) { 1 } else { u64::MAX },
            );
            refused += u32::from(!starts(&layer, &server));
            failed += layer.disarm();
        }
    }
    server.restart();
    assert_eq!(all_generations(&server, &path).await, listed);
    println!(
        "fault: failing calls at the start: {} starts, {failed} calls failed, {refused} refused, 0 lost",
        each * FAULTS.len() as u64
    );
}
