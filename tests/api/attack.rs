//! Malformed and hostile requests, one per table row: each gets its status and error, changes
//! nothing, and reveals nothing about the server's files.

use brood_tests::{Answer, TestLineage, TestServer, brood, ids, raw_request};
use reqwest::Method;
use serde_json::{Value, json};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

/// Well-formed id that belongs to nothing.
const UNKNOWN_ID: &str = "01900000-0000-7000-8000-000000000000";

/// Asserts that an answer has no internal details.
fn reveals_nothing(answer: &Answer, server: &TestServer) {
    let text = answer.text();
    let data = server.data().to_string_lossy().into_owned();
    for word in [data.as_str(), "SELECT", "sqlite", "panicked", "src/", "backtrace"] {
        assert!(!text.contains(word), "{} reveals {word}: {text}", answer.request);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn body_is_refused_with_a_pointer_when_it_is_not_valid_json() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let path = lineage.path("/generations");
    let deep = format!("{{\"parents\": {}1{}}}", "[".repeat(100), "]".repeat(100));
    // Body, and a part of the answer's pointer if it must have one.
    let rows: [(&str, Option<&str>); 13] = [
        ("{\"parents\": [], \"colour\": 1}", Some("colour")),
        ("{\"parents\": [], \"constraints\": {\"metallic\": true}}", Some("/constraints")),
        ("{\"parents\": [], \"count\": 4, \"count\": 5}", Some("count")),
        (&deep, None),
        ("{\"parents\": [], \"mutation\": NaN}", None),
        ("{\"parents\": [], \"mutation\": 1e999}", None),
        ("{\"parents\": [], \"count\": -1}", Some("/count")),
        ("{\"parents\": [], \"count\": 4.5}", Some("/count")),
        ("{\"parents\": [], \"seed\": 18446744073709551616}", Some("/seed")),
        ("{\"parents\": [], \"seed\": \"seven\"}", Some("/seed")),
        ("{\"parents\": [], \"curation\": \"best\"}", Some("/curation")),
        ("{\"parents\": [\"someone\"]}", Some("/parents/0")),
        ("{\"parents\": [", None),
    ];
    for (body, pointer) in rows {
        let answer = server.post_bytes(&path, "application/json", body).await;
        let problem = answer.problem(400);
        if let Some(part) = pointer {
            let found = problem["pointer"].as_str().unwrap_or_default();
            assert!(found.contains(part), "{body}: {problem}");
        }
        reveals_nothing(&answer, &server);
    }
    let generations = server.get(&path).await.expect(200).json();
    assert_eq!(generations["items"], json!([]), "no generation is stored");
}

#[tokio::test(flavor = "multi_thread")]
async fn breeding_is_refused_when_a_value_is_invalid() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let path = lineage.path("/generations");
    let first = ids(&lineage.random(1).await);
    let extended = json!({
        "name": "other", "thumbnail_px": 32, "dialect": {"opcodes": "extended", "registers": 10},
    });
    let other = TestLineage::with(&server, extended).await;
    let foreign = ids(&other.random(1).await);
    let rows = [
        (422, json!({"parents": [], "count": 0})),
        (422, json!({"parents": [], "count": 257})),
        (422, json!({"parents": [], "count": 1_000_000_000})),
        (422, json!({"parents": [first[0]], "mutation": 0})),
        (422, json!({"parents": [first[0]], "mutation": 0, "curation": "off"})),
        (422, json!({"parents": first[..2], "mutation": 0, "recombination": 0})),
        (422, json!({"parents": first[..2], "mutation": 0, "recombination": 1})),
        (422, json!({"parents": [first[0], first[0]], "mutation": 0})),
        (422, json!({"parents": [first[0]], "mutation": 1.5})),
        (422, json!({"parents": [first[0], first[1]], "recombination": -0.1})),
        (400, json!({"parents": [], "curation": "best"})),
        (422, json!({"parents": [], "locks": {"instructions": [0]}})),
        (422, json!({"parents": [first[0], first[1], first[2]]})),
        (422, json!({"parents": [foreign[0]]})),
        (404, json!({"parents": [UNKNOWN_ID]})),
        (404, json!({"parents": ["0".repeat(64)]})),
    ];
    for (status, body) in rows {
        let answer = server.post(&path, &body).await;
        assert_eq!(answer.status, status, "{body}: {}", answer.text());
        answer.problem(status);
        reveals_nothing(&answer, &server);
    }
    let generations = server.get(&path).await.expect(200).json();
    assert_eq!(
        generations["items"].as_array().unwrap().len(),
        1,
        "no further generation is stored"
    );
}

#[tokio::test(flavor = "multi_thread")]
async fn body_is_refused_when_its_type_is_wrong_or_it_is_too_large() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let breed = lineage.path("/generations");
    let json = "{\"parents\": []}";
    for kind in
        ["text/plain", "application/x-www-form-urlencoded", "multipart/form-data; boundary=b"]
    {
        for path in ["/v1/lineages", &breed, "/v1/scenes", "/v1/meshes", "/v1/genomes"] {
            server.post_bytes(path, kind, json).await.problem(415);
        }
    }
    let wide = format!("{{\"name\": \"{}\"}}", "x".repeat(300 * 1024));
    server.post_bytes("/v1/lineages", "application/json", wide.clone()).await.problem(413);
    // Without a declared length.
    let chunks: Vec<Vec<u8>> = wide.into_bytes().chunks(8192).map(<[u8]>::to_vec).collect();
    let chunks = futures::stream::iter(chunks.into_iter().map(Ok::<_, std::io::Error>));
    let sent = reqwest::Body::wrap_stream(chunks);
    let request = server.request(Method::POST, "/v1/lineages");
    let request = request.header("content-type", "application/json").body(sent);
    server.send(request).await.problem(413);
    let lineages = server.get("/v1/lineages").await.expect(200).json();
    assert_eq!(lineages["items"].as_array().unwrap().len(), 1, "no lineage is stored");
}

#[tokio::test(flavor = "multi_thread")]
async fn answer_is_404_405_or_400_when_route_id_method_or_query_is_wrong() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let child = ids(&lineage.random(1).await)[0].clone();
    let rows = [
        (404, Method::GET, "/v1/nothing".to_owned()),
        (404, Method::GET, format!("/v1/lineages/{UNKNOWN_ID}")),
        (404, Method::GET, format!("/v1/lineages/{UNKNOWN_ID}/generations")),
        (404, Method::GET, format!("/v1/lineages/{UNKNOWN_ID}/events")),
        (404, Method::GET, format!("/v1/generations/{UNKNOWN_ID}")),
        (404, Method::GET, format!("/v1/individuals/{UNKNOWN_ID}")),
        (404, Method::GET, format!("/v1/individuals/{UNKNOWN_ID}/render.png")),
        (404, Method::GET, format!("/v1/genomes/{}", "0".repeat(64))),
        (404, Method::GET, format!("/v1/thumbnails/{}.png", "0".repeat(64))),
        (404, Method::GET, format!("/v1/meshes/{UNKNOWN_ID}")),
        (404, Method::GET, format!("/v1/scenes/{UNKNOWN_ID}")),
        (404, Method::GET, "/v1/environments/a%00b/mean".to_owned()),
        (404, Method::GET, "/v1/meshes/a%00b/geometry".to_owned()),
        (405, Method::PUT, "/v1/lineages".to_owned()),
        (405, Method::DELETE, "/v1/system".to_owned()),
        (400, Method::GET, "/v1/lineages?limit=0".to_owned()),
        (400, Method::GET, "/v1/lineages?limit=201".to_owned()),
        (400, Method::GET, "/v1/lineages?limit=many".to_owned()),
        (400, Method::GET, "/v1/lineages?cursor=nonsense".to_owned()),
        (400, Method::GET, "/v1/lineages?cursor=a%00b".to_owned()),
        (400, Method::GET, "/v1/lineages?colour=red".to_owned()),
        (400, Method::GET, format!("/v1/individuals/{child}/render.png?size=15")),
        (400, Method::GET, format!("/v1/individuals/{child}/render.png?size=2049")),
        (400, Method::GET, format!("/v1/individuals/{child}/render.png?size=big")),
        (400, Method::GET, format!("/v1/individuals/{child}/render.png?samples=0")),
        (400, Method::GET, format!("/v1/individuals/{child}/render.png?light_deg=NaN")),
        (400, Method::GET, format!("/v1/individuals/{child}/render.png?backend=quantum")),
        (400, Method::GET, format!("/v1/individuals/{child}/render.png?colour=red")),
        (400, Method::GET, format!("/v1/individuals/{child}?colour=red")),
        (400, Method::GET, "/v1/system?colour=red".to_owned()),
        (400, Method::POST, "/v1/lineages?limit=1".to_owned()),
    ];
    for (status, method, path) in rows {
        let answer = server.send(server.request(method, &path)).await;
        assert_eq!(answer.status, status, "{path}: {}", answer.text());
        answer.problem(status);
        reveals_nothing(&answer, &server);
    }
    server.send(server.request(Method::HEAD, "/v1/lineages?limit=1")).await.expect(200);
    for probe in ["/healthz?from=probe", "/v1/system?", "/metrics?format=text"] {
        server.get(probe).await.expect(200);
    }
    let odd = server.get("/v1/lineages/not-an-id").await;
    assert!(matches!(odd.status, 400 | 404), "{}", odd.text());
}

#[tokio::test(flavor = "multi_thread")]
async fn problem_shortens_quoted_input_when_it_is_long() {
    let server = TestServer::start();
    let name = "z".repeat(5000);
    let body = format!("{{\"{name}\": 1, \"name\": \"a\"}}");
    let problem: Value =
        server.post_bytes("/v1/lineages", "application/json", body).await.problem(400);
    assert!(!problem.to_string().contains(&"z".repeat(65)), "{problem}");
}

#[tokio::test(flavor = "multi_thread")]
async fn idle_connections_give_way_to_requests_and_event_streams_stay() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let mut events = TcpStream::connect(server.address()).await.unwrap();
    let head = format!("GET {} HTTP/1.1\r\nHost: localhost\r\n\r\n", lineage.path("/events"));
    events.write_all(head.as_bytes()).await.unwrap();
    let mut buffer = [0; 4096];
    assert!(events.read(&mut buffer).await.unwrap() > 0);
    let mut idle = Vec::new();
    for _ in 0..700 {
        idle.push(TcpStream::connect(server.address()).await.unwrap());
    }
    // Before idle connections gave way, this took 30 s.
    let asked = raw_request(
        server.address(),
        b"GET /healthz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n",
    );
    let asked = tokio::time::timeout(std::time::Duration::from_secs(10), asked);
    assert_eq!(asked.await.unwrap().0, 200);
    lineage.random(1).await;
    let mut seen = String::new();
    while !seen.contains("event: generation") {
        let count = events.read(&mut buffer).await.unwrap();
        assert!(count > 0, "{seen}");
        seen.push_str(&String::from_utf8_lossy(&buffer[..count]));
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn connections_of_workers_do_not_take_the_places_of_others() {
    let mut server = TestServer::start();
    assert_eq!(server.terminate(), 0);
    let data = server.data().to_string_lossy().into_owned();
    let arguments = ["token", "add", "far", "--scope", "work", "--data", data.as_str()];
    let printed = brood(arguments).success().stdout;
    let token = printed.split_whitespace().max_by_key(|word| word.len()).unwrap().to_owned();
    server.restart();
    let head = format!(
        "GET /v1/leases/meshes/{} HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer {token}\r\n\r\n",
        "00".repeat(32)
    );
    let ask = async |stream: &mut TcpStream| {
        let mut buffer = [0; 4096];
        stream.write_all(head.as_bytes()).await.unwrap();
        let count = stream.read(&mut buffer).await.unwrap();
        String::from_utf8_lossy(&buffer[..count]).into_owned()
    };
    let mut workers = Vec::new();
    // More than the places of others.
    for _ in 0..700 {
        let mut stream = TcpStream::connect(server.address()).await.unwrap();
        assert!(ask(&mut stream).await.starts_with("HTTP/1.1 404"));
        workers.push(stream);
    }
    let mut people = Vec::new();
    for _ in 0..400 {
        people.push(TcpStream::connect(server.address()).await.unwrap());
    }
    let (status, _) = raw_request(
        server.address(),
        b"GET /healthz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n",
    )
    .await;
    assert_eq!(status, 200);
    for stream in &mut workers {
        assert!(ask(stream).await.starts_with("HTTP/1.1 404"), "the connection is still open");
    }
}
