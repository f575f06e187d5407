//! Pictures: thumbnails, larger renders, sheets, and caching.

use brood_tests::{TestLineage, TestServer, ids, text_of};
use reqwest::Method;
use serde_json::json;

#[tokio::test(flavor = "multi_thread")]
async fn thumbnails_are_256_square_and_immutable_by_default() {
    let server = TestServer::start();
    let lineage = TestLineage::with(&server, json!({"name": "first"})).await;
    let first = lineage.breed(json!({"parents": [], "seed": 3})).await;
    let generation = lineage.breed(json!({"parents": [ids(&first)[0]], "seed": 4})).await;
    let mut urls = vec![text_of(&generation["centre"]["thumbnail"])];
    let children = generation["individuals"].as_array().unwrap();
    urls.extend(children.iter().map(|child| text_of(&child["thumbnail"])));
    // All 21 at once, as the page requests them: a GET waits while its picture is rendered.
    let answers = futures::future::join_all(urls.iter().map(|url| server.get(url))).await;
    for (url, answer) in urls.iter().zip(answers) {
        let answer = answer.expect(200);
        assert_eq!(answer.header("content-type"), "image/png");
        assert!(answer.header("cache-control").contains("immutable"), "{:?}", answer.headers);
        assert_eq!(answer.header("x-content-type-options"), "nosniff");
        let picture = answer.picture();
        assert_eq!(picture.dimensions(), (256, 256));
        assert_eq!(picture.get_pixel(0, 0).0[3], 0, "the background must be transparent");
        assert_eq!(picture.get_pixel(128, 128).0[3], 255, "the object must be opaque");
        let tag = answer.header("etag");
        assert!(tag.starts_with('"') && tag.len() > 10, "a strong tag: {tag}");
        let again = server.request(Method::GET, url).header("if-none-match", &tag);
        let again = server.send(again).await.expect(304);
        assert!(again.body.is_empty());
        let stale = server.request(Method::GET, url).header("if-none-match", "\"other\"");
        assert_eq!(server.send(stale).await.expect(200).body, answer.body);
    }
}

/// Breeds; returns the URL of a child's thumbnail, and its bytes.
async fn thumbnail(server: &TestServer) -> (String, Vec<u8>) {
    let generation = TestLineage::new(server).await.random(1).await;
    let url = text_of(&generation["individuals"][0]["thumbnail"]);
    let bytes = server.get(&url).await.expect(200).body;
    (url, bytes)
}

#[tokio::test(flavor = "multi_thread")]
async fn pictures_are_the_same_when_the_cache_was_deleted() {
    let mut server = TestServer::start();
    let (url, before) = thumbnail(&server).await;
    assert_eq!(server.terminate(), 0);
    let cache = server.data().join("cache");
    assert!(cache.is_dir(), "pictures are cached in their own folder");
    std::fs::remove_dir_all(cache).unwrap();
    server.restart();
    assert_eq!(server.get(&url).await.expect(200).body, before, "rendered again, bit for bit");
}

#[tokio::test(flavor = "multi_thread")]
async fn picture_is_rendered_again_when_its_file_was_damaged() {
    let mut server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let generation = lineage.random(1).await;
    let urls: Vec<String> = generation["individuals"]
        .as_array()
        .unwrap()
        .iter()
        .map(|child| text_of(&child["thumbnail"]))
        .collect();
    let mut before = Vec::new();
    for url in &urls {
        before.push(server.get(url).await.expect(200).body);
    }
    assert_eq!(server.terminate(), 0);
    let damaged = damage(&server.data().join("cache"));
    assert!(damaged > 0, "there must be pictures on disk");
    server.restart();
    for (url, body) in urls.iter().zip(before) {
        assert_eq!(server.get(url).await.expect(200).body, body);
    }
}

/// Flips one byte in the middle of every file; returns the number of files.
fn damage(folder: &std::path::Path) -> usize {
    let mut count = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            count += damage(&path);
        } else {
            let mut bytes = std::fs::read(&path).unwrap();
            let middle = bytes.len() / 2;
            if let Some(byte) = bytes.get_mut(middle) {
                *byte = !*byte;
            }
            std::fs::write(&path, bytes).unwrap();
            count += 1;
        }
    }
    count
}

#[tokio::test(flavor = "multi_thread")]
async fn render_has_the_requested_size_and_light() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let child = ids(&lineage.random(5).await)[1].clone();
    let path = |query: &str| format!("/v1/individuals/{child}/render.png{query}");
    let plain = server.get(&path("")).await.expect(200).picture();
    assert_eq!(plain.dimensions(), (256, 256));
    let small = server.get(&path("?size=48")).await.expect(200).picture();
    assert_eq!(small.dimensions(), (48, 48));
    let turned = server.get(&path("?size=48&light_deg=90")).await.expect(200).picture();
    assert_ne!(turned, small);
    let back = server.get(&path("?size=48&light_deg=0")).await.expect(200).picture();
    assert_eq!(back, small, "0 is where the scene has the light");
    let rims = |picture: &image::RgbaImage| picture.pixels().any(|p| !matches!(p.0[3], 0 | 255));
    assert!(rims(&small), "pictures are antialiased by default");
    let adaptive = server.get(&path("?size=48&samples=adaptive")).await.expect(200).picture();
    assert_eq!(adaptive, small);
    assert!(rims(&server.get(&path("?size=48&samples=4")).await.expect(200).picture()));
    assert!(!rims(&server.get(&path("?size=48&samples=1")).await.expect(200).picture()));
    let tall = server.get(&path("?size=30x50")).await.expect(200).picture();
    assert_eq!(tall.dimensions(), (30, 50));
    let square = server.get(&path("?size=48x48")).await.expect(200);
    assert_eq!(square.header("etag"), server.get(&path("?size=48")).await.header("etag"));
    for size in ["15x64", "64x15", "2049x64", "64x2049", "64x", "x64", "64,64", "64x64x64", ""] {
        let problem = server.get(&path(&format!("?size={size}"))).await.problem(400);
        assert!(text_of(&problem["detail"]).contains("such as 640x360"), "{problem}");
    }
    for query in ["samples=0", "samples=65", "samples=many", "samples="] {
        server.get(&path(&format!("?{query}"))).await.problem(400);
    }
    let scene = server.post("/v1/scenes", &json!({"mesh": "cube"})).await.expect(201).json();
    let query = format!("?size=48&scene={}", text_of(&scene["id"]));
    assert_ne!(server.get(&path(&query)).await.expect(200).picture(), small);
    let linear = server.get(&format!("/v1/individuals/{child}/render.exr?size=48")).await;
    assert_eq!(linear.expect(200).body[..4], [0x76, 0x2f, 0x31, 0x01], "OpenEXR's magic number");
}

#[tokio::test(flavor = "multi_thread")]
async fn area_has_the_pixels_of_the_whole_picture() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let child = ids(&lineage.random(5).await)[2].clone();
    let path = |query: &str| format!("/v1/individuals/{child}/render.png?size=64{query}");
    for samples in ["adaptive", "1", "3"] {
        let query = format!("&samples={samples}");
        let whole = server.get(&path(&query)).await.expect(200).picture();
        let part =
            server.get(&path(&format!("{query}&area=20,5,30,17"))).await.expect(200).picture();
        assert_eq!(part, image::imageops::crop_imm(&whole, 20, 5, 30, 17).to_image(), "{samples}");
    }
    let wide = |query: &str| format!("/v1/individuals/{child}/render.png?size=70x40{query}");
    let whole = server.get(&wide("")).await.expect(200).picture();
    assert_eq!(whole.dimensions(), (70, 40));
    let part = server.get(&wide("&area=45,5,25,35")).await.expect(200).picture();
    assert_eq!(part, image::imageops::crop_imm(&whole, 45, 5, 25, 35).to_image());
    server.get(&wide("&area=0,0,40,41")).await.problem(400);
    let linear = format!("/v1/individuals/{child}/render.exr?size=70x40&area=45,5,25,35");
    let linear = server.get(&linear).await.expect(200).body;
    let linear = image::load_from_memory(&linear).unwrap();
    assert_eq!((linear.width(), linear.height()), (25, 35));
    let all = server.get(&path("&area=0,0,64,64")).await.expect(200);
    let plain = server.get(&path("")).await.expect(200);
    assert_eq!(all.header("etag"), plain.header("etag"), "the whole area is the picture itself");
    for area in ["", "1,2,3", "0,0,0,4", "40,0,25,4", "0,0,4294967295,2", "a,b,c,d", "-1,0,2,2"] {
        server.get(&path(&format!("&area={area}"))).await.problem(400);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn picture_of_any_shape_is_rendered_again_from_its_key() {
    let mut server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let child = ids(&lineage.random(5).await)[2].clone();
    let mut known = Vec::new();
    for size in ["40", "70x40", "40x70"] {
        let path = format!("/v1/individuals/{child}/render.png?size={size}");
        let picture = server.get(&path).await.expect(200);
        let key = picture.header("etag").trim_matches('"').to_owned();
        known.push((format!("/v1/thumbnails/{key}.png"), picture.body));
    }
    assert_eq!(server.terminate(), 0);
    std::fs::remove_dir_all(server.data().join("cache")).unwrap();
    server.restart();
    for (path, body) in known {
        assert_eq!(server.get(&path).await.expect(200).body, body, "{path}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn sheet_is_six_by_six_around_the_centre_when_there_are_twenty_children() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let first = lineage.breed(json!({"parents": [], "seed": 1})).await;
    let generation = lineage.breed(json!({"parents": [ids(&first)[0]], "seed": 2})).await;
    let path = format!("/v1/generations/{}/sheet.png", text_of(&generation["id"]));
    let sheet = server.get(&path).await.expect(200).picture();
    let (width, height) = sheet.dimensions();
    assert_eq!(width, height);
    assert!(width >= 6 * 32, "six cells of 32 pixels: {width}");
    let cell = width / 6;
    let covered = |x: u32, y: u32| {
        let here = image::imageops::crop_imm(&sheet, x * cell, y * cell, cell, cell).to_image();
        let corner = *here.get_pixel(0, 0);
        here.pixels().filter(|pixel| **pixel != corner).count()
    };
    for (x, y) in (0..6).flat_map(|x| (0..6).map(move |y| (x, y))) {
        if x == 0 || x == 5 || y == 0 || y == 5 {
            assert!(covered(x, y) > 100, "cell {x}, {y} shows a child");
        }
    }
    let turned = server.get(&format!("{path}?light_deg=90")).await.expect(200).picture();
    assert_ne!(turned, sheet, "the light is elsewhere");
    server.get(&format!("{path}?light_deg=1e7")).await.problem(400);
    let one = ids(&first)[..5].join(",");
    let free = server.get(&format!("/v1/sheet.png?individuals={one}")).await.expect(200).picture();
    assert!(free.width() < width, "five cells need a smaller sheet");
    server.get("/v1/sheet.png").await.problem(400);
}
