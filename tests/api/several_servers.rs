//! Several servers on one PostgreSQL database. The tests do nothing on SQLite.

use std::time::Duration;

use brood_tests::{ServerOptions, TestLineage, TestServer, ids, text_of};
use reqwest::Method;
use serde_json::{Value, json};

use crate::archive::entries;
use crate::event::{Event, open, read};

/// Starts two servers on one database, the first without workers.
fn two_servers() -> Option<[TestServer; 2]> {
    let first = TestServer::start_with(ServerOptions { workers: 0, ..ServerOptions::default() });
    let second = first.beside(ServerOptions::default())?;
    Some([first, second])
}

#[tokio::test(flavor = "multi_thread")]
async fn events_of_one_server_reach_the_clients_of_another() {
    let Some([first, second]) = two_servers() else { return };
    let lineage = TestLineage::new(&first).await;
    let mut stream = open(&second, &lineage.path("/events"), None).await;
    let born = lineage.random(1).await;
    let events = read(&mut stream, |events| !events.is_empty()).await;
    assert_eq!((events[0].name.as_str(), &events[0].data["id"]), ("generation", &born["id"]));
    let seen = second.get(&lineage.path("/generations")).await.expect(200).json();
    assert_eq!(seen["items"][0]["id"], born["id"]);
    // The other server renders what it is asked for.
    let thumbnail = text_of(&born["individuals"][0]["thumbnail"]);
    second.get(&thumbnail).await.expect(200).picture();
}

#[tokio::test(flavor = "multi_thread")]
async fn one_key_at_two_servers_has_one_effect_and_one_answer() {
    let Some(servers) = two_servers() else { return };
    let lineage = TestLineage::new(&servers[0]).await;
    let path = lineage.path("/generations");
    for round in 0..10 {
        let body = json!({"parents": [], "count": 4});
        let births = servers.each_ref().map(|server| {
            let request = server.request(Method::POST, &path);
            let request = request.header("idempotency-key", format!("key {round}"));
            server.send(request.json(&body))
        });
        let answers = futures::future::join_all(births).await;
        let born: Vec<Value> =
            answers.into_iter().map(|answer| answer.expect(201).json()).collect();
        assert_eq!(born[0], born[1]);
    }
    let listed = servers[1].get(&path).await.expect(200).json();
    assert_eq!(listed["items"].as_array().unwrap().len(), 10);
}

#[tokio::test(flavor = "multi_thread")]
async fn search_of_one_server_runs_at_another_and_its_events_come_back() {
    let Some([first, second]) = two_servers() else { return };
    let target = first.glossy_target().await;
    let body = json!({
        "kind": "fit", "target": target, "strategy": "lobes", "generations": 5, "threads": 1,
    });
    let id = text_of(&first.post("/v1/jobs", &body).await.expect(202).json()["id"]);
    let mut stream = open(&first, &format!("/v1/jobs/{id}/events"), None).await;
    let is_end = |event: &Event| event.name == "state" && event.data["state"] == "succeeded";
    read(&mut stream, |events| events.iter().any(is_end)).await;
    let job = second.job_once(&id, |_| true).await;
    assert_eq!(job["state"], "succeeded");
}

#[tokio::test(flavor = "multi_thread")]
async fn search_of_a_killed_server_continues_at_another() {
    let Some([first, mut second]) = two_servers() else { return };
    let target = first.glossy_target().await;
    let body = json!({
        "kind": "fit", "target": target, "strategy": "lobes", "seconds": 3600, "threads": 1,
    });
    let id = text_of(&first.post("/v1/jobs", &body).await.expect(202).json()["id"]);
    first.job_once(&id, |job| job["generation"].as_u64() > Some(0)).await;
    second.kill9();
    let left = first.job_once(&id, |_| true).await;
    assert_eq!(left["state"], "running");
    let third = first.beside(ServerOptions::default()).unwrap();
    let further = |job: &Value| job["generation"].as_u64() > left["generation"].as_u64();
    third.job_once(&id, further).await;
    third.post(&format!("/v1/jobs/{id}/cancel"), &json!({})).await.expect(200);
}

#[tokio::test(flavor = "multi_thread")]
async fn search_that_is_paused_by_one_key_at_two_servers_is_paused_once_and_loses_nothing() {
    let Some(servers) = two_servers() else { return };
    let target = servers[0].glossy_target().await;
    let body = json!({
        "kind": "fit", "target": target, "strategy": "lobes", "generations": 2000, "threads": 1,
    });
    let id = text_of(&servers[0].post("/v1/jobs", &body).await.expect(202).json()["id"]);
    servers[0].job_once(&id, |job| job["generation"].as_u64() > Some(0)).await;
    let pauses = servers.each_ref().map(|server| {
        let request = server.request(Method::POST, &format!("/v1/jobs/{id}/pause"));
        server.send(request.header("idempotency-key", "pause"))
    });
    for answer in futures::future::join_all(pauses).await {
        assert_eq!(answer.expect(200).json()["state"], "paused");
    }
    // The worker saves what it had computed.
    let saved = servers[1].job_once(&id, |job| !job["population"].is_null()).await;
    let log = format!("/v1/jobs/{id}/log");
    let computed = servers[0].get(&log).await.expect(200).body;
    servers[0].post(&format!("/v1/jobs/{id}/resume"), &json!({})).await.expect(200);
    let resumed = servers[0].job_once(&id, |job| job["state"] == "running").await;
    assert!(resumed["generation"].as_u64() >= saved["generation"].as_u64());
    // Generations that were computed again would have other times.
    assert!(servers[1].get(&log).await.expect(200).body.starts_with(&computed));
    servers[1].post(&format!("/v1/jobs/{id}/cancel"), &json!({})).await.expect(200);
}

#[tokio::test(flavor = "multi_thread")]
async fn removed_genomes_are_served_by_no_server() {
    let Some([first, second]) = two_servers() else { return };
    let lineage = TestLineage::new(&first).await;
    let born = lineage.random(7).await;
    let genome = format!("/v1/genomes/{}", text_of(&born["individuals"][0]["hash"]));
    second.get(&genome).await.expect(200);
    first.delete(&lineage.path("?purge=true")).await.expect(204);
    for _ in 0..100 {
        if second.get(&genome).await.status == 404 {
            return;
        }
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    panic!("the other server still has a removed genome");
}

/// Starts an export of tables. Returns the path of its job.
async fn start_export(server: &TestServer, brood: &Value) -> String {
    let body = json!({"individuals": ids(brood), "formats": ["rgl-bsdf"]});
    let export = server.post("/v1/exports", &body).await.expect(202).json();
    format!("/v1/jobs/{}", text_of(&export["id"]))
}

/// Waits until an export has this state at a server.
async fn export_in_state(server: &TestServer, job: &str, state: &str) -> Value {
    server.job_once(job.trim_start_matches("/v1/jobs/"), |job| job["state"] == state).await
}

/// Number of files and folders of exports in a data directory.
fn on_disk(server: &TestServer) -> usize {
    std::fs::read_dir(server.data().join("exports")).unwrap().count()
}

#[tokio::test(flavor = "multi_thread")]
async fn export_of_one_server_is_downloaded_at_others() {
    let Some([first, mut second]) = two_servers() else { return };
    let lineage = TestLineage::new(&first).await;
    let brood = lineage.random(1).await;
    let job = start_export(&first, &brood).await;
    export_in_state(&first, &job, "succeeded").await;
    let path = format!("{job}/archive.zip");
    let archive = first.get(&path).await.expect(200).body;
    assert!(second.get(&path).await.expect(200).body == archive);
    assert_eq!([&first, &second].map(on_disk), [0, 0]);
    let direct = format!("/v1/exports.zip?individuals={}&formats=rgl-bsdf", ids(&brood).join(","));
    let direct = first.get(&direct).await.expect(200).body;
    assert!(entries(direct) == entries(archive.clone()));

    // The worker of the second server has made the files.
    second.kill9();
    assert!(first.get(&path).await.expect(200).body == archive);
    let third = first.beside(ServerOptions::default()).unwrap();
    assert!(third.get(&path).await.expect(200).body == archive);
    assert_eq!(export_in_state(&third, &job, "succeeded").await["made"], 4);
}

#[tokio::test(flavor = "multi_thread")]
async fn export_that_runs_at_one_server_is_cancelled_at_another() {
    let Some([first, second]) = two_servers() else { return };
    let lineage = TestLineage::new(&first).await;
    let brood = lineage.breed(json!({"parents": [], "count": 60, "seed": 2})).await;
    let job = start_export(&first, &brood).await;
    let id = job.trim_start_matches("/v1/jobs/");
    second.job_once(id, |job| job["made"].as_u64() >= Some(1)).await;
    let cancel = first.request(Method::POST, &format!("{job}/cancel"));
    let cancelled = first.send(cancel).await.expect(200).json();
    assert_eq!((&cancelled["state"], &cancelled["bytes"]), (&json!("cancelled"), &json!(0)));
    for server in [&first, &second] {
        let seen = server.get(&job).await.expect(200).json();
        assert_eq!((&seen["state"], &seen["bytes"]), (&json!("cancelled"), &json!(0)));
        let problem = server.get(&format!("{job}/archive.zip")).await.problem(409);
        assert!(text_of(&problem["detail"]).contains("cancelled"), "{problem}");
        assert_eq!(on_disk(server), 0);
    }
    // The worker takes the next one.
    let next = start_export(&first, &lineage.random(1).await).await;
    export_in_state(&second, &next, "succeeded").await;
}
