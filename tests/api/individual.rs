//! Individuals: favourites, notes, ancestry and descendants.

use brood_tests::{TestLineage, TestServer, ids, text_of};
use serde_json::{Value, json};

fn listed(page: &Value) -> Vec<String> {
    let items = page["items"].as_array().unwrap();
    items.iter().map(|individual| text_of(&individual["id"])).collect()
}

#[tokio::test(flavor = "multi_thread")]
async fn individual_is_listed_among_favourites_when_marked() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let children = ids(&lineage.random(1).await);
    let path = format!("/v1/individuals/{}", children[2]);
    let before = server.get(&path).await.expect(200);
    assert_eq!(before.json()["favourite"], false);
    let change = json!({"favourite": true, "note": "brass <b>bold</b>"});
    server.patch(&path, None, &change).await.problem(428);
    let tag = before.header("etag");
    let after = server.patch(&path, Some(&tag), &change).await.expect(200);
    assert_eq!(after.json()["favourite"], true);
    assert_eq!(after.json()["note"], "brass <b>bold</b>");
    server.patch(&path, Some(&tag), &json!({"favourite": false})).await.problem(412);
    let favourites = server.get("/v1/individuals?favourite=true").await.expect(200).json();
    assert_eq!(listed(&favourites), [children[2].clone()]);
}

#[tokio::test(flavor = "multi_thread")]
async fn ancestry_and_descendants_are_consistent() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let first = ids(&lineage.random(1).await);
    let body = json!({"parents": [first[0]], "count": 2, "seed": 2});
    let second = ids(&lineage.breed(body).await);
    let body = json!({"parents": [second[1], first[3]], "count": 2, "seed": 3});
    let third = ids(&lineage.breed(body).await);

    let path = format!("/v1/individuals/{}/ancestry", third[0]);
    let ancestors = listed(&server.get(&path).await.expect(200).json());
    for ancestor in [&first[0], &first[3], &second[1]] {
        assert!(ancestors.contains(ancestor), "{ancestor} in {ancestors:?}");
    }
    assert!(!ancestors.contains(&first[1]) && !ancestors.contains(&second[0]));

    let path = format!("/v1/individuals/{}/descendants", first[0]);
    let descendants = listed(&server.get(&path).await.expect(200).json());
    for descendant in second.iter().chain(&third) {
        assert!(descendants.contains(descendant), "{descendant} in {descendants:?}");
    }
    assert!(!descendants.contains(&first[1]));
}
