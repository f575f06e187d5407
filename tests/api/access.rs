//! Access control: hosts, origins, tokens and addresses.

use brood_tests::{ServerOptions, TestServer, brood, ids, raw_request, text_of};
use reqwest::Method;
use serde_json::json;

#[tokio::test(flavor = "multi_thread")]
async fn request_is_refused_when_its_host_is_foreign_missing_or_repeated() {
    let server = TestServer::start();
    let address = server.address().to_owned();
    let port = address.rsplit(':').next().unwrap();
    let rows = [
        (421, "Host: evil.example\r\n".to_owned()),
        (421, format!("Host: evil.example:{port}\r\n")),
        (421, format!("Host: 127.0.0.1.evil.example:{port}\r\n")),
        (400, String::new()),
        (400, format!("Host: {address}\r\nHost: {address}\r\n")),
        (200, format!("Host: {address}\r\n")),
        (200, format!("Host: localhost:{port}\r\n")),
        (200, "Host: localhost\r\n".to_owned()),
        (200, format!("Host: [::1]:{port}\r\n")),
    ];
    for (status, host) in rows {
        let request = format!("GET /v1/system HTTP/1.1\r\n{host}Connection: close\r\n\r\n");
        let (found, text) = raw_request(&address, request.as_bytes()).await;
        assert_eq!(found, status, "{host:?}: {text}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn host_is_accepted_when_allowed() {
    let arguments = vec!["--allow-host".to_owned(), "materials.example".to_owned()];
    let server = TestServer::start_with(ServerOptions { arguments, ..ServerOptions::default() });
    let request = "GET /v1/system HTTP/1.1\r\nHost: materials.example\r\nConnection: close\r\n\r\n";
    let (status, text) = raw_request(server.address(), request.as_bytes()).await;
    assert_eq!(status, 200, "{text}");
}

#[tokio::test(flavor = "multi_thread")]
async fn connection_is_closed_when_the_head_is_slow_or_not_http() {
    let server = TestServer::start();
    let (status, text) =
        raw_request(server.address(), b"GET /v1/system HTTP/1.1\r\nHost: loc").await;
    assert!(matches!(status, 0 | 408), "{text}");
    let (status, text) =
        raw_request(server.address(), b"\x16\x03\x01 this is no HTTP\r\n\r\n").await;
    assert!(matches!(status, 0 | 400), "{text}");
    server.get("/healthz").await.expect(200);
}

#[tokio::test(flavor = "multi_thread")]
async fn connection_is_closed_when_the_body_never_arrives() {
    let server = TestServer::start();
    let head = format!(
        "POST /v1/lineages HTTP/1.1\r\nHost: {}\r\nContent-Type: application/json\r\n\
         Content-Length: 20\r\n\r\n{{\"name\"",
        server.address()
    );
    let (status, text) = raw_request(server.address(), head.as_bytes()).await;
    assert!(matches!(status, 0 | 408), "{text}");
    let lineages = server.get("/v1/lineages").await.expect(200).json();
    assert_eq!(lineages["items"], json!([]), "an incomplete request has no effect");
}

#[tokio::test(flavor = "multi_thread")]
async fn write_is_refused_when_it_comes_from_another_origin() {
    let server = TestServer::start();
    let own = format!("http://{}", server.address());
    let body = json!({"name": "first"});
    let rows = [
        (403, "http://evil.example"),
        (403, "http://127.0.0.1:1"),
        (403, "null"),
        (201, own.as_str()),
    ];
    for (status, origin) in rows {
        let request = server.request(Method::POST, "/v1/lineages").header("origin", origin);
        let answer = server.send(request.json(&body)).await;
        assert_eq!(answer.status, status, "{origin}: {}", answer.text());
    }
    let request = server.request(Method::POST, "/v1/lineages");
    let request =
        request.header("sec-fetch-site", "cross-site").header("origin", "http://a.example");
    server.send(request.json(&body)).await.problem(403);
}

#[tokio::test(flavor = "multi_thread")]
async fn leases_are_refused_when_there_is_no_worker_token() {
    let server = TestServer::start();
    let kind = "application/octet-stream";
    server.post_bytes("/v1/leases", kind, vec![0; 8]).await.problem(401);
    let request = server.request(Method::POST, "/v1/leases").header("content-type", kind);
    let request = request.header("authorization", "Bearer 00000000").body(vec![0; 8]);
    server.send(request).await.problem(401);
}

#[tokio::test(flavor = "multi_thread")]
async fn routes_require_a_token_of_the_right_scope_when_a_token_exists() {
    let mut server = TestServer::start();
    assert_eq!(server.terminate(), 0);
    let data = server.data().to_string_lossy().into_owned();
    let made = |name: &str, scope: &str| {
        let arguments = ["token", "add", name, "--scope", scope, "--data", data.as_str()];
        let printed = brood(arguments).success().stdout;
        let words = printed.split_whitespace().map(str::to_owned);
        words.max_by_key(String::len).expect("the token is printed")
    };
    let (reader, breeder) = (made("reader", "read"), made("breeder", "breed"));
    let kept: Vec<Vec<u8>> = std::fs::read_dir(server.data())
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.is_file())
        .map(|path| std::fs::read(path).unwrap())
        .collect();
    let inside = |text: &str| {
        let text = text.as_bytes();
        kept.iter().any(|bytes| bytes.windows(text.len()).any(|part| part == text))
    };
    assert!(inside("breeder"), "the token table was searched");
    assert!(!inside(&reader) && !inside(&breeder), "only hashes of tokens are stored");
    server.restart();

    let body = json!({"name": "first"});
    let send = async |method: Method, token: Option<&str>| {
        let mut request = server.request(method.clone(), "/v1/lineages");
        if let Some(token) = token {
            request = request.header("authorization", format!("Bearer {token}"));
        }
        if method == Method::POST {
            request = request.json(&body);
        }
        server.send(request).await.status
    };
    assert_eq!(send(Method::GET, None).await, 401);
    assert_eq!(send(Method::GET, Some("wrong")).await, 401);
    assert_eq!(send(Method::GET, Some(&reader)).await, 200);
    assert_eq!(send(Method::POST, Some(&reader)).await, 403);
    assert_eq!(send(Method::POST, Some(&breeder)).await, 201);

    // Purging needs a larger scope than breeding, however the query is written.
    let delete = async |query: &str| {
        let path = format!("/v1/lineages/01890000-0000-7000-8000-000000000000{query}");
        let request = server.request(Method::DELETE, &path);
        server.send(request.header("authorization", format!("Bearer {breeder}"))).await.status
    };
    assert_eq!(delete("?purge=true").await, 403);
    assert_eq!(delete("?%70urge=true").await, 403);
    assert_eq!(delete("").await, 404);

    // Jobs of others need the scope of breeding; its own deferred answers a client may cancel.
    let send = async |method: Method, path: &str, token: &str| {
        let request = server.request(method, path).header("prefer", "respond-async, wait=0");
        server.send(request.header("authorization", format!("Bearer {token}"))).await
    };
    let brood = server.request(Method::POST, "/v1/lineages").json(&body);
    let brood = server.send(brood.header("authorization", format!("Bearer {breeder}"))).await;
    let brood = format!("/v1/lineages/{}/generations", text_of(&brood.expect(201).json()["id"]));
    let brood = server.request(Method::POST, &brood).json(&json!({"parents": [], "count": 1}));
    let brood = server.send(brood.header("authorization", format!("Bearer {breeder}"))).await;
    let child = ids(&brood.expect(201).json())[0].clone();
    let long = format!("/v1/individuals/{child}/render.png?size=2048&samples=4");
    let job = text_of(&send(Method::GET, &long, &reader).await.expect(202).json()["id"]);
    let others = text_of(&send(Method::GET, &long, &breeder).await.expect(202).json()["id"]);
    let cancel = |id: &str| format!("/v1/jobs/{id}/cancel");
    assert_eq!(send(Method::POST, &cancel(&others), &reader).await.status, 403);
    assert_eq!(send(Method::POST, &cancel(&job), &reader).await.status, 200);
    assert_eq!(send(Method::POST, &cancel(&others), &breeder).await.status, 200);

    // The page keeps the token in a cookie that scripts cannot read.
    let opened = server.post("/v1/session", &json!({"token": reader})).await.expect(204);
    let cookie = opened.header("set-cookie");
    for word in ["HttpOnly", "SameSite=Strict"] {
        assert!(cookie.contains(word), "{cookie}");
    }
    let pair = cookie.split(';').next().unwrap().to_owned();
    let request = server.request(Method::GET, "/v1/lineages").header("cookie", pair);
    server.send(request).await.expect(200);
    server.post("/v1/session", &json!({"token": "wrong"})).await.problem(401);
}

#[test]
fn server_does_not_start_when_it_would_be_open_to_the_network() {
    let data = tempfile::TempDir::new().unwrap();
    let data = data.path().to_string_lossy().into_owned();
    let refused = brood(["serve", "--listen", "0.0.0.0:0", "--data", data.as_str()]);
    assert_eq!(refused.code, 1, "{}", refused.stderr);
    assert!(refused.stderr.contains("token"), "{}", refused.stderr);
}

#[tokio::test(flavor = "multi_thread")]
async fn second_server_fails_with_one_line_when_port_or_directory_is_in_use() {
    let server = TestServer::start();
    let other = tempfile::TempDir::new().unwrap();
    let rows = [
        (server.address().to_owned(), other.path().to_string_lossy().into_owned()),
        ("127.0.0.1:0".to_owned(), server.data().to_string_lossy().into_owned()),
    ];
    for (listen, data) in rows {
        let refused = brood(["serve", "--listen", &listen, "--data", &data]);
        assert_eq!(refused.code, 1, "{}", refused.stderr);
        let said = refused.stderr.lines().filter(|line| line.starts_with("error")).count();
        assert_eq!(said, 1, "one clear line: {}", refused.stderr);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn server_stays_closed_when_its_last_token_is_revoked() {
    let server = TestServer::start();
    let data = server.data().to_string_lossy().into_owned();
    let token = |words: &[&str]| {
        let all = [&["token"], words, &["--data", data.as_str()]].concat();
        brood(all).success()
    };
    // Longer than a check of tokens is remembered.
    let later = || tokio::time::sleep(std::time::Duration::from_millis(700));
    server.get("/v1/system").await.expect(200);
    token(&["add", "first", "--scope", "admin"]);
    token(&["revoke", "first"]);
    later().await;
    server.get("/v1/system").await.problem(401);
    token(&["open"]);
    later().await;
    server.get("/v1/system").await.expect(200);
}
