//! kill -9 of server and worker during a search: it ends with the same population as an undisturbed
//! one, unless every worker dies while running it.

use std::time::{Duration, Instant};

use brood_tests::{TestServer, text_of};
use serde_json::{Value, json};

use crate::workers_of;

const GENERATIONS: u32 = 12;

async fn begin(server: &TestServer, target: &str) -> String {
    let body = json!({
        "kind": "fit", "target": target, "strategy": "lobes", "generations": GENERATIONS, "threads": 1,
    });
    text_of(&server.post("/v1/jobs", &body).await.expect(202).json()["id"])
}

fn has_ended(job: &Value) -> bool {
    !["queued", "running"].iter().any(|state| job["state"] == *state)
}

#[tokio::test(flavor = "multi_thread")]
async fn search_killed_five_times_ends_like_an_undisturbed_one() {
    let mut server = TestServer::start();
    let target = server.glossy_target().await;
    let whole = begin(&server, &target).await;
    let whole = server.job_once(&whole, has_ended).await;
    assert_eq!(whole["state"], "succeeded", "{whole}");

    let id = begin(&server, &target).await;
    let mut killed = Vec::new();
    for round in 0..5u64 {
        let seen = server.job_once(&id, |job| job["generation"].as_u64() > Some(2 * round)).await;
        if has_ended(&seen) {
            break;
        }
        // A different moment of a generation in each round.
        tokio::time::sleep(Duration::from_millis(round * 37)).await;
        killed.push(seen["generation"].as_u64().unwrap());
        if round % 2 == 0 {
            server.kill9();
            server.restart();
        } else {
            let workers = workers_of(server.process(), true);
            assert_eq!(workers.len(), 1);
            let worker = workers[0].to_string();
            std::process::Command::new("kill").args(["-9", &worker]).status().unwrap();
        }
    }
    let broken = server.job_once(&id, has_ended).await;
    assert_eq!(broken["state"], "succeeded", "{broken}");
    assert_eq!(broken["population"], whole["population"]);
    assert_eq!(broken["best"]["hash"], whole["best"]["hash"]);
    let log = |id: String| {
        let server = &server;
        async move {
            let text = server.get(&format!("/v1/jobs/{id}/log")).await.expect(200).text();
            let line = |line: &str| {
                let mut line: Value = serde_json::from_str(line).unwrap();
                line.as_object_mut().unwrap().remove("seconds");
                line
            };
            text.lines().map(line).collect::<Vec<_>>()
        }
    };
    let lines = log(id).await;
    assert_eq!(lines, log(text_of(&whole["id"])).await, "equal except for the durations");
    assert_eq!(lines.len(), GENERATIONS as usize, "no generation twice");
    println!(
        "fault: kill -9 during a search: {} times, after generations {killed:?}; the same population after {GENERATIONS}",
        killed.len()
    );
}

#[tokio::test(flavor = "multi_thread")]
async fn search_fails_when_every_worker_dies_running_it_and_the_next_one_succeeds() {
    let server = TestServer::start();
    let target = server.glossy_target().await;
    let id = begin(&server, &target).await;
    let (mut killed, deadline) = (0, Instant::now() + Duration::from_secs(80));
    let lost = loop {
        let job = server.job_once(&id, |_| true).await;
        if has_ended(&job) {
            break job;
        }
        // A reported generation resets the count of deaths.
        if job["state"] == "running" {
            for worker in workers_of(server.process(), true) {
                let kill = ["-9", &worker.to_string()];
                killed += u32::from(
                    std::process::Command::new("kill").args(kill).status().unwrap().success(),
                );
            }
        }
        assert!(Instant::now() < deadline, "{killed} killed: {job}");
        tokio::time::sleep(Duration::from_millis(5)).await;
    };
    assert_eq!((&lost["state"], &lost["reason"]), (&json!("failed"), &json!("worker_lost")));
    assert!(killed >= 3, "{killed}");
    let next = begin(&server, &target).await;
    let next = server.job_once(&next, has_ended).await;
    assert_eq!(next["state"], "succeeded", "{next}");
    println!(
        "fault: kill -9 of every worker of a search: {killed} killed, it failed, the next one did not"
    );
}
