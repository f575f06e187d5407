//! `Idempotency-Key`: a repeated request has one effect.

use brood_tests::{TestLineage, TestServer, hashes, text_of};
use reqwest::Method;
use serde_json::{Value, json};

async fn keyed(server: &TestServer, path: &str, key: &str, body: &Value) -> brood_tests::Answer {
    let request = server.request(Method::POST, path).header("idempotency-key", key);
    server.send(request.json(body)).await
}

#[tokio::test(flavor = "multi_thread")]
async fn answer_is_the_same_when_key_and_body_are_the_same() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let path = lineage.path("/generations");
    let key = uuid::Uuid::now_v7().to_string();
    let body = json!({"parents": [], "count": 3});
    let first = keyed(&server, &path, &key, &body).await.expect(201).json();
    let again = keyed(&server, &path, &key, &body).await.expect(201).json();
    assert_eq!(first, again, "the drawn seed is the same");
    let listed = server.get(&path).await.expect(200).json();
    assert_eq!(listed["items"].as_array().unwrap().len(), 1);
    let other = uuid::Uuid::now_v7().to_string();
    let other = keyed(&server, &path, &other, &body).await.expect(201).json();
    assert_ne!(hashes(&first), hashes(&other));
}

#[tokio::test(flavor = "multi_thread")]
async fn request_is_refused_when_the_key_was_used_with_another_body() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let path = lineage.path("/generations");
    keyed(&server, &path, "one", &json!({"parents": [], "count": 3})).await.expect(201);
    keyed(&server, &path, "one", &json!({"parents": [], "count": 4})).await.problem(422);
}

#[tokio::test(flavor = "multi_thread")]
async fn one_generation_is_bred_when_the_same_request_arrives_many_times_at_once() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let path = lineage.path("/generations");
    let body = json!({"parents": [], "count": 8});
    let requests = (0..8).map(|_| keyed(&server, &path, "many", &body));
    let mut born = Vec::new();
    for answer in futures::future::join_all(requests).await {
        match answer.status {
            201 => born.push(answer.json()),
            _ => drop(answer.problem(409)),
        }
    }
    assert!(!born.is_empty());
    assert!(born.iter().all(|generation| *generation == born[0]));
    let listed = server.get(&path).await.expect(200).json();
    assert_eq!(listed["items"].as_array().unwrap().len(), 1);
}

#[tokio::test(flavor = "multi_thread")]
async fn key_works_for_every_resource_that_can_be_created() {
    let server = TestServer::start();
    let rows =
        [("/v1/lineages", json!({"name": "twice"})), ("/v1/scenes", json!({"mesh": "torus"}))];
    for (path, body) in rows {
        let first = keyed(&server, path, "key", &body).await.expect(201).json();
        let again = keyed(&server, path, "key", &body).await.expect(201).json();
        assert_eq!(first, again, "{path}");
    }
    let lineages = server.get("/v1/lineages").await.expect(200).json();
    assert_eq!(lineages["items"].as_array().unwrap().len(), 1);
}

#[tokio::test(flavor = "multi_thread")]
async fn key_is_refused_unless_it_is_printable() {
    let server = TestServer::start();
    let long = "x".repeat(256);
    for key in ["", "a\tb", "\u{e4}", &long] {
        let body = json!({"name": "refused"});
        let problem = keyed(&server, "/v1/lineages", key, &body).await.problem(400);
        assert!(text_of(&problem["detail"]).contains("printable"), "{key:?}: {problem}");
    }
}
