//! Jobs: work done, and work avoided.

use brood_tests::{TestLineage, TestServer, text_of};
use serde_json::{Value, json};

/// Breeds; returns the job named by the answer, and the answer.
async fn bred(lineage: &TestLineage<'_>, body: Value) -> (Option<String>, Value) {
    let answer = lineage.server.post(&lineage.path("/generations"), &body).await.expect(201);
    let link = answer.header("link").to_owned();
    let path = link.strip_prefix('<').and_then(|link| link.strip_suffix(">; rel=\"status\""));
    (path.map(str::to_owned), answer.json())
}

async fn see_all(server: &TestServer, generation: &Value) {
    for child in generation["individuals"].as_array().unwrap() {
        server.get(&text_of(&child["thumbnail"])).await.expect(200);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn job_reports_its_work_and_the_work_avoided_when_it_is_done() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let body = json!({"parents": [], "count": 4, "seed": 1});
    let (path, generation) = bred(&lineage, body.clone()).await;
    let path = path.expect("a job renders the missing pictures");
    see_all(&server, &generation).await;
    let job = server.get(&path).await.expect(200).json();
    assert_eq!((&job["state"], &job["kind"]), (&json!("succeeded"), &json!("render")), "{job}");
    let count = |name: &str| job["work"][name].as_u64().unwrap_or_else(|| panic!("{name}: {job}"));
    assert!(count("pictures") == 4 && count("rays") >= 4 * 32 * 32, "{job}");
    assert!(count("samples_lit") > 0, "{job}");
    assert!(count("inputs_read") < count("inputs_known"), "{job}");
    let (executed, written) = (count("operations_executed"), count("operations_written"));
    assert!(executed > 0 && executed < written, "{job}");
    assert!(job["times"]["leased_us"].as_u64().unwrap() >= count("busy_us"), "{job}");

    assert_eq!(server.metric("brood_operations_written_total").await, written);
    assert_eq!(server.metric("brood_rays_total").await, count("rays"));

    let (again, _) = bred(&lineage, body).await;
    assert_eq!(again, None, "the pictures of the same children are cached");
    assert_eq!(server.metric("brood_pictures_skipped_total").await, 4);
    assert_eq!(server.metric("brood_rays_total").await, count("rays"));
}

#[tokio::test(flavor = "multi_thread")]
async fn job_is_404_when_its_id_is_unknown_or_malformed() {
    let server = TestServer::start();
    let path = format!("/v1/jobs/{}", "01890000-0000-7000-8000-000000000000");
    server.get(&path).await.problem(404);
    server.get("/v1/jobs/x").await.problem(404);
}

#[tokio::test(flavor = "multi_thread")]
async fn answer_has_the_durations_of_its_stages_when_a_brood_is_bred() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let body = json!({"parents": [], "count": 2, "seed": 1});
    let answer = server.post(&lineage.path("/generations"), &body).await.expect(201);
    let told = answer.header("server-timing").to_owned();
    for stage in ["read", "make", "write", "commit"] {
        assert!(told.contains(&format!("{stage};dur=")), "{told}");
    }
}
