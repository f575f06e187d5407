//! Colours of a picture: read from an upload, and used to paint broods over HTTP and on the command
//! line.

use std::collections::HashSet;
use std::io::Cursor;

use brood_tests::{TestLineage, TestServer, brood, hashes, ids, text_of};
use serde_json::{Value, json};
use tempfile::TempDir;

/// Three shaded paints, one below the other.
fn painting(width: u32, height: u32) -> image::RgbImage {
    const PAINTS: [[f32; 3]; 3] =
        [[240.0, 130.0, 60.0], [85.0, 125.0, 230.0], [90.0, 200.0, 105.0]];
    image::RgbImage::from_fn(width, height, |x, y| {
        let light = 0.35 + 0.65 * x as f32 / width as f32;
        image::Rgb(PAINTS[(3 * y / height) as usize].map(|value| (value * light) as u8))
    })
}

fn encoded(picture: &image::RgbImage, format: image::ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

async fn palette(server: &TestServer) -> Value {
    let png = encoded(&painting(60, 45), image::ImageFormat::Png);
    server.post_bytes("/v1/palettes", "image/png", png).await.expect(200).json()
}

async fn painted_lineage(server: &TestServer) -> TestLineage<'_> {
    let body = json!({"name": "painted", "start": "painted", "thumbnail_px": 16});
    TestLineage::with(server, body).await
}

/// Codes of the palette of a genome.
async fn colors(server: &TestServer, hash: &str) -> Vec<String> {
    let genome = server.get(&format!("/v1/genomes/{hash}")).await.expect(200).json();
    let palette = &genome["effects"][0]["parameters"]["palette"];
    palette.as_array().unwrap().iter().map(text_of).collect()
}

#[tokio::test(flavor = "multi_thread")]
async fn colours_of_a_picture_are_read_by_regions() {
    let server = TestServer::start();
    let found = palette(&server).await;
    let regions = found["regions"].as_array().unwrap();
    assert_eq!(regions.len(), 3, "{found}");
    for region in regions {
        assert!((region["share"].as_f64().unwrap() - 1.0 / 3.0).abs() < 0.01, "{found}");
    }
    let larger = encoded(&painting(1200, 900), image::ImageFormat::Jpeg);
    let larger = server.post_bytes("/v1/palettes", "image/jpeg", larger).await.expect(200).json();
    assert_eq!(larger["regions"].as_array().map(Vec::len), Some(3), "{larger}");
}

#[tokio::test(flavor = "multi_thread")]
async fn files_without_colours_are_refused() {
    let server = TestServer::start();
    let path = "/v1/palettes";
    let long = encoded(&image::RgbImage::new(20_000, 1), image::ImageFormat::Png);
    let problem = server.post_bytes(path, "image/png", long).await.problem(422);
    assert_eq!(
        problem["detail"],
        "a picture has at most 4096 x 4096 pixels; this one has 20000 x 1"
    );
    for bytes in [b"colours".to_vec(), Vec::new()] {
        let problem = server.post_bytes(path, "image/png", bytes).await.problem(422);
        assert_eq!(problem["detail"], "the picture must be a PNG or JPEG file");
    }
    let whole = encoded(&painting(60, 45), image::ImageFormat::Png);
    let half = whole[..whole.len() / 2].to_vec();
    let problem = server.post_bytes(path, "image/png", half).await.problem(422);
    assert!(text_of(&problem["detail"]).starts_with("the picture cannot be read"), "{problem}");
    // Width 0 in the header.
    let mut empty = whole.clone();
    empty[16..20].fill(0);
    server.post_bytes(path, "image/png", empty).await.problem(422);
    let mut clear = Cursor::new(Vec::new());
    image::RgbaImage::new(3, 3).write_to(&mut clear, image::ImageFormat::Png).unwrap();
    let problem = server.post_bytes(path, "image/png", clear.into_inner()).await.problem(422);
    assert_eq!(problem["detail"], "the picture has no pixels that are not transparent");
    server.post_bytes(path, "image/webp", whole).await.problem(415);
}

#[tokio::test(flavor = "multi_thread")]
async fn painted_broods_are_repeatable_and_stored_and_exported() {
    let server = TestServer::start();
    let lineage = painted_lineage(&server).await;
    let palette = palette(&server).await;
    let first = lineage.breed(json!({"count": 4, "seed": 1, "painting": palette})).await;
    assert_eq!(first["painting"], palette);
    let body = |painting: Value| {
        let mut body =
            json!({"parents": [ids(&first)[0]], "count": 12, "seed": 2, "mutation": 0.3});
        body["curation"] = "diverse".into();
        body["painting"] = painting;
        body
    };
    let painted = lineage.breed(body(palette.clone())).await;
    let plain = lineage.breed(body(Value::Null)).await;
    assert_ne!(hashes(&plain), hashes(&painted));
    assert_eq!(plain.get("painting"), None);
    let path = format!("/v1/generations/{}", text_of(&painted["id"]));
    // The record of the generation repeats it without the picture.
    let record = server.get(&path).await.expect(200).json();
    assert_eq!(record["painting"], palette);
    assert_eq!(hashes(&lineage.breed(body(record["painting"].clone())).await), hashes(&painted));

    let file = server.get(&lineage.path("/file")).await.expect(200).json();
    assert_eq!(file["generations"][1]["painting"], palette);
    assert_eq!(file["generations"][2].get("painting"), None);
    let copy = server.post("/v1/lineages/import", &file).await.expect(201).json();
    let copied = format!("/v1/lineages/{}/generations", text_of(&copy["id"]));
    let listed = server.get(&copied).await.expect(200).json();
    assert_eq!(listed["items"][1]["painting"], palette);

    let folder = TempDir::new().unwrap();
    let here = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let request =
        server.request(reqwest::Method::GET, &format!("/v1/genomes/{}", hashes(&first)[0]));
    let parent = server.send(request.header("accept", "text/x-brood")).await.expect(200).body;
    std::fs::write(here("parent.brood"), parent).unwrap();
    painting(60, 45).save(here("painting.png")).unwrap();
    let printed = brood(["palette", &here("painting.png"), "--json"]).success().stdout;
    assert_eq!(serde_json::from_str::<Value>(&printed).unwrap(), palette);
    let lines = brood(["palette", &here("painting.png")]).success().stdout;
    assert_eq!(lines.lines().count(), 4, "{lines}");
    assert!(lines.contains(&text_of(&palette["regions"][1]["bright"])), "{lines}");
    std::fs::write(here("painting.json"), printed).unwrap();
    for painting in [here("painting.png"), here("painting.json")] {
        let printed = brood([
            "breed",
            "--parent",
            &here("parent.brood"),
            "--seed",
            "2",
            "--count",
            "12",
            "--curation",
            "diverse",
            "--painting",
            &painting,
            "--size",
            "16",
            "-o",
            &here("bred"),
        ]);
        let printed = printed.success().stdout;
        let bred = printed.lines().map(|line| line.split_whitespace().nth(1).unwrap().to_owned());
        assert_eq!(bred.collect::<Vec<_>>(), hashes(&painted), "{painting}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn children_have_the_colours_of_the_painting_and_keep_a_locked_palette() {
    let server = TestServer::start();
    let lineage = painted_lineage(&server).await;
    let first = lineage.random(1).await;
    let parent = &ids(&first)[0];
    let of = |hex: &str| -> Vec<u8> {
        (1..7).step_by(2).map(|at| u8::from_str_radix(&hex[at..at + 2], 16).unwrap()).collect()
    };
    /// Channels from the strongest to the weakest: the paints of the picture have different orders.
    fn order(codes: &[u8]) -> Vec<usize> {
        let mut order = vec![0, 1, 2];
        order.sort_by_key(|channel| std::cmp::Reverse(codes[*channel]));
        order
    }
    // Of the picture: red over green over blue, blue over green over red, green over blue over red.
    let known: HashSet<Vec<usize>> = [vec![0, 1, 2], vec![2, 1, 0], vec![1, 2, 0]].into();
    let palette = palette(&server).await;
    // Without mutation, children have other colours and nothing else.
    let body =
        json!({"parents": [parent], "count": 20, "seed": 3, "mutation": 0, "painting": palette});
    let painted = lineage.breed(body).await;
    let mut seen = HashSet::new();
    for hash in hashes(&painted) {
        for color in colors(&server, &hash).await {
            let order = order(&of(&color));
            assert!(known.contains(&order), "{color} of {hash}");
            seen.insert(order);
        }
    }
    assert_eq!(seen, known);
    let own = colors(&server, &hashes(&first)[0]).await;
    let locks = json!({"effect_parameters": [{"effect": "light", "name": "palette"}]});
    let body = json!({
        "parents": [parent], "count": 5, "seed": 3, "painting": palette, "locks": locks,
    });
    for hash in hashes(&lineage.breed(body).await) {
        assert_eq!(colors(&server, &hash).await, own);
    }
    let still = json!({
        "parents": [parent], "seed": 3, "mutation": 0, "painting": palette, "locks": locks,
    });
    server.post(&lineage.path("/generations"), &still).await.problem(422);
}

#[tokio::test(flavor = "multi_thread")]
async fn painting_is_refused_for_brdfs_and_when_it_is_invalid() {
    let server = TestServer::start();
    let palette = palette(&server).await;
    let wild = TestLineage::new(&server).await;
    let parent = wild.random_child(1).await;
    for parents in [json!([]), json!([parent])] {
        let body = json!({"parents": parents, "painting": palette});
        let problem = server.post(&wild.path("/generations"), &body).await.problem(422);
        assert_eq!(problem["pointer"], "/painting");
        assert!(text_of(&problem["detail"]).contains("are BRDFs"), "{problem}");
    }
    let lineage = painted_lineage(&server).await;
    let mut bad = palette.clone();
    bad["regions"][1]["dark"] = "blue".into();
    let rows = [
        (json!({"regions": []}), "/painting", "1 to 6 regions, got 0"),
        (bad, "/painting", "a colour must be like #2b1e46"),
        (json!({"colors": []}), "/painting", "colors"),
    ];
    for (painting, pointer, words) in rows {
        let body = json!({"painting": painting});
        let problem = server.post(&lineage.path("/generations"), &body).await.problem(400);
        assert!(text_of(&problem["pointer"]).starts_with(pointer), "{problem}");
        assert!(problem.to_string().contains(words), "{problem}");
    }
    let folder = TempDir::new().unwrap();
    let here = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    painting(30, 30).save(here("painting.png")).unwrap();
    let failed = brood(["breed", "--painting", &here("painting.png"), "-o", &here("bred")]);
    assert_eq!(failed.code, 1, "{}", failed.stdout);
    assert!(failed.stderr.contains("`painting` colours painted materials"), "{}", failed.stderr);
}
