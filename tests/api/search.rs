//! Searches: started, watched, paused, resumed and cancelled; results that can be bred; and refused
//! requests.

use std::time::Duration;

use brood_tests::{TestServer, text_of};
use reqwest::Method;
use serde_json::{Value, json};

async fn begin(server: &TestServer, more: Value) -> String {
    let mut body = json!({"kind": "fit", "target": server.glossy_target().await, "threads": 1, "strategy": "lobes"});
    body.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    text_of(&server.post("/v1/jobs", &body).await.expect(202).json()["id"])
}

async fn change(server: &TestServer, id: &str, verb: &str) -> brood_tests::Answer {
    server.send(server.request(Method::POST, &format!("/v1/jobs/{id}/{verb}"))).await
}

fn is_done(job: &Value) -> bool {
    ["succeeded", "failed", "cancelled"].iter().any(|state| job["state"] == *state)
}

#[tokio::test(flavor = "multi_thread")]
async fn search_ends_with_a_front_whose_best_can_be_bred() {
    let server = TestServer::start();
    let id = begin(&server, json!({"generations": 3, "seed": "7"})).await;
    let path = format!("/v1/jobs/{id}");
    let job = server.job_once(&id, is_done).await;
    assert_eq!((&job["state"], &job["progress"]), (&json!("succeeded"), &json!(1.0)), "{job}");
    assert_eq!((&job["generation"], &job["seed"]), (&json!(3), &json!(7)), "{job}");
    assert_eq!(job["budget"], json!({"generations": 3}));
    assert_eq!(job["objective"], "seen");
    assert_eq!(text_of(&job["population"]).len(), 64);
    let best = &job["best"];
    assert!(best["e_log"].as_f64().unwrap() < 0.05, "{job}");
    server.get(&text_of(&best["thumbnail"])).await.expect(200).picture();
    server.get(&format!("/v1/genomes/{}", text_of(&best["hash"]))).await.expect(200);

    let front = server.get(&format!("{path}/front")).await.expect(200).json();
    let front = front["items"].as_array().unwrap();
    assert_eq!(&front[0], best);
    let log = server.get(&format!("{path}/log")).await.expect(200);
    assert_eq!(log.header("content-type"), "application/x-ndjson");
    let lines: Vec<Value> =
        log.text().lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let generations: Vec<_> = lines.iter().map(|line| line["generation"].clone()).collect();
    assert_eq!(generations, [1, 2, 3].map(Value::from));
    assert_eq!(lines[2]["held"], job["held"]);
    let rest = server.get(&format!("{path}/log?after=2")).await.expect(200).text();
    assert_eq!(rest.lines().count(), 1);

    // History: each best is the parent of the next, and the front comes last.
    let lineage = format!("/v1/lineages/{}", text_of(&job["lineage"]));
    let history = server.get(&format!("{lineage}/generations")).await.expect(200).json();
    let history = history["items"].as_array().unwrap();
    for pair in history.windows(2) {
        assert_eq!(pair[1]["parents"], json!([pair[0]["individuals"][0]["id"]]));
    }
    let last = history.last().unwrap();
    assert_eq!(last["individuals"].as_array().unwrap().len(), front.len());
    assert!(last["individuals"].as_array().unwrap().iter().all(|one| one["operator"] == "fit"));
    let body = json!({"parents": [best["individual"]], "count": 4, "seed": 1});
    let bred = server.post(&format!("{lineage}/generations"), &body).await.expect(201).json();
    assert_eq!(bred["individuals"].as_array().unwrap().len(), 4);
    // The whole lineage can be exported and imported.
    let file = server.get(&format!("{lineage}/file")).await.expect(200).body;
    server.post_bytes("/v1/lineages/import", "application/json", file).await.expect(201);
    let jobs = server.get("/v1/jobs").await.expect(200).json();
    assert_eq!(jobs["items"], json!([job]));
}

#[tokio::test(flavor = "multi_thread")]
async fn search_stops_while_paused_and_ends_when_cancelled() {
    let server = TestServer::start();
    let id = begin(&server, json!({"seconds": 3600})).await;
    server.job_once(&id, |job| job["generation"].as_u64() > Some(1)).await;
    change(&server, &id, "resume").await.problem(409);
    let paused = change(&server, &id, "pause").await.expect(200).json();
    assert_eq!(paused["state"], "paused");
    change(&server, &id, "pause").await.problem(409);
    // The worker adds what it had computed.
    let saved = server.job_once(&id, |job| job["population"] != paused["population"]).await;
    assert!(saved["generation"].as_u64() >= paused["generation"].as_u64());
    tokio::time::sleep(Duration::from_millis(600)).await;
    let still = server.job_once(&id, |_| true).await;
    assert_eq!(still["generation"], saved["generation"]);
    assert_eq!(still["population"], saved["population"]);
    change(&server, &id, "resume").await.expect(200);
    let before = saved["generation"].as_u64();
    let resumed = server.job_once(&id, |job| job["state"] == "running").await;
    assert!(resumed["generation"].as_u64() >= before, "nothing is computed again");
    server.job_once(&id, |job| job["generation"].as_u64() > before).await;
    let cancelled = change(&server, &id, "cancel").await.expect(200).json();
    assert_eq!(cancelled["state"], "cancelled");
    for verb in ["pause", "resume", "cancel"] {
        let problem = change(&server, &id, verb).await.problem(409);
        assert!(text_of(&problem["detail"]).contains("cancelled"), "{problem}");
    }
    let front = server.get(&format!("/v1/jobs/{id}/front")).await.expect(200).json();
    assert_eq!(front["items"][0]["hash"], cancelled["best"]["hash"], "the best result is kept");
}

#[tokio::test(flavor = "multi_thread")]
async fn searches_take_turns_when_there_are_more_than_workers() {
    let server = TestServer::start();
    // A worker runs four at once; after 20 s one yields to the fifth.
    let mut all = Vec::new();
    for _ in 0..5 {
        all.push(begin(&server, json!({"seconds": 3600})).await);
    }
    for id in &all {
        server.job_once(id, |job| job["generation"].as_u64() > Some(0)).await;
    }
    let jobs = server.get("/v1/jobs").await.expect(200).json();
    let states = jobs["items"].as_array().unwrap().iter().map(|job| text_of(&job["state"]));
    let waiting: Vec<String> = states.filter(|state| state != "running").collect();
    assert_eq!(waiting, ["queued"], "{jobs}");
    for id in &all {
        change(&server, id, "cancel").await.expect(200);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn search_is_started_once_per_key_and_is_reproducible_when_interrupted() {
    let server = TestServer::start();
    let target = server.glossy_target().await;
    let body = json!({"kind": "fit", "target": target, "generations": 6, "threads": 1});
    let ask = async |key: &str| {
        let request = server.request(Method::POST, "/v1/jobs").header("idempotency-key", key);
        server.send(request.json(&body)).await.expect(202)
    };
    let first = ask("a").await;
    let id = text_of(&first.json()["id"]);
    assert_eq!(first.header("location"), format!("/v1/jobs/{id}"));
    assert_eq!(ask("a").await.json(), first.json());
    let whole = server.job_once(&id, is_done).await;
    let parted = text_of(&ask("b").await.json()["id"]);
    assert_ne!(parted, id);
    for _ in 0..3 {
        tokio::time::sleep(Duration::from_millis(150)).await;
        if change(&server, &parted, "pause").await.status == 200 {
            change(&server, &parted, "resume").await.expect(200);
        }
    }
    let parted = server.job_once(&parted, is_done).await;
    assert_eq!(parted["population"], whole["population"]);
    assert_eq!(parted["best"]["hash"], whole["best"]["hash"]);
}

#[tokio::test(flavor = "multi_thread")]
async fn search_is_refused_when_a_value_is_invalid() {
    let server = TestServer::start();
    let target = server.glossy_target().await;
    let unknown = "01890000-0000-7000-8000-000000000000";
    let paper = server.post("/v1/lineages", &json!({"name": "by eye"})).await.expect(201).json();
    let rows = [
        (422, "/kind", json!({"kind": "render", "seconds": 1})),
        (422, "", json!({})),
        (422, "", json!({"seconds": 1, "generations": 1})),
        (422, "/seconds", json!({"seconds": 0})),
        (422, "/seconds", json!({"seconds": 1e9})),
        (422, "/generations", json!({"generations": 1_000_000_000})),
        (422, "/generations", json!({"generations": 0})),
        (422, "/evaluations", json!({"evaluations": u64::MAX})),
        (422, "/threads", json!({"seconds": 1, "threads": 0})),
        (422, "/threads", json!({"seconds": 1, "threads": 100_000})),
        (422, "/strategy", json!({"seconds": 1, "strategy": "guessing"})),
        (422, "/objective", json!({"seconds": 1, "objective": "elog"})),
        (422, "/objective", json!({"seconds": 1, "strategy": "gp", "objective": "seen"})),
        (422, "/target_error", json!({"seconds": 1, "target_error": 0})),
        (422, "/lineage", json!({"seconds": 1, "lineage": paper["id"]})),
        (404, "/lineage", json!({"seconds": 1, "lineage": unknown})),
        (404, "/target", json!({"seconds": 1, "target": unknown})),
        (404, "/start/0", json!({"seconds": 1, "start": [unknown]})),
        (400, "/colour", json!({"seconds": 1, "colour": "red"})),
    ];
    for (status, pointer, more) in rows {
        let mut body = json!({"kind": "fit", "target": target});
        body.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        let problem = server.post("/v1/jobs", &body).await.problem(status);
        assert_eq!(problem["pointer"], pointer, "{body}: {problem}");
    }
    for path in ["front", "log", "events"] {
        server.get(&format!("/v1/jobs/{unknown}/{path}")).await.problem(404);
    }
    change(&server, unknown, "pause").await.problem(404);
    assert_eq!(server.get("/v1/jobs").await.expect(200).json()["items"], json!([]));
}

#[tokio::test(flavor = "multi_thread")]
async fn stream_has_the_progress_of_a_search() {
    let server = TestServer::start();
    let id = begin(&server, json!({"seconds": 3600})).await;
    let lineage = text_of(&server.job_once(&id, |_| true).await["lineage"]);
    let listen = async |path: &str| {
        let request = server.request(Method::GET, path).header("last-event-id", "x");
        request.send().await.unwrap()
    };
    let mut own = listen(&format!("/v1/jobs/{id}/events")).await;
    let mut birthplace = listen(&format!("/v1/lineages/{lineage}/events")).await;
    server.job_once(&id, |job| !job["best"].is_null()).await;
    change(&server, &id, "cancel").await.expect(200);
    let (mut told, mut there) = (String::new(), String::new());
    let hear = async {
        while !told.contains("\"cancelled\"") {
            told += &String::from_utf8_lossy(&own.chunk().await.unwrap().expect("it goes on"));
        }
        while !there.contains("\"cancelled\"") {
            let chunk = birthplace.chunk().await.unwrap().expect("it goes on");
            there += &String::from_utf8_lossy(&chunk);
        }
    };
    tokio::time::timeout(Duration::from_secs(30), hear).await.expect("the events arrive");
    assert!(told.contains("event: resync") && told.contains("event: state"), "{told}");
    assert!(there.contains("event: job"), "{there}");
}
