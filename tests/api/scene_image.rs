//! Images of scenes: backdrops and normal maps, in pictures, lineage files and on the command line.

use std::io::Cursor;

use brood_tests::{TestLineage, TestServer, brood, text_of};
use serde_json::{Value, json};
use tempfile::TempDir;

const TEXT: &str = "text/x-brood";
/// Colour of the left half.
const LEFT: [u8; 4] = [200, 30, 40, 255];

/// PNG of two colours. As a normal map, the left half turns normals aside, the right one upwards.
fn png() -> Vec<u8> {
    let pixel = |x: u32, _| image::Rgb(if x < 8 { [200, 30, 40] } else { [128, 160, 240] });
    let mut bytes = Cursor::new(Vec::new());
    let picture = image::RgbImage::from_fn(16, 16, pixel);
    picture.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

async fn upload(server: &TestServer) -> String {
    let answer = server.post_bytes("/v1/images", "image/png", png()).await.expect(201).json();
    text_of(&answer["id"])
}

/// Scene of a sphere on the ground beside a cube, with an image behind and bumps on all of them.
fn scene(image: &str) -> Value {
    let map = json!({"image": image, "strength": 0.5, "repeat": 2});
    json!({
        "mesh": "sphere",
        "lights": [{}],
        "backdrop": {"kind": "image", "image": image},
        "normal_map": map,
        "camera": {"orbit_deg": [0, 0]},
        "objects": [{"mesh": "cube", "position": [1, 0, 0], "scale": 0.3, "normal_map": map}],
        "ground": {"height": -1.5, "normal_map": map},
    })
}

#[tokio::test(flavor = "multi_thread")]
async fn scenes_name_their_images() {
    let server = TestServer::start();
    let unknown = "ab".repeat(32);
    let id = upload(&server).await;
    let profile = "TILT=NONE\n1 -1 1 2 1 1 2 0 0 0\n1 1 60\n0 90\n0\n5 5\n";
    let profile = server.post_bytes("/v1/profiles", "application/x-ies", profile).await;
    let profile = text_of(&profile.expect(201).json()["id"]);
    let places = [
        "/backdrop/image",
        "/normal_map/image",
        "/objects/0/normal_map/image",
        "/ground/normal_map/image",
    ];
    for at in places {
        for (name, status) in [(unknown.as_str(), 404), ("sky.png", 404), (&*profile, 422)] {
            let mut wrong = scene(&id);
            *wrong.pointer_mut(at).unwrap() = json!(name);
            let problem = server.post("/v1/scenes", &wrong).await.problem(status);
            assert_eq!(problem["pointer"], at, "{problem}");
        }
        let mut empty = scene(&id);
        *empty.pointer_mut(at).unwrap() = json!("");
        assert_eq!(server.post("/v1/scenes", &empty).await.problem(422)["pointer"], at);
    }
    for (at, value) in [
        ("/normal_map/strength", json!(4.5)),
        ("/normal_map/repeat", json!(0)),
        ("/objects/0/normal_map/repeat", json!(1001)),
        ("/ground/normal_map/strength", json!(-5)),
    ] {
        let mut wrong = scene(&id);
        *wrong.pointer_mut(at).unwrap() = value;
        assert_eq!(server.post("/v1/scenes", &wrong).await.problem(422)["pointer"], at);
    }
    let mut wrong = scene(&id);
    wrong["normal_map"] = json!({"image": id, "height": 1});
    let problem = server.post("/v1/scenes", &wrong).await.problem(400);
    assert_eq!(problem["pointer"], "/normal_map/height");
}

#[tokio::test(flavor = "multi_thread")]
async fn pictures_and_lineage_files_have_the_images_of_the_scene() {
    let server = TestServer::start();
    let id = upload(&server).await;
    let render = async |scene: &Value, genome: &'static str| {
        let stored = server.post("/v1/scenes", scene).await.expect(201).json();
        let path = format!("/v1/render.png?size=48&scene={}", text_of(&stored["id"]));
        server.post_bytes(&path, TEXT, genome).await.expect(200).picture()
    };
    let grey = "brood 1\n.model lambert\nalbedo 0.5 0.5 0.5\n";
    let toon = "brood 1\n.effect light\npalette #000000 #ffffff\nbasis step\n";
    for genome in [grey, toon] {
        let bumpy = render(&scene(&id), genome).await;
        assert_eq!(bumpy.get_pixel(0, 0).0, LEFT);
        for at in ["/normal_map", "/objects/0/normal_map", "/ground/normal_map"] {
            let mut smooth = scene(&id);
            let parent = at.trim_end_matches("/normal_map");
            let parent = smooth.pointer_mut(parent).unwrap().as_object_mut().unwrap();
            parent.remove("normal_map");
            assert_ne!(render(&smooth, genome).await, bumpy, "{at}");
        }
    }

    let stored = server.post("/v1/scenes", &scene(&id)).await.expect(201).json();
    let body =
        json!({"name": "bumps", "start": "models", "scene": stored["id"], "thumbnail_px": 48});
    let lineage = TestLineage::with(&server, body).await;
    let bred = lineage.breed(json!({"parents": [], "seed": 1, "count": 2})).await;
    let thumbnail = text_of(&bred["individuals"][0]["thumbnail"]);
    let picture = server.get(&thumbnail).await.expect(200).picture();
    assert_eq!(picture.get_pixel(0, 0).0, LEFT);
    let file = server.get(&lineage.path("/file")).await.expect(200).json();
    assert_eq!(file["light_assets"].as_array().unwrap().len(), 1, "once");

    let other = TestServer::start();
    let mut without = file.clone();
    without["light_assets"] = json!([]);
    let problem = other.post("/v1/lineages/import", &without).await.problem(422);
    assert_eq!(problem["pointer"], "/scene/backdrop/image", "{problem}");
    let copy = other.post("/v1/lineages/import", &file).await.expect(201).json();
    let path = format!("/v1/lineages/{}/generations", text_of(&copy["id"]));
    let listed = other.get(&path).await.expect(200).json();
    let thumbnail = text_of(&listed["items"][0]["individuals"][0]["thumbnail"]);
    assert_eq!(other.get(&thumbnail).await.expect(200).picture(), picture);
}

#[test]
fn command_line_reads_images_beside_the_scene() {
    let folder = TempDir::new().unwrap();
    let here = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let grey = "brood 1\n.model lambert\nalbedo 0.5 0.5 0.5\n";
    std::fs::write(here("grey.brood"), grey).unwrap();
    std::fs::write(here("scene.json"), scene("bumps.png").to_string()).unwrap();
    let (genome, file, out) = (here("grey.brood"), here("scene.json"), here("out.png"));
    let render =
        ["render", &genome, "--scene", &file, "--size", "48", "--backend", "cpu", "-o", &out];
    let failed = brood(render);
    assert!(failed.code == 1 && failed.stderr.contains("bumps.png"), "{}", failed.stderr);
    std::fs::write(here("bumps.png"), png()).unwrap();
    brood(render).success();
    assert_eq!(image::open(&out).unwrap().into_rgba8().get_pixel(0, 0).0, LEFT);
}
