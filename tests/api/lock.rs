//! Locks: parts of the first parent that its children keep.

use brood_tests::{TestLineage, TestServer, hashes, ids, text_of};
use serde_json::{Value, json};

async fn genome(server: &TestServer, hash: &str) -> Value {
    server.get(&format!("/v1/genomes/{hash}")).await.expect(200).json()
}

#[tokio::test(flavor = "multi_thread")]
async fn children_keep_locked_parts_and_may_change_all_others() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let first = lineage.random(1).await;
    let (parent, mate) = (&ids(&first)[0], &ids(&first)[1]);
    let before = genome(&server, &hashes(&first)[0]).await;
    let instructions: Vec<usize> = (0..100).step_by(2).collect();
    let locks = json!({"instructions": instructions, "constants": [0, 1, 2, 3]});
    for parents in [json!([parent]), json!([parent, mate])] {
        let asked = json!({
            "parents": parents, "count": 5, "mutation": 1, "recombination": 0.7, "seed": 4,
            "locks": locks,
        });
        let born = lineage.breed(asked).await;
        let mut changed = 0;
        for hash in hashes(&born) {
            let child = genome(&server, &hash).await;
            for at in 0..100 {
                let same = child["instructions"][at] == before["instructions"][at];
                assert!(same || at % 2 == 1, "instruction {at}");
                changed += usize::from(!same);
            }
            for name in ["C0", "C1", "C2", "C3"] {
                assert_eq!(child["constants"][name], before["constants"][name], "{name}");
            }
        }
        assert!(changed > 50, "{changed}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn locked_channel_is_unchanged_in_every_picture() {
    let server = TestServer::start();
    let scene = json!({"film": {"exposure": -1}});
    let scene = server.post("/v1/scenes", &scene).await.expect(201).json();
    let body = json!({"name": "first", "thumbnail_px": 32, "scene": scene["id"]});
    let lineage = TestLineage::with(&server, body).await;
    let first = lineage.random(12).await;
    let asked = json!({
        "parents": [ids(&first)[0]], "count": 6, "mutation": 0.7, "seed": 4,
        "locks": {"channels": ["g"]},
    });
    let born = lineage.breed(asked).await;
    let picture =
        async |one: &Value| server.get(&text_of(&one["thumbnail"])).await.expect(200).picture();
    let parent = picture(&born["centre"]).await;
    let mut changed = 0;
    for child in born["individuals"].as_array().unwrap() {
        let child = picture(child).await;
        assert!(parent.pixels().zip(child.pixels()).all(|(a, b)| a.0[1] == b.0[1]));
        changed += u32::from(parent.pixels().zip(child.pixels()).any(|(a, b)| a.0 != b.0));
    }
    assert!(changed >= 5, "red and blue must still change: {changed} of 6");
}

#[tokio::test(flavor = "multi_thread")]
async fn locks_of_missing_parts_are_refused_with_a_pointer() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let parent = &lineage.random_child(1).await;
    let rows = [
        (json!([]), json!({"channels": ["r"]}), 422, "/locks"),
        (json!([parent]), json!({"instructions": [1, 100]}), 422, "/locks/instructions/1"),
        (json!([parent]), json!({"constants": [128]}), 422, "/locks/constants/0"),
        (json!([parent]), json!({"channels": ["x"]}), 400, "/locks/channels/0"),
        (json!([parent]), json!({"registers": [1]}), 400, "/locks/registers"),
    ];
    for (parents, locks, status, pointer) in rows {
        let body = json!({"parents": parents, "locks": locks, "count": 2});
        let problem = server.post(&lineage.path("/generations"), &body).await.problem(status);
        assert_eq!(problem["pointer"], json!(pointer), "{problem}");
    }
    let body = json!({"parents": [], "locks": {}, "count": 2, "seed": 3});
    assert_eq!(lineage.breed(body).await["locks"], Value::Null, "empty locks are stored as none");
    // With everything locked, all children are twins and marked as such.
    let all = json!({
        "instructions": (0..100).collect::<Vec<_>>(), "constants": (0..128).collect::<Vec<_>>(),
    });
    let born = lineage.breed(json!({"parents": [parent], "count": 2, "locks": all})).await;
    assert!(born["individuals"].as_array().unwrap().iter().all(|one| one["twin"] == json!(true)));
}
