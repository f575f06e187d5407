//! Fair work: what one client asks for does not keep others waiting, and ends when it has gone.

use std::time::{Duration, Instant};

use brood_tests::{TestLineage, TestServer, ids, text_of};
use reqwest::Method;
use serde_json::{Value, json};
use tokio::time::{sleep, timeout};

/// Number of render jobs in a queue and state.
pub async fn jobs(server: &TestServer, queue: &str, state: &str) -> u64 {
    let text = server.get("/metrics").await.expect(200).text();
    let line = format!("brood_jobs{{queue=\"{queue}\",state=\"{state}\"}} ");
    let value = text.lines().find_map(|text| text.strip_prefix(&line)).unwrap();
    value.parse().unwrap()
}

/// Path of a picture of 16 million rays, the most that a picture may have.
fn largest(individual: &str) -> String {
    format!("/v1/individuals/{individual}/render.png?size=2048&samples=4")
}

/// Asks for a picture and leaves after this time.
async fn leave(server: &TestServer, path: &str, after: Duration) -> bool {
    let request = server.send(server.request(Method::GET, path));
    timeout(after, request).await.is_err()
}

#[tokio::test(flavor = "multi_thread")]
async fn pictures_are_not_rendered_when_their_clients_have_gone() {
    let server = TestServer::start();
    let id = TestLineage::new(&server).await.random_child(4).await;
    let mut asked = 0;
    for size in 1400..1424 {
        let path = format!("/v1/individuals/{id}/render.png?size={size}");
        asked += u64::from(leave(&server, &path, Duration::from_millis(20)).await);
    }
    while jobs(&server, "interactive", "queued").await > 0 {
        sleep(Duration::from_millis(50)).await;
    }
    let rendered = server.metric("brood_pictures_rendered_total").await;
    println!("{asked} clients left, {rendered} pictures were rendered");
    // The brood's own pictures, and those that a worker had begun.
    assert!(asked > 20 && rendered < 21 + asked / 2, "{asked} {rendered}");
}

#[tokio::test(flavor = "multi_thread")]
async fn rendering_stops_when_its_client_has_gone() {
    let server = TestServer::start();
    let id = TestLineage::new(&server).await.random_child(4).await;
    let path = largest(&id);
    // The brood's own pictures.
    for state in ["queued", "leased"] {
        while jobs(&server, "interactive", state).await > 0 {
            sleep(Duration::from_millis(20)).await;
        }
    }
    let before = server.metric("brood_pictures_rendered_total").await;
    assert!(leave(&server, &path, Duration::from_millis(300)).await, "it takes seconds");
    let left = Instant::now();
    while server.metric("brood_jobs_abandoned_total").await == 0 {
        if server.metric("brood_pictures_rendered_total").await > before {
            println!("skipped: this machine renders the picture before its client is missed");
            return;
        }
        assert!(left.elapsed() < Duration::from_secs(20), "the worker goes on rendering");
        sleep(Duration::from_millis(20)).await;
    }
    println!("the job ended {:?} after its client left", left.elapsed());
    assert_eq!(jobs(&server, "batch", "leased").await, 0);
    // The worker is free for others, and the picture can be asked for again.
    let small = format!("/v1/individuals/{id}/render.png?size=64&samples=4");
    server.get(&small).await.expect(200).picture();
    let again = loop {
        let answer = server.get(&path).await;
        if answer.status == 200 {
            break answer;
        }
    };
    assert_eq!(again.picture().dimensions(), (2048, 2048));
}

#[tokio::test(flavor = "multi_thread")]
async fn breeding_goes_on_beside_large_pictures_and_large_broods() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let mut generation = lineage.random(5).await;
    let large = TestLineage::with(&server, json!({"name": "large", "start": "wild"})).await;
    let parents = ids(&generation);
    let load = async {
        let pictures = parents.into_iter().take(3).map(|id| {
            let server = &server;
            async move {
                // 503 after 20 s: beside other tests, large pictures take longer.
                while server.get(&largest(&id)).await.status != 200 {}
            }
        });
        let broods = [1, 2].map(|seed| {
            let body = json!({"count": 256, "seed": seed, "energy_limit": true});
            large.breed(body)
        });
        let pictures = futures::future::join_all(pictures);
        futures::join!(pictures, futures::future::join_all(broods));
    };
    let breeding = async {
        let mut longest = Duration::ZERO;
        for seed in 0..12 {
            let start = Instant::now();
            let parent = &ids(&generation)[seed % 4];
            generation =
                lineage.breed(json!({"parents": [parent], "seed": seed, "count": 4})).await;
            let shown = |child: &Value| text_of(&child["thumbnail"]);
            for url in generation["individuals"].as_array().unwrap().iter().map(shown) {
                server.get(&url).await.expect(200).picture();
            }
            longest = longest.max(start.elapsed());
        }
        longest
    };
    let started = Instant::now();
    let busy = async {
        load.await;
        started.elapsed()
    };
    let bred = async {
        let longest = breeding.await;
        (longest, started.elapsed())
    };
    let (busy, (longest, bred)) = futures::join!(busy, bred);
    println!("the load took {busy:?}, twelve broods {bred:?}, the longest of them {longest:?}");
    assert!(bred < busy, "twelve broods wait for the load: {bred:?} of {busy:?}");
}
