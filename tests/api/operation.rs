//! Operation: health, metrics, documentation, the page, and a clean shutdown.

use brood_tests::{TestLineage, TestServer, binary, text_of};
use serde_json::Value;

#[tokio::test(flavor = "multi_thread")]
async fn server_reports_health_metrics_and_its_description() {
    let server = TestServer::start();
    server.get("/healthz").await.expect(200);
    server.get("/readyz").await.expect(200);
    let lineage = TestLineage::new(&server).await;
    let generation = lineage.random(1).await;
    server.get(&text_of(&generation["individuals"][0]["thumbnail"])).await.expect(200);
    let metrics = server.get("/metrics").await.expect(200).text();
    for line in [
        "brood_searches{state=\"running\"} 0",
        "brood_exports{state=\"queued\"} 0",
        "brood_oldest_render_wait_seconds{queue=\"batch\"} 0",
        "brood_refused_writes_total 0",
    ] {
        assert!(metrics.lines().any(|each| each == line), "{metrics}");
    }
    let system = server.get("/v1/system").await.expect(200).json();
    assert_eq!(system["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(system["backend"]["name"], "cpu", "{system}");
    assert!(system["backend"]["reason"].as_str().is_some_and(|reason| !reason.is_empty()));
    assert!(system["limits"].is_object(), "{system}");
}

#[cfg(unix)]
#[tokio::test(flavor = "multi_thread")]
async fn new_connections_are_answered_while_the_server_stops() {
    use tokio::io::AsyncWriteExt;

    let mut server = TestServer::start();
    server.get("/readyz").await.expect(200);
    // An upload that has not arrived yet keeps the server up.
    let mut upload = tokio::net::TcpStream::connect(server.address()).await.unwrap();
    let host = server.address();
    let head = format!(
        "POST /v1/images HTTP/1.1\r\nhost: {host}\r\ncontent-type: image/png\r\n\
         content-length: 900000\r\n\r\n"
    );
    upload.write_all(head.as_bytes()).await.unwrap();
    upload.write_all(&[7; 1000]).await.unwrap();
    tokio::time::sleep(std::time::Duration::from_millis(100)).await;
    let signal = format!("kill -TERM {}", server.process());
    assert!(std::process::Command::new("sh").args(["-c", &signal]).status().unwrap().success());
    tokio::time::sleep(std::time::Duration::from_millis(200)).await;
    for path in ["/readyz", "/v1/lineages", "/"] {
        let request = format!("GET {path} HTTP/1.1\r\nhost: {host}\r\n\r\n");
        let (status, text) = brood_tests::raw_request(host, request.as_bytes()).await;
        assert_eq!(status, 503, "{path}: {text}");
        assert!(text.contains("retry after the restart"), "{text}");
    }
    drop(upload);
    assert_eq!(server.wait(), 0);
}

#[tokio::test(flavor = "multi_thread")]
async fn served_openapi_equals_the_committed_document() {
    let server = TestServer::start();
    let served = server.get("/openapi.json").await.expect(200).json();
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../openapi.json");
    let text = std::fs::read_to_string(file).expect("openapi.json is committed at the root");
    let committed: Value = serde_json::from_str(&text).unwrap();
    assert!(served == committed, "openapi.json is out of date");
    assert!(served["openapi"].as_str().unwrap().starts_with("3.1"));
    let paths = served["paths"].as_object().unwrap();
    for path in ["/v1/lineages", "/v1/lineages/{id}/generations", "/v1/thumbnails/{key}.png"] {
        let named = |known: &String| known.replace("{file}", "{key}.png") == path;
        assert!(paths.keys().any(named), "{path} among {:?}", paths.keys());
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn page_and_documentation_are_served_from_the_binary() {
    let server = TestServer::start();
    let page = server.get("/").await.expect(200);
    assert!(page.header("content-type").starts_with("text/html"));
    let policy = page.header("content-security-policy");
    assert!(policy.contains("default-src 'self'") && !policy.contains("unsafe-eval"), "{policy}");
    assert_eq!(page.header("x-content-type-options"), "nosniff");
    let script = server.get("/web/main.js").await.expect(200);
    assert!(script.header("content-type").contains("javascript"));
    let style = server.get("/web/style/page.css").await.expect(200);
    assert!(style.header("content-type").starts_with("text/css"));
    for path in ["/web/../Cargo.toml", "/web/%2e%2e/Cargo.toml", "/web/nothing.js"] {
        assert_eq!(server.get(path).await.status, 404, "{path}");
    }
    let docs = server.get("/docs/").await;
    assert!(matches!(docs.status, 200 | 303 | 307 | 308), "{}", docs.status);
    assert!(!docs.text().contains("https://"), "the documentation must not load from the network");
}

#[tokio::test(flavor = "multi_thread")]
async fn server_exits_with_zero_and_keeps_its_data_when_terminated() {
    let mut server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let generation = lineage.random(1).await;
    let path = format!("/v1/generations/{}", text_of(&generation["id"]));
    assert_eq!(server.terminate(), 0, "{}", server.log());
    server.restart();
    assert_eq!(server.get(&path).await.expect(200).json(), generation);
}

#[tokio::test(flavor = "multi_thread")]
async fn every_answer_has_a_request_id() {
    let server = TestServer::start();
    let first = server.get("/v1/system").await.header("x-request-id");
    let second = server.get("/v1/nothing").await.header("x-request-id");
    assert!(!first.is_empty() && !second.is_empty() && first != second);
}

/// The unit file's command and variables start a server, without root and systemd.
#[test]
fn unit_file_starts_the_server() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../packaging/brood.service");
    let unit = std::fs::read_to_string(file).expect("the unit file is there");
    let value = |name: &str| {
        let line = unit.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix('='));
        line.unwrap_or_else(|| panic!("the unit file has {name}"))
    };
    let (program, arguments) = value("ExecStart").split_once(' ').expect("the command has a word");
    assert_eq!(program, "/usr/local/bin/brood");
    let (variable, folder) = value("Environment").split_once('=').expect("a variable is set");
    assert_eq!(folder, format!("/var/lib/{}", value("StateDirectory")));
    let data = tempfile::tempdir().unwrap();
    let mut server = std::process::Command::new(binary())
        .args(arguments.split(' '))
        .env(variable, data.path())
        .env("BROOD_LISTEN", "127.0.0.1:0")
        .env("BROOD_WORKERS", "0")
        .env("BROOD_ALLOW_HOSTS", "one.example,two.example")
        .stdout(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let mut line = String::new();
    let output = server.stdout.take().unwrap();
    std::io::BufRead::read_line(&mut std::io::BufReader::new(output), &mut line).unwrap();
    server.kill().unwrap();
    server.wait().unwrap();
    assert!(line.starts_with("brood is listening on http://127.0.0.1:"), "{line}");
    assert!(data.path().join("brood.db").is_file());
}
