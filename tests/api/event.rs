//! Event stream of a lineage.

use std::time::Duration;

use brood_tests::{TestLineage, TestServer, brood, text_of};
use reqwest::{Method, Response};
use serde_json::{Value, json};

/// One event as received.
#[derive(Debug, Clone)]
pub(crate) struct Event {
    pub(crate) id: String,
    pub(crate) name: String,
    pub(crate) data: Value,
}

/// Reads events until `enough` returns true, or nothing arrives for 30 s.
pub(crate) async fn read(response: &mut Response, enough: impl Fn(&[Event]) -> bool) -> Vec<Event> {
    let (mut events, mut text) = (Vec::new(), String::new());
    while !enough(&events) {
        let chunk = tokio::time::timeout(Duration::from_secs(30), response.chunk()).await;
        let chunk = chunk.unwrap_or_else(|_| panic!("no event for 30 s after {events:?}"));
        let chunk = chunk.unwrap().unwrap_or_else(|| panic!("the stream ended after {events:?}"));
        text.push_str(std::str::from_utf8(&chunk).unwrap());
        while let Some(end) = text.find("\n\n") {
            let block: String = text.drain(..end + 2).collect();
            let field = |name: &str| {
                let lines = block.lines().filter_map(|line| line.strip_prefix(name));
                lines.map(str::trim_start).collect::<Vec<_>>().join("\n")
            };
            if !field("event:").is_empty() {
                let data = serde_json::from_str(&field("data:")).unwrap_or(Value::Null);
                events.push(Event { id: field("id:"), name: field("event:"), data });
            }
        }
    }
    events
}

pub(crate) async fn open(server: &TestServer, path: &str, last: Option<&str>) -> Response {
    let mut request = server.request(Method::GET, path);
    if let Some(id) = last {
        request = request.header("last-event-id", id);
    }
    let response = request.send().await.unwrap();
    assert_eq!(response.status(), 200);
    assert_eq!(response.headers()["content-type"], "text/event-stream");
    response
}

#[tokio::test(flavor = "multi_thread")]
async fn stream_has_the_generation_and_each_picture_when_a_brood_is_bred() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let path = lineage.path("/events");
    let mut stream = open(&server, &path, None).await;
    let generation = lineage.random(1).await;
    let pictures = |events: &[Event]| events.iter().filter(|it| it.name == "thumbnail").count();
    // Requesting the pictures renders them; the stream then reports each.
    let children = generation["individuals"].as_array().unwrap().clone();
    for child in &children {
        server.get(&text_of(&child["thumbnail"])).await.expect(200);
    }
    let events = read(&mut stream, |events| pictures(events) >= 4).await;
    let born = events.iter().find(|event| event.name == "generation").unwrap();
    assert_eq!(born.data["id"], generation["id"]);
    for child in &children {
        let told = events.iter().find(|event| event.data["individual"] == child["id"]);
        let told = told.unwrap_or_else(|| panic!("{child} in {events:?}"));
        assert_eq!(told.data["url"], child["thumbnail"]);
    }
    assert!(events.iter().all(|event| !event.id.is_empty()), "{events:?}");
    drop(stream);

    // A listener that reconnects gets the missed events.
    let mut again = open(&server, &path, Some(&born.id)).await;
    let replayed = read(&mut again, |events| pictures(events) >= 4).await;
    assert!(replayed.iter().all(|event| event.id != born.id), "only what came later");
}

#[tokio::test(flavor = "multi_thread")]
async fn stream_has_changes_by_other_clients() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let child = lineage.random(1).await["individuals"][0].clone();
    let mut stream = open(&server, &lineage.path("/events"), None).await;
    let name = json!({"name": "another"});
    let renamed = server.patch(&lineage.path(""), Some("\"1\""), &name).await.expect(200).json();
    let path = format!("/v1/individuals/{}", text_of(&child["id"]));
    let mark = json!({"favourite": true, "note": "warm"});
    let marked = server.patch(&path, Some("\"1\""), &mark).await.expect(200).json();
    let told = |events: &[Event], name: &str| {
        events.iter().find(|event| event.name == name).map(|event| event.data.clone())
    };
    let both = |events: &[Event]| told(events, "lineage").and(told(events, "individual")).is_some();
    let events = read(&mut stream, both).await;
    assert_eq!(told(&events, "lineage"), Some(json!({"version": renamed["version"]})));
    let wanted = json!({
        "id": child["id"], "favourite": true, "note": "warm", "version": marked["version"],
    });
    assert_eq!(told(&events, "individual"), Some(wanted));
}

#[tokio::test(flavor = "multi_thread")]
async fn stream_has_no_events_of_other_lineages() {
    let server = TestServer::start();
    let here = TestLineage::new(&server).await;
    let there = TestLineage::with(&server, json!({"name": "other", "thumbnail_px": 32})).await;
    let mut stream = open(&server, &here.path("/events"), None).await;
    there.random(1).await;
    let mine = here.random(2).await;
    let events = read(&mut stream, |events| !events.is_empty()).await;
    assert_eq!(events[0].name, "generation");
    assert_eq!(events[0].data["id"], mine["id"]);
}

#[tokio::test(flavor = "multi_thread")]
async fn stream_is_refused_but_other_requests_are_answered_when_too_many_streams_are_open() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let path = lineage.path("/events");
    let system = server.get("/v1/system").await.expect(200).json();
    let most = system["limits"]["event_streams"].as_u64().unwrap();
    let mut streams = Vec::new();
    for _ in 0..most {
        streams.push(open(&server, &path, None).await);
    }
    let refused = server.get(&path).await;
    assert_eq!(refused.status, 503, "{}", refused.text());
    assert_eq!(refused.header("retry-after"), "1");
    server.get("/healthz").await.expect(200);
    streams.pop();
    // The server notices a closed stream with a short delay.
    for _ in 0..50 {
        let again = server.request(Method::GET, &path).send().await.unwrap();
        if again.status() == 200 {
            return;
        }
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
    panic!("the permit of a closed stream was not released");
}

#[tokio::test(flavor = "multi_thread")]
async fn stream_ends_when_its_token_is_revoked() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let data = server.data().to_string_lossy().into_owned();
    let token = |name: &str| {
        let arguments = ["token", "add", name, "--scope", "read", "--data", data.as_str()];
        let printed = brood(arguments).success().stdout;
        let words = printed.split_whitespace().map(str::to_owned);
        words.max_by_key(String::len).expect("the token is printed")
    };
    let listen = async |token: String| {
        let request = server.request(Method::GET, &lineage.path("/events"));
        let request = request.header("authorization", format!("Bearer {token}"));
        // Tokens added by another process are known after a short delay.
        for _ in 0..50 {
            let response = request.try_clone().unwrap().send().await.unwrap();
            if response.status() == 200 {
                return response;
            }
            tokio::time::sleep(Duration::from_millis(100)).await;
        }
        panic!("the token was not accepted");
    };
    let mut kept = listen(token("kept")).await;
    let mut revoked = listen(token("revoked")).await;
    brood(["token", "revoke", "revoked", "--data", data.as_str()]).success();
    let end = async { while revoked.chunk().await.ok().flatten().is_some() {} };
    let ended = tokio::time::timeout(Duration::from_secs(20), end).await;
    assert!(ended.is_ok(), "it still goes on");
    // The other stream has only its opening comment so far.
    let first = kept.chunk().await.unwrap().expect("the stream of the other token stays open");
    assert!(first.starts_with(b":"), "{first:?}");
    let more = tokio::time::timeout(Duration::from_millis(100), kept.chunk()).await;
    assert!(more.is_err(), "{more:?}");
}
