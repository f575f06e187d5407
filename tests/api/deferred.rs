//! Deferred answers: requests with `Prefer: respond-async`.

use brood_tests::{Answer, TestLineage, TestServer, ids, text_of};
use reqwest::Method;
use serde_json::{Value, json};

use crate::fair::jobs;

/// Sends a request whose answer may be deferred.
async fn prefer(server: &TestServer, path: &str, body: Option<&Value>, prefer: &str) -> Answer {
    let method = if body.is_some() { Method::POST } else { Method::GET };
    let mut request = server.request(method, path).header("prefer", prefer);
    if let Some(body) = body {
        request = request.json(body);
    }
    server.send(request).await
}

/// Returns the id of the job of a deferred answer.
fn job_of(answer: Answer) -> String {
    let answer = answer.expect(202);
    assert_eq!(answer.header("preference-applied"), "respond-async");
    let job = answer.json();
    assert_eq!((&job["kind"], &job["state"]), (&json!("answer"), &json!("running")), "{job}");
    let id = text_of(&job["id"]);
    assert_eq!(answer.header("location"), format!("/v1/jobs/{id}"));
    id
}

/// Waits for the end of a job. Returns the job, and the values that its progress had.
async fn ended(server: &TestServer, id: &str) -> (Value, Vec<f64>) {
    let mut seen = Vec::new();
    loop {
        let job = server.get(&format!("/v1/jobs/{id}")).await.expect(200).json();
        let progress = job["progress"].as_f64().unwrap();
        if seen.last() != Some(&progress) {
            seen.push(progress);
        }
        if job["state"] != "running" {
            assert!(seen.is_sorted() && seen.iter().all(|it| (0.0..=1.0).contains(it)), "{seen:?}");
            return (job, seen);
        }
        tokio::time::sleep(std::time::Duration::from_millis(20)).await;
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn long_picture_is_answered_by_a_job_with_progress() {
    let server = TestServer::start();
    let id = TestLineage::new(&server).await.random_child(4).await;
    let path = format!("/v1/individuals/{id}/render.png?size=2048&samples=4");
    let job = job_of(prefer(&server, &path, None, "respond-async, wait=0").await);
    let answer = format!("/v1/jobs/{job}/answer");
    server.get(&answer).await.problem(409);
    let (job, progress) = ended(&server, &job).await;
    println!("progress: {progress:?}");
    assert_eq!((&job["state"], &job["status"]), (&json!("succeeded"), &json!(200)), "{job}");
    assert_eq!((&job["request"], &job["method"]), (&json!(path), &json!("GET")), "{job}");
    assert_eq!(text_of(&job["answer"]), answer);
    let answer = server.get(&answer).await.expect(200);
    assert_eq!(answer.header("content-type"), "image/png");
    assert_eq!(answer.header("cache-control"), "no-store");
    assert_eq!(answer.picture().dimensions(), (2048, 2048));
    let waited = server.get(&path).await.expect(200);
    assert!(waited.body == answer.body && waited.header("etag") == answer.header("etag"));
    // An answer that is ready is not deferred.
    prefer(&server, &path, None, "respond-async, wait=10").await.expect(200);
    assert_eq!(server.metric("brood_deferred_requests").await, 0);
}

#[tokio::test(flavor = "multi_thread")]
async fn large_brood_sheet_and_comparison_are_answered_by_jobs() {
    let server = TestServer::start();
    let lineage = TestLineage::with(&server, json!({"name": "large", "start": "wild"})).await;
    let body = json!({"parents": [], "count": 256, "seed": 3, "energy_limit": true});
    let path = lineage.path("/generations");
    let job = job_of(prefer(&server, &path, Some(&body), "respond-async, wait=0").await);
    let (ended_brood, progress) = ended(&server, &job).await;
    assert!(progress.len() > 2, "the children are counted: {progress:?}");
    assert_eq!(ended_brood["status"], 201, "{ended_brood}");
    let answer = server.get(&format!("/v1/jobs/{job}/answer")).await.expect(201);
    let generation = answer.json();
    let location = answer.header("location");
    assert_eq!(location, format!("/v1/generations/{}", text_of(&generation["id"])));
    assert_eq!(server.get(&location).await.expect(200).json()["id"], generation["id"]);
    let members = ids(&generation);
    assert_eq!(members.len(), 256);
    assert!(members.is_sorted(), "ids follow the slots");

    let sheet = format!("{location}/sheet.png");
    let comparison = format!("/v1/comparison?materials={},{}&size=512", members[0], members[1]);
    for path in [sheet, comparison] {
        let job = job_of(prefer(&server, &path, None, "respond-async, wait=0").await);
        let (job, progress) = ended(&server, &job).await;
        println!("{path}: {progress:?}");
        assert_eq!(job["state"], "succeeded", "{job}");
        let answer = server.get(&text_of(&job["answer"])).await.expect(200);
        assert_eq!(answer.body, server.get(&path).await.expect(200).body);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn refused_request_is_not_deferred() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let path = lineage.path("/generations");
    let body = json!({"parents": [], "count": 1000});
    let problem = prefer(&server, &path, Some(&body), "respond-async").await.problem(422);
    assert_eq!(problem["pointer"], "/count");
}

#[tokio::test(flavor = "multi_thread")]
async fn cancelled_request_is_not_rendered_and_has_no_answer() {
    let server = TestServer::start();
    let id = TestLineage::new(&server).await.random_child(4).await;
    let path = format!("/v1/individuals/{id}/render.png?size=2048&samples=4");
    let job = job_of(prefer(&server, &path, None, "respond-async, wait=0").await);
    while jobs(&server, "batch", "leased").await == 0 {
        tokio::time::sleep(std::time::Duration::from_millis(1)).await;
    }
    let cancel = format!("/v1/jobs/{job}/cancel");
    let cancelled = server.post(&cancel, &json!({})).await.expect(200).json();
    assert_eq!(cancelled["state"], "cancelled", "{cancelled}");
    server.post(&cancel, &json!({})).await.expect(200);
    server.get(&format!("/v1/jobs/{job}/answer")).await.problem(409);
    server.get(&format!("/v1/jobs/{id}/answer")).await.problem(404);
    while server.metric("brood_jobs_abandoned_total").await == 0 {
        tokio::time::sleep(std::time::Duration::from_millis(20)).await;
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn client_defers_at_most_16_answers_and_interactive_pictures_still_come() {
    let server = TestServer::start();
    let id = TestLineage::new(&server).await.random_child(4).await;
    let path = |size: u32| format!("/v1/individuals/{id}/render.png?size={size}&samples=4");
    let mut jobs = Vec::new();
    for size in 2000..2016 {
        jobs.push(job_of(prefer(&server, &path(size), None, "respond-async, wait=0").await));
    }
    let refused = prefer(&server, &path(1999), None, "respond-async, wait=0").await;
    refused.problem(503);
    let cancelled = server.post(&format!("/v1/jobs/{}/cancel", jobs[0]), &json!({})).await;
    cancelled.expect(200);
    job_of(prefer(&server, &path(1999), None, "respond-async, wait=0").await);
    // Interactive pictures do not wait for them.
    let small = format!("/v1/individuals/{id}/render.png?size=64");
    server.get(&small).await.expect(200).picture();
}
