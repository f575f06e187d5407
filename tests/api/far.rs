//! Clients far from the server: the page in one script, compressed answers, small thumbnails.

use std::io::Read;
use std::time::Duration;

use brood_tests::{Answer, TestLineage, TestServer, ids, text_of};
use reqwest::Method;
use serde_json::json;

/// Reads a file with this `Accept-Encoding`.
async fn get_encoded(server: &TestServer, path: &str, accepted: &str) -> Answer {
    let request = server.request(Method::GET, path).header("accept-encoding", accepted);
    server.send(request).await.expect(200)
}

/// Addresses in the page that begin with `/web/`.
fn files_of(page: &str) -> Vec<String> {
    page.split('"').filter(|text| text.starts_with("/web/")).map(str::to_owned).collect()
}

#[tokio::test(flavor = "multi_thread")]
async fn page_is_one_script_and_one_style_sheet_that_browsers_keep() {
    let server = TestServer::start();
    let page = server.get("/").await.expect(200);
    assert_eq!(page.header("cache-control"), "no-cache");
    let files = files_of(&page.text());
    let ends = |ending: &str| files.iter().filter(|file| file.ends_with(ending)).count();
    assert_eq!((ends(".js"), ends(".css"), files.len()), (1, 1, 3), "{files:?}");
    for file in files.iter().filter(|file| !file.ends_with(".svg")) {
        let answer = server.get(file).await.expect(200);
        assert!(answer.header("cache-control").contains("immutable"), "{file}");
        let again =
            server.request(Method::GET, file).header("if-none-match", answer.header("etag"));
        server.send(again).await.expect(304);
    }
    server.get("/web/0123456789abcdef.js").await.expect(404);
    // The modules stay available one by one.
    let modules = files_of(&server.get("/web/index.html").await.expect(200).text());
    assert!(modules.contains(&"/web/main.js".to_owned()), "{modules:?}");
    let module = server.get("/web/main.js").await.expect(200);
    assert_eq!(module.header("cache-control"), "no-cache");
    assert!(module.text().contains("import { render }"), "modules are as written");
}

#[tokio::test(flavor = "multi_thread")]
async fn answers_are_compressed_as_accepted_and_never_refused() {
    let server = TestServer::start();
    let files = files_of(&server.get("/").await.expect(200).text());
    let script = files.iter().find(|file| file.ends_with(".js")).unwrap();
    for path in [script.as_str(), "/v1/presets", "/openapi.json"] {
        let plain = server.get(path).await.expect(200);
        assert_eq!(plain.header("content-encoding"), "", "{path}");
        assert_eq!(plain.header("vary"), "accept-encoding", "{path}");
        for (accepted, expected) in [
            ("gzip", "gzip"),
            ("br", "br"),
            ("gzip, deflate", "gzip"),
            ("gzip, deflate, br, zstd", "br"),
            ("gzip;q=1.0, br;q=0.5", "gzip"),
            ("GZIP", "gzip"),
            ("*", "br"),
            ("identity", ""),
            ("deflate", ""),
            ("gzip;q=0", ""),
            ("identity;q=0", ""),
            ("*;q=0", ""),
            ("gzip;q=0, identity;q=0, br;q=0, *;q=0", ""),
            ("identity;q=0, gzip", "gzip"),
            ("", ""),
            (";;,, q=1 gzip;q=banana;; x", ""),
        ] {
            let answer = get_encoded(&server, path, accepted).await;
            assert_eq!(answer.header("content-encoding"), expected, "{path}: {accepted}");
            assert_eq!(answer.header("vary"), "accept-encoding", "{path}: {accepted}");
            let body = match expected {
                "gzip" => {
                    let mut body = Vec::new();
                    flate2::read::GzDecoder::new(&*answer.body).read_to_end(&mut body).unwrap();
                    body
                }
                "br" => {
                    let mut body = Vec::new();
                    brotli::Decompressor::new(&*answer.body, 4096).read_to_end(&mut body).unwrap();
                    body
                }
                _ => answer.body.clone(),
            };
            assert!(body == plain.body, "{path}: {accepted}: the content differs");
            let is_small = answer.body.len() < plain.body.len() / 2;
            assert_eq!(is_small, !expected.is_empty(), "{path}: {accepted}");
        }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn changes_are_made_once_and_reported_when_no_encoding_is_accepted() {
    let server = TestServer::start();
    let request = server.request(Method::POST, "/v1/lineages").json(&json!({"name": "far"}));
    let request = request.header("accept-encoding", "identity;q=0, *;q=0");
    server.send(request).await.expect(201);
    let lineages = server.get("/v1/lineages").await.expect(200).json();
    assert_eq!(lineages["items"].as_array().unwrap().len(), 1);
    // The version of a compressed answer is one to change the resource with.
    let path = format!("/v1/lineages/{}", text_of(&lineages["items"][0]["id"]));
    let read = get_encoded(&server, &path, "gzip").await;
    let version = read.header("etag");
    let patched = server.patch(&path, Some(&version), &json!({"name": "farther"})).await;
    patched.expect(200);
    let missing = server.request(Method::GET, "/v1/lineages/x").header("accept-encoding", "gzip");
    let problem = server.send(missing).await;
    assert!((400..500).contains(&problem.status));
    let mut text = String::new();
    flate2::read::GzDecoder::new(&*problem.body).read_to_string(&mut text).unwrap();
    assert!(text.contains("request_id"), "{text}");
}

#[tokio::test(flavor = "multi_thread")]
async fn pictures_and_event_streams_are_not_compressed() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let generation = lineage.random(1).await;
    let url = text_of(&generation["individuals"][0]["thumbnail"]);
    let picture = get_encoded(&server, &url, "gzip, br").await;
    assert_eq!(picture.header("content-encoding"), "");
    picture.picture();
    let events = server.request(Method::GET, &lineage.path("/events"));
    let mut events = events.header("accept-encoding", "gzip, br").send().await.unwrap();
    assert!(!events.headers().contains_key("content-encoding"));
    let first = tokio::time::timeout(Duration::from_secs(10), events.chunk()).await.unwrap();
    assert!(first.unwrap().is_some(), "events arrive as they happen");
}

#[tokio::test(flavor = "multi_thread")]
async fn thumbnails_as_webp_are_near_the_png_in_fewer_bytes() {
    let server = TestServer::start();
    let lineage = TestLineage::with(&server, json!({"name": "256 pixels"})).await;
    let parent = ids(&lineage.random(1).await)[0].clone();
    let generation = lineage.breed(json!({"parents": [parent], "seed": 2})).await;
    let (mut png_bytes, mut webp_bytes) = (0, 0);
    let (mut sum, mut count) = (0.0, 0.0);
    for child in generation["individuals"].as_array().unwrap() {
        let url = text_of(&child["thumbnail"]);
        let png = server.get(&url).await.expect(200);
        let small = url.replace(".png", ".webp");
        let webp = server.get(&small).await.expect(200);
        assert_eq!(webp.header("content-type"), "image/webp");
        assert!(webp.header("cache-control").contains("immutable"));
        let etag = webp.header("etag");
        assert_ne!(etag, png.header("etag"), "other bytes have another tag");
        let again = server.request(Method::GET, &small).header("if-none-match", &etag);
        server.send(again).await.expect(304);
        let exact = png.picture();
        let near = webp::Decoder::new(&webp.body).decode().expect("WebP can be decoded");
        assert_eq!((near.width(), near.height()), exact.dimensions());
        let (mut own_sum, mut own_count) = (0, 0);
        for (exact, near) in exact.pixels().zip(near.chunks(if near.is_alpha() { 4 } else { 3 })) {
            if near.len() == 4 {
                assert_eq!(exact.0[3], near[3], "alpha is exact");
            }
            if exact.0[3] > 0 {
                own_sum += (0..3).map(|at| u32::from(exact.0[at].abs_diff(near[at]))).sum::<u32>();
                own_count += 3;
            }
        }
        // Colourful noise differs most, as WebP stores colours at half the resolution.
        let mean = f64::from(own_sum) / f64::from(own_count);
        assert!(mean < 10.0, "{small}: {mean} codes in the mean");
        sum += f64::from(own_sum);
        count += f64::from(own_count);
        png_bytes += png.body.len();
        webp_bytes += webp.body.len();
    }
    assert!(sum / count < 6.0, "{} codes in the mean of the brood", sum / count);
    assert!(webp_bytes < png_bytes / 3, "{webp_bytes} and {png_bytes} bytes");
    let url = text_of(&generation["individuals"][0]["thumbnail"]);
    for ending in [".jpg", ".webp.png", ".avif", "", "."] {
        server.get(&url.replace(".png", ending)).await.problem(404);
    }
}
