//! Exports as jobs: files of workers, progress, events, download, cancel, restart, and refused
//! requests.

use brood_tests::{TestLineage, TestServer, ids, text_of};
use reqwest::Method;
use serde_json::{Value, json};

use crate::archive::{entries, manifest};

fn has_ended(job: &Value) -> bool {
    !["queued", "running"].iter().any(|state| job["state"] == *state)
}

async fn begin(server: &TestServer, body: &Value) -> String {
    text_of(&server.post("/v1/exports", body).await.expect(202).json()["id"])
}

async fn cancel(server: &TestServer, id: &str) -> brood_tests::Answer {
    server.send(server.request(Method::POST, &format!("/v1/jobs/{id}/cancel"))).await
}

/// True if files of exports are on disk. On PostgreSQL they are in the database, see
/// `several_servers`.
fn are_on_disk() -> bool {
    std::env::var_os("BROOD_TEST_DATABASE").is_none()
}

/// Number of folders of jobs on disk.
fn folders(server: &TestServer) -> usize {
    std::fs::read_dir(server.data().join("exports")).unwrap().count()
}

#[tokio::test(flavor = "multi_thread")]
async fn export_job_makes_the_archive_that_a_request_makes() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let brood = lineage.random(1).await;
    let formats = ["brood", "rgl-bsdf", "merl", "png", "wgsl"];
    let body = json!({"generation": brood["id"], "formats": formats, "size": 32});
    let queued = server.post("/v1/exports", &body).await.expect(202);
    let id = text_of(&queued.json()["id"]);
    assert_eq!(queued.header("location"), format!("/v1/jobs/{id}"));
    let queued = queued.json();
    assert_eq!((&queued["kind"], &queued["files"]), (&json!("export"), &json!(12)), "{queued}");
    let job = server.job_once(&id, has_ended).await;
    assert_eq!((&job["state"], &job["made"]), (&json!("succeeded"), &json!(12)), "{job}");
    assert!(job["bytes"].as_u64() > Some(4_000_000) && job["progress"] == 1.0, "{job}");
    assert!(job["expires_ms"].as_u64() > job["ended_ms"].as_u64(), "{job}");
    let archive = server.get(&text_of(&job["archive"])).await.expect(200);
    assert_eq!(archive.header("content-type"), "application/zip");
    let path = format!(
        "/v1/exports.zip?generation={}&formats={}&size=32",
        text_of(&brood["id"]),
        formats.join(",")
    );
    let direct = server.get(&path).await.expect(200).body;
    assert!(entries(archive.body) == entries(direct), "the manifest included");
    // Events end with the state.
    let request = server.request(Method::GET, &format!("/v1/jobs/{id}/events"));
    assert_eq!(request.send().await.unwrap().status(), 200);
    let problem = cancel(&server, &id).await.problem(409);
    assert!(text_of(&problem["detail"]).contains("succeeded"), "{problem}");

    if !are_on_disk() {
        return;
    }
    // A lost file is made again.
    let lost = server.data().join("exports").join(&id).join("1");
    let bytes = std::fs::read(&lost).unwrap();
    std::fs::remove_file(&lost).unwrap();
    let path = format!("/v1/jobs/{id}/archive.zip");
    let problem = server.get(&path).await.problem(409);
    assert!(text_of(&problem["detail"]).contains("made again"), "{problem}");
    server.job_once(&id, has_ended).await;
    server.get(&path).await.expect(200);
    assert!(std::fs::read(&lost).unwrap() == bytes, "the same bytes");
}

#[tokio::test(flavor = "multi_thread")]
async fn export_job_survives_kill_9_and_keeps_the_files_that_are_made() {
    let mut server = TestServer::start();
    let (id, names) = {
        let lineage = TestLineage::new(&server).await;
        let brood = lineage.breed(json!({"parents": [], "count": 12, "seed": 5})).await;
        let body = json!({"individuals": ids(&brood), "formats": ["rgl-bsdf", "brood"]});
        (begin(&server, &body).await, ids(&brood))
    };
    for made in [2, 9] {
        let seen = server.job_once(&id, |job| job["made"].as_u64() >= Some(made)).await;
        server.kill9();
        server.restart();
        let again = server.get(&format!("/v1/jobs/{id}")).await.expect(200).json();
        assert!(again["made"].as_u64() >= seen["made"].as_u64(), "{seen} {again}");
    }
    let job = server.job_once(&id, has_ended).await;
    assert_eq!((&job["state"], &job["made"]), (&json!("succeeded"), &json!(24)), "{job}");
    server.kill9();
    server.restart();
    let found = entries(server.get(&format!("/v1/jobs/{id}/archive.zip")).await.expect(200).body);
    assert_eq!(found.len(), 25);
    let manifest = manifest(&found);
    for (material, individual) in manifest["materials"].as_array().unwrap().iter().zip(&names) {
        assert_eq!(material["individual"], json!(individual));
        assert!(text_of(&material["files"][0]["note"]).contains("; error "));
    }
    for path in [format!("/v1/individuals/{}/exports/rgl-bsdf", names[11])] {
        assert!(found[22].1 == server.get(&path).await.expect(200).body, "the same table");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn cancelled_export_job_leaves_no_files() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let brood = lineage.breed(json!({"parents": [], "count": 60, "seed": 2})).await;
    let id = begin(&server, &json!({"generation": brood["id"], "formats": ["rgl-bsdf"]})).await;
    server.job_once(&id, |job| job["made"].as_u64() >= Some(1)).await;
    let cancelled = cancel(&server, &id).await.expect(200).json();
    assert_eq!((&cancelled["state"], &cancelled["bytes"]), (&json!("cancelled"), &json!(0)));
    let problem = server.get(&format!("/v1/jobs/{id}/archive.zip")).await.problem(409);
    assert!(text_of(&problem["detail"]).contains("cancelled"), "{problem}");
    cancel(&server, &id).await.problem(409);
    // The worker takes the next one.
    let next = json!({"individuals": [ids(&brood)[0]], "formats": ["samples-csv"]});
    let next = begin(&server, &next).await;
    assert_eq!(server.job_once(&next, has_ended).await["state"], "succeeded");
    assert_eq!(folders(&server), usize::from(are_on_disk()));
}

#[tokio::test(flavor = "multi_thread")]
async fn export_job_is_started_once_for_a_key_and_refused_with_reasons() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let one = lineage.random_child(1).await;
    let unknown = "01900000-0000-7000-8000-000000000000";
    let body = json!({"individuals": [one, one], "formats": ["samples-csv"]});
    let keyed = || server.request(Method::POST, "/v1/exports").header("idempotency-key", "a");
    let first = server.send(keyed().json(&body)).await.expect(202).json();
    let again = server.send(keyed().json(&body)).await.expect(202).json();
    assert_eq!((&first["id"], &first["files"]), (&again["id"], &json!(1)));
    server.send(keyed().json(&json!({"formats": ["wgsl"]}))).await.problem(422);
    let many: Vec<String> = (0..257).map(|n| format!("01900000-0000-7000-8000-{n:012}")).collect();
    let rows = [
        (422, json!({"formats": ["wgsl"]}), "exactly one"),
        (
            422,
            json!({"individuals": [one], "generation": unknown, "formats": ["wgsl"]}),
            "exactly one",
        ),
        (422, json!({"individuals": [one], "formats": ["docx"]}), "glsl-es-300"),
        (422, json!({"individuals": [one], "formats": ["png"]}), "no file for a worker"),
        (422, json!({"individuals": [one], "formats": []}), "no file for a worker"),
        (422, json!({"individuals": [one], "formats": ["merl"]}), "isotropic"),
        (422, json!({"individuals": [one], "formats": ["brood", "png"], "size": 4096}), "2048"),
        (422, json!({"individuals": many, "formats": ["brood"]}), "256"),
        (404, json!({"individuals": [unknown], "formats": ["brood"]}), ""),
        (404, json!({"generation": unknown, "formats": ["brood"]}), ""),
        (404, json!({"job": unknown, "formats": ["brood"]}), ""),
        (400, json!({"individuals": [one]}), "formats"),
        (400, json!({"individuals": [one], "formats": ["brood"], "colour": 1}), "colour"),
    ];
    for (status, body, words) in rows {
        let problem = server.post("/v1/exports", &body).await.problem(status);
        assert!(text_of(&problem["detail"]).contains(words), "{body}: {problem}");
    }
    server.get(&format!("/v1/jobs/{unknown}/archive.zip")).await.problem(404);
    let brood = lineage.breed(json!({"parents": [], "count": 200, "seed": 3})).await;
    let body = json!({"generation": brood["id"], "formats": ["rgl-bsdf", "merl", "brood"]});
    // Random programs are anisotropic, so that MERL is left out of most.
    let job = begin(&server, &body).await;
    cancel(&server, &job).await.expect(200);
}
