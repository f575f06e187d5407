//! Control images of painted materials: uploads, genomes that name them, pictures, files and the
//! command line.

use std::io::Cursor;

use brood_tests::{TestLineage, TestServer, brood, hashes, ids, text_of};
use serde_json::{Value, json};
use tempfile::TempDir;

const TEXT: &str = "text/x-brood";
const RED: [u8; 4] = [200, 30, 40, 255];

fn file(width: u32, height: u32, format: image::ImageFormat) -> Vec<u8> {
    let [red, green, blue, _] = RED;
    let picture = image::RgbImage::from_pixel(width, height, image::Rgb([red, green, blue]));
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

fn png() -> Vec<u8> {
    file(8, 4, image::ImageFormat::Png)
}

fn toon(image: &str) -> String {
    format!("brood 1\n.effect light\npalette #000000 #ffffff\nbasis step\nbright {image}\n")
}

async fn upload(server: &TestServer) -> String {
    let answer = server.post_bytes("/v1/images", "image/png", png()).await.expect(201).json();
    text_of(&answer["id"])
}

/// Number of pixels with the colour of the image.
fn red(picture: &image::RgbaImage) -> usize {
    picture.pixels().filter(|pixel| pixel.0 == RED).count()
}

async fn painted(server: &TestServer) -> TestLineage<'_> {
    let body = json!({"name": "painted", "start": "painted", "thumbnail_px": 48});
    TestLineage::with(server, body).await
}

#[tokio::test(flavor = "multi_thread")]
async fn images_are_stored_once_and_returned_as_they_came() {
    let server = TestServer::start();
    let answer = server.post_bytes("/v1/images", "image/png", png()).await.expect(201).json();
    assert_eq!((&answer["kind"], &answer["width"]), (&json!("image"), &json!(8)), "{answer}");
    assert_eq!((&answer["height"], answer.get("lumens")), (&json!(4), None));
    let id = upload(&server).await;
    assert_eq!(answer["id"], id.as_str());
    let stored = server.get(&format!("/v1/images/{id}")).await.expect(200);
    assert_eq!(stored.header("content-type"), "image/png");
    assert_eq!(stored.body, png());
    let jpeg = file(5, 5, image::ImageFormat::Jpeg);
    let answer = server.post_bytes("/v1/images", "image/jpeg", jpeg).await.expect(201).json();
    let stored = server.get(&format!("/v1/images/{}", text_of(&answer["id"]))).await.expect(200);
    assert_eq!(stored.header("content-type"), "image/jpeg");
    for unknown in ["0".repeat(64), "red".to_owned()] {
        server.get(&format!("/v1/images/{unknown}")).await.problem(404);
    }
    let long = file(20_000, 1, image::ImageFormat::Png);
    let problem = server.post_bytes("/v1/images", "image/png", long).await.problem(422);
    assert!(text_of(&problem["detail"]).contains("at most 4096 x 4096"), "{problem}");
    for bytes in [b"red".to_vec(), Vec::new(), png()[..40].to_vec()] {
        server.post_bytes("/v1/images", "image/png", bytes).await.problem(422);
    }
    server.post_bytes("/v1/images", "image/webp", png()).await.problem(415);
}

#[tokio::test(flavor = "multi_thread")]
async fn genomes_with_images_are_drawn_bred_and_refused_without_them() {
    let server = TestServer::start();
    let unknown = "ab".repeat(32);
    let scene = server.post("/v1/scenes", &json!({"lights": [{}]})).await.expect(201).json();
    let render = format!("/v1/render.png?size=48&scene={}", text_of(&scene["id"]));
    for path in ["/v1/genomes", &render] {
        let problem = server.post_bytes(path, TEXT, toon(&unknown)).await.problem(404);
        assert_eq!(problem["pointer"], "/effects/0/parameters/bright/image", "{path}");
        assert!(text_of(&problem["detail"]).contains("POST /v1/images"), "{problem}");
    }
    let profile = "TILT=NONE\n1 -1 1 2 1 1 2 0 0 0\n1 1 60\n0 90\n0\n5 5\n";
    let profile = server.post_bytes("/v1/profiles", "application/x-ies", profile).await;
    let profile = text_of(&profile.expect(201).json()["id"]);
    let problem = server.post_bytes("/v1/genomes", TEXT, toon(&profile)).await.problem(422);
    assert_eq!(problem["detail"], "the id belongs to a file of kind profile");

    let id = upload(&server).await;
    let lamp = json!({"kind": "environment", "image": id});
    let problem = server.post("/v1/scenes", &json!({"lights": [lamp]})).await.problem(422);
    assert_eq!(problem["detail"], "the id belongs to a file of kind image");
    let stored = server.post_bytes("/v1/genomes", TEXT, toon(&id)).await.expect(201).json();
    let posted = server.post_bytes(&render, TEXT, toon(&id)).await.expect(200);
    assert!(red(&posted.picture()) > 100);
    let refused = server.post_bytes("/v1/exports/wgsl", TEXT, toon(&id)).await.problem(422);
    assert!(text_of(&refused["detail"]).contains("control images is not exported"), "{refused}");

    let lineage = painted(&server).await;
    let body = json!({"genomes": [stored["hash"]]});
    let adopted = server.post(&lineage.path("/adoptions"), &body).await.expect(201).json();
    let picture = server.get(&text_of(&adopted["individuals"][0]["thumbnail"])).await;
    assert!(red(&picture.expect(200).picture()) > 100);
    let locks = json!({"effect_parameters": [{"effect": "light", "name": "bright"}]});
    let body = json!({"parents": [ids(&adopted)[0]], "count": 6, "seed": 1, "locks": locks});
    let bred = lineage.breed(body).await;
    for hash in hashes(&bred) {
        let genome = server.get(&format!("/v1/genomes/{hash}")).await.expect(200).json();
        let image = &genome["effects"][0]["parameters"]["bright"];
        assert_eq!(*image, json!({"image": id, "share": 1.0}));
    }
    let locks = json!({"effect_parameters": [{"effect": "light", "name": "dark"}]});
    let body = json!({"parents": [ids(&adopted)[0]], "seed": 1, "locks": locks});
    server.post(&lineage.path("/generations"), &body).await.problem(422);
}

#[tokio::test(flavor = "multi_thread")]
async fn lineage_files_carry_their_images() {
    let server = TestServer::start();
    let id = upload(&server).await;
    let stored = server.post_bytes("/v1/genomes", TEXT, toon(&id)).await.expect(201).json();
    let lineage = painted(&server).await;
    let body = json!({"genomes": [stored["hash"]]});
    server.post(&lineage.path("/adoptions"), &body).await.expect(201);
    let file = server.get(&lineage.path("/file")).await.expect(200).json();
    assert_eq!(file["light_assets"][0]["kind"], "image");

    let other = TestServer::start();
    let mut without = file.clone();
    without["light_assets"] = json!([]);
    let problem = other.post("/v1/lineages/import", &without).await.problem(404);
    assert_eq!(problem["pointer"], format!("/genomes/{}", text_of(&stored["hash"])), "{problem}");
    let copy = other.post("/v1/lineages/import", &file).await.expect(201).json();
    let path = format!("/v1/lineages/{}/generations", text_of(&copy["id"]));
    let listed = other.get(&path).await.expect(200).json();
    let one = &listed["items"][0]["individuals"][0];
    let picture = other.get(&text_of(&one["thumbnail"])).await.expect(200).picture();
    assert!(red(&picture) > 100);
}

#[test]
fn command_line_prints_hashes_and_reads_images() {
    let folder = TempDir::new().unwrap();
    let here = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    std::fs::write(here("red.png"), png()).unwrap();
    let lines = brood(["image", &here("red.png")]).success().stdout;
    let hash = lines.split_whitespace().next().unwrap().to_owned();
    assert!(lines.contains("8 x 4"), "{lines}");
    let printed = brood(["image", &here("red.png"), "--json"]).success().stdout;
    let printed: Value = serde_json::from_str(&printed).unwrap();
    assert_eq!(printed[0]["image"], hash.as_str());
    std::fs::write(here("toon.brood"), toon(&hash)).unwrap();
    let (toon, out, image) = (here("toon.brood"), here("out.png"), here("red.png"));
    let render = ["render", &toon, "--size", "48", "--backend", "cpu", "-o", &out];
    let failed = brood(render);
    assert_eq!(failed.code, 1);
    let words = format!("there is no control image {hash}; offline, give its file with --image");
    assert!(failed.stderr.contains(&words), "{}", failed.stderr);
    brood(render.into_iter().chain(["--image", &image])).success();
    let picture = image::open(&out).unwrap().into_rgba8();
    assert!(red(&picture) > 100);
    let failed = brood(render.into_iter().chain(["--image", &toon]));
    assert!(failed.stderr.contains("PNG or JPEG"), "{}", failed.stderr);
}
