//! Jumps of the time of day: leases, jobs and pictures do not depend on it.

use brood_tests::{TestLineage, TestServer, text_of};
use serde_json::json;
use tempfile::TempDir;

use crate::layer::Layer;
use crate::rounds;

const DAY: i64 = 86_400;
/// They take turns, and wait for pictures, so more would take long.
const SEARCHES: u64 = 4;

#[tokio::test(flavor = "multi_thread")]
async fn work_goes_on_when_the_clock_jumps() {
    let (layer, data) = (Layer::build(), TempDir::new().unwrap());
    let options = layer.options(data.path());
    let mut server = TestServer::start_on(options, data);
    let target = server.glossy_target().await;
    let search = json!({
        "kind": "fit", "target": target, "strategy": "lobes", "generations": 12, "threads": 1,
    });
    let mut jobs = Vec::new();
    let jumps = [3600, -3600, DAY, -DAY, 400 * DAY, -400 * DAY];
    let count = (rounds() as usize).div_ceil(jumps.len()) * jumps.len();
    let (mut births, mut pictures) = (0, 0);
    {
        let lineage = TestLineage::with(&server, json!({"name": "late", "thumbnail_px": 64})).await;
        for (seed, jump) in (0_u64..).zip(jumps.into_iter().cycle().take(count)) {
            if seed < SEARCHES {
                let job = server.post("/v1/jobs", &search).await.expect(202).json();
                jobs.push(text_of(&job["id"]));
            }
            let born = lineage.breed(json!({"parents": [], "count": 20, "seed": seed})).await;
            births += 1;
            let children = born["individuals"].as_array().unwrap().iter();
            let children = children.map(|child| async {
                server.get(&text_of(&child["thumbnail"])).await.expect(200).picture().dimensions()
            });
            let children = futures::future::join_all(children);
            let jump = async { layer.move_clock(jump) };
            let (seen, ()) = futures::future::join(children, jump).await;
            assert_eq!(seen, [(64, 64); 20]);
            pictures += seen.len();
        }
        let listed = crate::all_generations(&server, &lineage.path("/generations")).await;
        assert_eq!(listed.len(), births);
    }
    for id in &jobs {
        let ends = |job: &serde_json::Value| {
            !["queued", "running"].iter().any(|state| job["state"] == *state)
        };
        let job = server.job_once(id, ends).await;
        assert_eq!(job["state"], "succeeded", "{job}");
    }
    assert!(!server.log().contains("no longer reports"), "{}", server.log());
    assert_eq!(server.terminate(), 0);
    println!(
        "fault: clock: {count} jumps by up to 400 days, {births} generations, {pictures} pictures, \
         {} searches, none late",
        jobs.len()
    );
}
