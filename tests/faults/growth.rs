//! Growth of the database: bytes of a birth, indexes and picture keys included.

use std::fs;

use brood_tests::{TestLineage, TestServer, ids};
use serde_json::json;

/// Most bytes of a birth in broods of 20.
const BIRTH_BYTES: u64 = 1500;
const BROODS: u64 = 100;

#[tokio::test(flavor = "multi_thread")]
async fn birth_takes_little_of_the_database() {
    let mut server = TestServer::start();
    let path = {
        let body = json!({"name": "growth", "start": "wild", "thumbnail_px": 16});
        TestLineage::with(&server, body).await.path("/generations")
    };
    let first = json!({"count": 20, "seed": 1});
    let mut generation = server.post(&path, &first).await.expect(201).json();
    for seed in 2..=BROODS {
        let children = ids(&generation);
        // Every third brood has two parents.
        let count = if seed % 3 == 0 { 2 } else { 1 };
        let body = json!({"parents": children[3..3 + count], "count": 20, "seed": seed});
        generation = server.post(&path, &body).await.expect(201).json();
    }
    let births = 20 * BROODS;
    // The log is written back.
    assert_eq!(server.terminate(), 0);
    let bytes = fs::metadata(server.data().join("brood.db")).unwrap().len();
    let each = bytes / births;
    println!("fault: growth: {each} bytes a birth, at most {BIRTH_BYTES}, after {births} births");
    assert!(each <= BIRTH_BYTES, "{each}");
}
