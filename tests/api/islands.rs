//! Searches of several islands: the result depends on the seed and their number alone; pauses, ends
//! and refusals concern all of them.

use brood_tests::{TestServer, text_of};
use reqwest::Method;
use serde_json::{Value, json};

/// Generations of the searches: one migration.
const GENERATIONS: u64 = 40;

async fn begin(server: &TestServer, more: Value) -> String {
    let mut body = json!({"kind": "fit", "target": server.glossy_target().await, "threads": 1, "strategy": "gp"});
    body.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    text_of(&server.post("/v1/jobs", &body).await.expect(202).json()["id"])
}

async fn change(server: &TestServer, id: &str, verb: &str) -> Value {
    let request = server.request(Method::POST, &format!("/v1/jobs/{id}/{verb}"));
    server.send(request).await.expect(200).json()
}

fn is_done(job: &Value) -> bool {
    ["succeeded", "failed", "cancelled"].iter().any(|state| job["state"] == *state)
}

/// Hashes of a search's front, and what else must not depend on workers and pauses.
async fn result(server: &TestServer, job: &Value) -> Value {
    let id = text_of(&job["id"]);
    let front = server.get(&format!("/v1/jobs/{id}/front")).await.expect(200).json();
    let hashes: Vec<Value> =
        front["items"].as_array().unwrap().iter().map(|one| one["hash"].clone()).collect();
    json!([hashes, job["population"], job["evaluations"], job["held"]])
}

#[tokio::test(flavor = "multi_thread")]
async fn result_of_islands_is_the_same_when_they_are_interrupted() {
    let server = TestServer::start();
    let asked = json!({"generations": GENERATIONS, "islands": 3, "seed": "5"});
    let whole = begin(&server, asked.clone()).await;
    let whole = server.job_once(&whole, is_done).await;
    assert_eq!((&whole["state"], &whole["generation"]), (&json!("succeeded"), &json!(GENERATIONS)));
    let each = whole["each_island"].as_array().unwrap();
    let evaluations: u64 = each.iter().map(|one| one["evaluations"].as_u64().unwrap()).sum();
    assert_eq!((each.len(), &whole["evaluations"]), (3, &json!(evaluations)));
    let least = each.iter().map(|one| one["held"].as_f64().unwrap()).fold(f64::INFINITY, f64::min);
    assert_eq!(whole["held"], json!(least));

    let id = text_of(&whole["id"]);
    for (island, lines) in [(0, Some(40)), (2, Some(40)), (3, None)] {
        let log = server.get(&format!("/v1/jobs/{id}/log?island={island}")).await;
        match lines {
            Some(lines) => assert_eq!(log.expect(200).text().lines().count(), lines),
            None => drop(log.problem(404)),
        }
    }
    let jobs = server.get("/v1/jobs").await.expect(200).json();
    assert_eq!(jobs["items"], json!([whole]), "islands are no searches of their own");

    let parted = begin(&server, asked).await;
    for least in [8, 20, 33] {
        server.job_once(&parted, |job| job["generation"].as_u64() >= Some(least)).await;
        assert_eq!(change(&server, &parted, "pause").await["state"], "paused");
        // A worker that waits claims an island at once.
        let resumed = change(&server, &parted, "resume").await;
        assert!(["queued", "running"].iter().any(|state| resumed["state"] == *state), "{resumed}");
    }
    let parted = server.job_once(&parted, is_done).await;
    assert_eq!(result(&server, &parted).await, result(&server, &whole).await);

    let alone = begin(&server, json!({"generations": GENERATIONS, "seed": "5"})).await;
    let alone = server.job_once(&alone, is_done).await;
    assert_eq!((&alone["islands"], &alone["each_island"]), (&json!(1), &json!([])));
    assert!(whole["held"].as_f64() <= alone["held"].as_f64(), "{whole} {alone}");
}

#[tokio::test(flavor = "multi_thread")]
async fn islands_end_together_when_one_reaches_the_target_error() {
    let server = TestServer::start();
    let asked = json!({"generations": 100_000, "islands": 3, "target_error": 0.02});
    let id = begin(&server, asked).await;
    let job = server.job_once(&id, is_done).await;
    assert_eq!(job["state"], "succeeded", "{job}");
    assert!(job["held"].as_f64().unwrap() <= 0.02, "{job}");
}

#[tokio::test(flavor = "multi_thread")]
async fn cancelled_islands_keep_the_best_result() {
    let server = TestServer::start();
    let id = begin(&server, json!({"seconds": 3600, "islands": 2})).await;
    server.job_once(&id, |job| job["generation"].as_u64() > Some(4)).await;
    let cancelled = change(&server, &id, "cancel").await;
    let states = cancelled["each_island"].as_array().unwrap().iter().map(|one| &one["state"]);
    assert_eq!(states.collect::<Vec<_>>(), ["cancelled", "cancelled"]);
    let front = server.get(&format!("/v1/jobs/{id}/front")).await.expect(200).json();
    assert_eq!(front["items"][0]["hash"], cancelled["best"]["hash"]);
}

#[tokio::test(flavor = "multi_thread")]
async fn islands_are_refused_where_nothing_can_migrate() {
    let server = TestServer::start();
    let target = server.glossy_target().await;
    for (more, words) in [
        (json!({"islands": 0}), "must be 1 to 64"),
        (json!({"islands": 65}), "must be 1 to 64"),
        (json!({"islands": 2, "strategy": "lobes"}), "lobes has no islands"),
        (json!({"islands": 2, "strategy": "analytic"}), "analytic has no islands"),
    ] {
        let mut body = json!({"kind": "fit", "target": target, "generations": 3});
        body.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        let problem = server.post("/v1/jobs", &body).await.problem(422);
        assert_eq!(problem["pointer"], "/islands");
        assert!(text_of(&problem["detail"]).contains(words), "{problem}");
    }
}
