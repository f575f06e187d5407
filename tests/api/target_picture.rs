//! Image targets: analysis of the picture, searches, independence from what they were made of, and
//! refused uploads.

use std::f64::consts::{PI, TAU};
use std::fmt::Write;
use std::io::Cursor;

use brood_tests::{TestLineage, TestServer, brood, ids, text_of};
use reqwest::Method;
use serde_json::{Value, json};

const SIDE: u32 = 64;
const LEGEND: [(&str, [u8; 3]); 9] = [
    ("used", [0x4c, 0xaf, 0x50]),
    ("masked", [0x00, 0x00, 0x00]),
    ("background", [0x30, 0x36, 0x3d]),
    ("edge", [0xff, 0xb3, 0x00]),
    ("clipped", [0xe5, 0x39, 0x35]),
    ("grazing", [0x8e, 0x24, 0xaa]),
    ("half_lit", [0x1e, 0x88, 0xe5]),
    ("several_lights", [0x00, 0xac, 0xc1]),
    ("unlit", [0x6d, 0x4c, 0x41]),
];

/// Returns an OBJ ball of 24 by 48 quadrilaterals.
fn ball() -> String {
    let (rows, columns) = (24, 48);
    let mut text = String::new();
    for row in 0..=rows {
        for column in 0..columns {
            let (theta, phi) = (
                PI * f64::from(row) / f64::from(rows),
                TAU * f64::from(column) / f64::from(columns),
            );
            let ((st, ct), (sp, cp)) = (theta.sin_cos(), phi.sin_cos());
            for kind in ["v", "vn"] {
                writeln!(text, "{kind} {} {ct} {}", st * sp, st * cp).unwrap();
            }
        }
    }
    let corner = |row: i32, column: i32| 1 + row * columns + column % columns;
    for row in 0..rows {
        for column in 0..columns {
            let corners = [(0, 0), (1, 0), (1, 1), (0, 1)];
            let face = corners.map(|(down, right)| {
                let corner = corner(row + down, column + right);
                format!("{corner}//{corner}")
            });
            writeln!(text, "f {}", face.join(" ")).unwrap();
        }
    }
    text
}

/// Returns a scene with a directional light and a distant camera.
fn scene(mesh: &str, direction: [f64; 3]) -> Value {
    json!({
        "mesh": mesh, "camera": {"orthographic": 1.1},
        "lights": [{"kind": "directional", "direction": direction}], "film": {"exposure": -1},
    })
}

/// Renders a plastic ball in this scene; returns the individual's id and its linear picture.
async fn photographed(server: &TestServer, scene: &Value) -> (String, Vec<u8>) {
    photographed_in(server, scene, &SIDE.to_string()).await
}

/// As [`photographed`], in another size.
pub async fn photographed_in(server: &TestServer, scene: &Value, size: &str) -> (String, Vec<u8>) {
    let stored = server.post("/v1/scenes", scene).await.expect(201).json();
    let body =
        json!({"name": "studio", "scene": stored["id"], "thumbnail_px": 32, "energy_limit": false});
    let lineage = TestLineage::with(server, body).await;
    let presets = json!({"presets": ["model-plastic"]});
    let made = server.post(&lineage.path("/adoptions"), &presets).await.expect(201).json();
    let individual = ids(&made)[0].clone();
    let path = format!("/v1/individuals/{individual}/render.exr?size={size}&samples=1");
    (individual, server.get(&path).await.expect(200).body)
}

async fn upload_ball(server: &TestServer) -> String {
    let mesh = server.post_bytes("/v1/meshes", "model/obj", ball()).await.expect(201).json();
    text_of(&mesh["id"])
}

fn encoded(side: (u32, u32), pixel: impl Fn(u32, u32) -> [f32; 3]) -> Vec<u8> {
    let picture = image::Rgb32FImage::from_fn(side.0, side.1, |x, y| image::Rgb(pixel(x, y)));
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, image::ImageFormat::OpenExr).unwrap();
    bytes.into_inner()
}

/// Returns a square mask whose left half is white.
fn left_half(side: u32) -> Vec<u8> {
    left_half_of(side, side)
}

fn left_half_of(width: u32, height: u32) -> Vec<u8> {
    let picture = image::GrayImage::from_fn(width, height, |x, _| {
        image::Luma([if x < width / 2 { 255 } else { 0 }])
    });
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

fn is_done(job: &Value) -> bool {
    ["succeeded", "failed", "cancelled"].iter().any(|state| job["state"] == *state)
}

async fn searched(server: &TestServer, target: &Value) -> Value {
    let body = json!({
        "kind": "fit", "target": target["id"], "threads": 1, "generations": 2, "strategy": "lobes",
    });
    let id = text_of(&server.post("/v1/jobs", &body).await.expect(202).json()["id"]);
    let job = server.job_once(&id, is_done).await;
    assert_eq!(job["state"], "succeeded", "{job}");
    job
}

#[tokio::test(flavor = "multi_thread")]
async fn material_is_recovered_from_a_picture_of_an_uploaded_mesh() {
    let mut server = TestServer::start();
    let mesh = upload_ball(&server).await;
    let scene = scene(&mesh, [-1.0, -1.0, -1.5]);
    let (individual, picture) = photographed(&server, &scene).await;
    let spec = json!({"kind": "image", "name": "plastic", "scene": scene, "samples": 1});
    let answer = server.post_target(&spec, &picture).await.expect(201);
    let (place, target) = (answer.header("location"), answer.json());
    let view = &target["views"][0];
    assert_eq!((&view["size_px"], &view["samples"]), (&json!(SIDE), &json!(1)));
    assert_eq!((&view["gain_solved"], &view["held_out"]), (&json!(false), &json!(false)));
    assert_eq!((&view["scene"]["mesh"], &view["scene"]["scale"]), (&json!(mesh), &json!(1.0)));
    assert_eq!(
        (&view["clip_from"], &view["clipped_from"]),
        (&json!("auto"), &json!([null, null, null]))
    );
    let count = |name: &str| view["pixels"][name].as_u64().unwrap();
    assert!(count("used") > 800 && count("edge") > 50 && count("unlit") > 50, "{view}");
    assert_eq!(target["samples"], view["pixels"]["used"]);
    // The strategy if none is chosen: models, or one that continues from programs.
    for (start, strategy) in [(json!([]), "analytic"), (json!([individual]), "hybrid")] {
        let body = json!({"kind": "fit", "target": target["id"], "generations": 1, "start": start});
        let job = server.post("/v1/jobs", &body).await.expect(202).json();
        assert_eq!(job["strategy"], strategy);
        server.job_once(&text_of(&job["id"]), is_done).await;
    }
    // Its pictures.
    let shown = server.get(&format!("{place}/views/0/picture.png")).await.expect(200);
    assert_eq!(shown.header("cache-control"), "private, max-age=31536000, immutable");
    let request = server.request(Method::GET, &format!("{place}/views/0/picture.png"));
    let request = request.header("if-none-match", shown.header("etag"));
    assert_eq!(server.send(request).await.status, 304);
    let shown = shown.picture();
    let pixels = server.get(&format!("{place}/views/0/pixels.png")).await.expect(200).picture();
    for (name, color) in LEGEND {
        let of = pixels.pixels().filter(|pixel| pixel.0[..3] == color).count() as u64;
        assert_eq!(of, count(name), "{name}");
    }
    assert_eq!(LEGEND.map(|(name, _)| count(name)).iter().sum::<u64>(), u64::from(SIDE * SIDE));
    let grey = server.get(&format!("{place}/views/0/scene.png")).await.expect(200).picture();
    let is_framed = |(grey, shown): (&image::Rgba<u8>, &image::Rgba<u8>)| {
        grey.0[3] == 255 && grey.0[0] > 60 && shown.0[0] == 0
    };
    assert_eq!(grey.pixels().zip(shown.pixels()).filter(|pair| is_framed(*pair)).count(), 0);
    let problem = server.get(&format!("{place}/views/0/mask.png")).await.problem(404);
    assert!(text_of(&problem["detail"]).contains("no mask"), "{problem}");
    server.get(&format!("{place}/views/1/picture.png")).await.problem(404);

    // The original material, rendered in the target's scene.
    let over = format!("/v1/individuals/{individual}/render.png?target={}", text_of(&target["id"]));
    let over_it = server.get(&over).await.expect(200).picture();
    let whole = over_it.pixels().zip(shown.pixels()).filter(|(over, _)| over.0[3] == 255);
    for (over, shown) in whole {
        assert!(over.0[..3].iter().zip(&shown.0).all(|(a, b)| a.abs_diff(*b) <= 1), "{over:?}");
    }
    let large = server.get(&format!("{over}&view=0&size=96&samples=1")).await.expect(200);
    assert_eq!(large.picture().dimensions(), (96, 96));
    let own = server.get(&format!("{place}/render.png")).await.expect(200).picture();
    assert_eq!(own, shown);
    for (path, status) in [
        (format!("{place}/render.png?light_deg=10"), 422),
        (format!("{place}/render.png?size=200"), 422),
        (format!("{place}/render.png?exposure_ev=1"), 422),
        (format!("{over}&light_deg=10"), 422),
        (format!("{over}&view=1"), 404),
        (format!("{over}&area=0,0,4,4"), 400),
        (format!("/v1/individuals/{individual}/render.png?view=0"), 400),
    ] {
        server.get(&path).await.problem(status);
    }

    let job = searched(&server, &target).await;
    let found = &job["best"]["views"];
    assert_eq!(found.as_array().unwrap().len(), 1, "{job}");
    let number = |name: &str| found[0][name].as_f64().unwrap();
    assert!(number("rmse") < 0.01 && number("flip") < 0.05, "{found}");
    assert_eq!((number("gain"), &found[0]["held_out"]), (1.0, &json!(false)));
    let path = format!("/v1/jobs?lineage={}", text_of(&job["lineage"]));
    assert_eq!(server.get(&path).await.expect(200).json()["items"], json!([job]));
    let other = format!("/v1/jobs?lineage={}", text_of(&target["id"]));
    assert_eq!(server.get(&other).await.expect(200).json()["items"], json!([]));

    // The target works after a restart and without the files that it was made of.
    assert_eq!(server.terminate(), 0);
    server.restart();
    assert_eq!(server.get(&place).await.expect(200).json(), target);
    let again = server.get(&format!("{place}/views/0/picture.png")).await.expect(200).picture();
    assert_eq!(again, shown);
    assert_eq!(searched(&server, &target).await["population"], job["population"]);
    server.delete(&place).await.expect(204);
    server.get(&format!("{place}/views/0/picture.png")).await.problem(404);
    server.get(&over).await.problem(404);
}

#[tokio::test(flavor = "multi_thread")]
async fn crop_of_a_picture_is_the_picture_of_its_scene() {
    let server = TestServer::start();
    // The middle of the picture, and the same camera with the height of the crop.
    let whole = scene("sphere", [-1.0, -1.0, -1.5]);
    let mut part = whole.clone();
    part["camera"] = json!({"orthographic": 1.1 * 40.0 / f64::from(SIDE)});
    let (individual, picture) = photographed(&server, &whole).await;
    let spec = json!({"kind": "image", "scene": part, "samples": 1, "crop": [8, 12, 48, 40]});
    let mask = left_half(SIDE);
    let parts: [(&str, &[u8]); 2] = [("file", &picture), ("mask", &mask)];
    let target = server.post_parts(&spec, &parts).await.expect(201).json();
    let view = &target["views"][0];
    assert_eq!((&view["size_px"], &view["crop"]), (&json!([48, 40]), &json!([8, 12, 48, 40])));
    assert_eq!(view["pixels"]["masked"], 24 * 40, "the mask is cropped with the picture");
    let place = format!("/v1/targets/{}", text_of(&target["id"]));
    let shown = server.get(&format!("{place}/views/0/picture.png")).await.expect(200).picture();
    assert_eq!(shown.dimensions(), (48, 40));
    // The material itself in the scene of the crop.
    let over = format!("/v1/individuals/{individual}/render.png?target={}", text_of(&target["id"]));
    let over = server.get(&over).await.expect(200).picture();
    let is_covered = |pixel: &image::Rgba<u8>| pixel.0[3] == 255;
    let pairs = || over.pixels().zip(shown.pixels()).filter(|(over, _)| is_covered(over));
    assert!(pairs().count() > 1000);
    for (over, shown) in pairs() {
        assert!(over.0[..3].iter().zip(&shown.0).all(|(a, b)| a.abs_diff(*b) <= 1), "{over:?}");
    }
    let alone = json!({"kind": "image", "scene": part, "crop": [30, 30, 40, 10]});
    let problem = server.post_target(&alone, &picture).await.problem(422);
    assert_eq!(problem["pointer"], "/crop", "{problem}");
    let words = "the crop 30,30,40,10 must lie within the picture, which has 64 x 64 pixels";
    assert!(text_of(&problem["detail"]).contains(words), "{problem}");
}

#[tokio::test(flavor = "multi_thread")]
async fn wide_and_tall_pictures_are_targets() {
    let mut server = TestServer::start();
    let scene = scene("sphere", [-1.0, -1.0, -1.5]);
    for (width, height) in [(96, 64), (48, 72)] {
        let size = format!("{width}x{height}");
        let (individual, picture) = photographed_in(&server, &scene, &size).await;
        let spec = json!({
            "kind": "image",
            "views": [{"picture": "a", "scene": scene, "samples": 1, "mask": "m"}],
        });
        let turned = left_half_of(height, width);
        let parts: [(&str, &[u8]); 2] = [("a", &picture), ("m", &turned)];
        let problem = server.post_parts(&spec, &parts).await.problem(422);
        assert_eq!(problem["pointer"], "/views/0/mask", "{problem}");
        let both = format!("{height} x {width} pixels and the picture {width} x {height}");
        assert!(text_of(&problem["detail"]).contains(&both), "{problem}");
        let mask = left_half_of(width, height);
        let parts: [(&str, &[u8]); 2] = [("a", &picture), ("m", &mask)];
        let target = server.post_parts(&spec, &parts).await.expect(201).json();
        let view = &target["views"][0];
        assert_eq!(view["size_px"], json!([width, height]));
        assert_eq!(view["pixels"]["masked"], width * height / 2);

        // All pictures have the size of the target.
        let place = format!("/v1/targets/{}", text_of(&target["id"]));
        let mut shown = Vec::new();
        for what in ["picture", "scene", "pixels", "mask"] {
            let path = format!("{place}/views/0/{what}.png");
            let picture = server.get(&path).await.expect(200).picture();
            assert_eq!(picture.dimensions(), (width, height), "{what}");
            shown.push(picture);
        }
        let mask = &shown[3];
        assert!(mask.enumerate_pixels().all(|(x, _, p)| (p.0[0] == 255) == (x < width / 2)));
        let id = text_of(&target["id"]);
        let over = format!("/v1/individuals/{individual}/render.png?target={id}");
        let over_it = server.get(&over).await.expect(200).picture();
        assert_eq!(over_it.dimensions(), (width, height));
        for (over, shown) in over_it.pixels().zip(shown[0].pixels()) {
            let is_same = over.0[..3].iter().zip(&shown.0).all(|(a, b)| a.abs_diff(*b) <= 1);
            assert!(over.0[3] < 255 || is_same, "{over:?} {shown:?}");
        }
        let large = server.get(&format!("{over}&size=120x80")).await.expect(200).picture();
        assert_eq!(large.dimensions(), (120, 80));

        let job = searched(&server, &target).await;
        let found = &job["best"]["views"][0];
        assert!(found["rmse"].as_f64().unwrap() < 0.02, "{found}");
        assert_eq!(server.terminate(), 0);
        server.restart();
        assert_eq!(server.get(&place).await.expect(200).json(), target);
        let again = server.get(&format!("{place}/views/0/picture.png")).await.expect(200);
        assert_eq!(again.picture(), shown[0]);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn several_pictures_make_one_target_with_one_held_out() {
    let server = TestServer::start();
    let (front, side) = (scene("sphere", [-1.0, -1.0, -1.5]), scene("torus", [1.0, -0.5, -1.0]));
    let (_, first) = photographed(&server, &front).await;
    let (individual, second) = photographed(&server, &side).await;
    let stored = server.post("/v1/scenes", &side).await.expect(201).json();
    let spec = json!({"kind": "image", "views": [
        {"picture": "front", "scene": front, "samples": 1, "mask": "half"},
        {"picture": "side", "scene": stored["id"], "samples": 1, "gain": true, "held_out": true},
    ]});
    let mask = left_half(SIDE);
    let parts: [(&str, &[u8]); 3] = [("side", &second), ("front", &first), ("half", &mask)];
    let target = server.post_parts(&spec, &parts).await.expect(201).json();
    let place = format!("/v1/targets/{}", text_of(&target["id"]));
    let views = target["views"].as_array().unwrap();
    assert_eq!(views[0]["pixels"]["masked"], SIDE * SIDE / 2);
    assert_eq!(target["samples"], views[0]["pixels"]["used"], "a held-out picture is not fitted");
    assert_eq!(views[1]["scene"]["mesh"], "torus");
    assert_eq!((&views[1]["gain_solved"], &views[1]["held_out"]), (&json!(true), &json!(true)));
    let shown = server.get(&format!("{place}/views/0/mask.png")).await.expect(200).picture();
    assert!(shown.enumerate_pixels().all(|(x, _, pixel)| (pixel.0[0] == 255) == (x < SIDE / 2)));
    // The original material under an unknown gain is as bright as the picture.
    let over = format!("/v1/individuals/{individual}/render.png?target={}", text_of(&target["id"]));
    let over = server.get(&format!("{over}&view=1")).await.expect(200).picture();
    let wanted = server.get(&format!("{place}/views/1/picture.png")).await.expect(200).picture();
    let whole = over.pixels().zip(wanted.pixels()).filter(|(over, _)| over.0[3] == 255);
    for (over, wanted) in whole {
        assert!(over.0[..3].iter().zip(&wanted.0).all(|(a, b)| a.abs_diff(*b) <= 1), "{over:?}");
    }
    let job = searched(&server, &target).await;
    let found = job["best"]["views"].as_array().unwrap();
    let held: Vec<_> = found.iter().map(|view| view["held_out"].clone()).collect();
    assert_eq!(held, [false, true].map(Value::from));
    let front = server.get(&format!("/v1/jobs/{}/front", text_of(&job["id"]))).await;
    let front = front.expect(200).json();
    let items = front["items"].as_array().unwrap();
    assert!(items.iter().all(|one| one["views"].as_array().is_some_and(|all| all.len() == 2)));
    // The uploaded file is only available to workers.
    let path = format!("/v1/leases/targets/{}", text_of(&target["hash"]));
    server.get(&path).await.problem(401);
}

#[tokio::test(flavor = "multi_thread")]
async fn worker_gets_a_target_file_by_its_hash() {
    let mut server = TestServer::start();
    let scene = scene(&upload_ball(&server).await, [-1.0, -1.0, -1.5]);
    let (_, picture) = photographed(&server, &scene).await;
    let spec = json!({"kind": "image", "scene": scene, "samples": 1});
    let target = server.post_target(&spec, &picture).await.expect(201).json();
    let again = server.post_target(&spec, &picture).await.expect(201).json();
    assert_eq!((&again["hash"], &again["bytes"]), (&target["hash"], &target["bytes"]));
    assert_ne!(again["id"], target["id"]);
    // The other target still has the file.
    server.delete(&format!("/v1/targets/{}", text_of(&again["id"]))).await.expect(204);
    assert_eq!(server.terminate(), 0);
    let data = server.data().to_string_lossy().into_owned();
    let arguments = ["token", "add", "far", "--scope", "work", "--data", data.as_str()];
    let printed = brood(arguments).success().stdout;
    let token = printed.split_whitespace().max_by_key(|word| word.len()).unwrap();
    server.restart();
    let path = format!("/v1/leases/targets/{}", text_of(&target["hash"]));
    let file = server.send(server.request(Method::GET, &path).bearer_auth(token)).await;
    let file = file.expect(200).body;
    assert!(file.len() as u64 > target["bytes"].as_u64().unwrap(), "the whole file and a header");
    assert!(file.windows(picture.len()).any(|part| part == picture));
    let other = format!("/v1/leases/targets/{}", "ab".repeat(32));
    server.send(server.request(Method::GET, &other).bearer_auth(token)).await.problem(404);
}

/// Name, status, pointer and reason of a refusal; picture and scene.
type Row<'a> = (&'a str, u16, &'a str, &'a str, Vec<u8>, &'a Value);

#[tokio::test(flavor = "multi_thread")]
async fn picture_that_does_not_fit_its_scene_is_refused_with_a_reason() {
    let server = TestServer::start();
    let lit = scene("sphere", [-1.0, -1.0, -1.5]);
    let grey = |side: u32| encoded((side, side), |_, _| [0.2; 3]);
    let unknown = "01890000-0000-7000-8000-000000000000";
    let changed = |pointer: &str, value: Value| {
        let mut scene = lit.clone();
        scene[pointer] = value;
        scene
    };
    let nan = encoded((SIDE, SIDE), |x, y| [if (x, y) == (3, 4) { f32::NAN } else { 0.2 }; 3]);
    let past = changed("camera", json!({"eye": [0, 0, 5], "target": [0, 0, 9]}));
    let behind = changed("lights", json!([{"kind": "directional", "direction": [0, 0, 1]}]));
    let lamp = changed("lights", json!([{"kind": "ies", "profile": "ab".repeat(32)}]));
    let strange = changed("colour", json!("red"));
    let far = changed("scale", json!(-1));
    let rows: [Row<'_>; 14] = [
        ("thin", 422, "/file", "64 x 7 pixels is too", encoded((64, 7), |_, _| [0.2; 3]), &lit),
        ("small", 422, "/file", "4 x 4 pixels is too small", grey(4), &lit),
        ("few", 422, "/file", "pixels can be used and 100 are needed: of 64 pixels", grey(8), &lit),
        ("NaN", 422, "/file", "the pixel 3, 4 is not a finite number", nan, &lit),
        ("black", 422, "/file", "reflects nothing", encoded((SIDE, SIDE), |_, _| [0.0; 3]), &lit),
        ("none", 422, "/file", "the picture must be an EXR", b"no picture".to_vec(), &lit),
        ("large", 422, "/file", "at most 4194304", png_head(2049), &lit),
        ("past", 422, "/scene/camera", "sees nothing of the mesh", grey(SIDE), &past),
        ("behind", 422, "/scene/lights", "no light of the scene reaches", grey(SIDE), &behind),
        ("lamp", 422, "/scene/lights/0/profile", "there is no", grey(SIDE), &lamp),
        (
            "mesh",
            422,
            "/scene/mesh",
            "no mesh with this id",
            grey(SIDE),
            &changed("mesh", json!(unknown)),
        ),
        ("scale", 422, "/scene/scale", "", grey(SIDE), &far),
        ("field", 400, "/scene/colour", "unknown field", grey(SIDE), &strange),
        ("id", 422, "/scene", "", grey(SIDE), &json!(unknown)),
    ];
    for (name, status, pointer, words, picture, scene) in rows {
        let spec = json!({"kind": "image", "scene": scene, "samples": 1});
        let problem = server.post_target(&spec, picture).await.problem(status);
        assert_eq!(problem["pointer"], pointer, "{name}: {problem}");
        assert!(text_of(&problem["detail"]).contains(words), "{name}: {problem}");
    }
    let masked = |mask: Vec<u8>| {
        let (server, spec) = (&server, json!({"kind": "image", "scene": lit, "samples": 1}));
        let picture = grey(SIDE);
        async move {
            let parts: [(&str, &[u8]); 2] = [("file", &picture), ("mask", &mask)];
            server.post_parts(&spec, &parts).await.problem(422)
        }
    };
    for (mask, words) in [
        (encoded((SIDE, SIDE), |_, _| [0.0; 3]), "the mask leaves no pixel"),
        (left_half(32), "the mask has 32 x 32 pixels and the picture 64"),
        (b"no mask".to_vec(), "the mask cannot be read"),
    ] {
        let problem = masked(mask).await;
        assert_eq!(problem["pointer"], "/mask", "{problem}");
        assert!(text_of(&problem["detail"]).contains(words), "{problem}");
    }
    let list = server.get("/v1/targets").await.expect(200).json();
    assert_eq!(list["items"], json!([]), "a refused upload stores nothing");
}

/// Returns the header of a PNG without image data.
fn png_head(side: u32) -> Vec<u8> {
    let picture = image::GrayImage::new(side, side);
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

#[tokio::test(flavor = "multi_thread")]
async fn inconsistent_views_are_refused() {
    let server = TestServer::start();
    let lit = scene("sphere", [-1.0, -1.0, -1.5]);
    let picture = encoded((SIDE, SIDE), |_, _| [0.2; 3]);
    let view = |more: Value| {
        let mut view = json!({"picture": "a", "scene": lit, "samples": 1});
        view.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        json!({"kind": "image", "views": [view]})
    };
    let rows = [
        (422, "/views", "1 to 16", json!({"kind": "image", "views": []})),
        (422, "/views", "held out", view(json!({"held_out": true}))),
        (422, "/views/0/picture", "no part b", view(json!({"picture": "b"}))),
        (422, "/views/0/picture", "no part spec", view(json!({"picture": "spec"}))),
        (422, "/views/0/mask", "no part m", view(json!({"mask": "m"}))),
        (422, "/views/0/samples", "1 to 64", view(json!({"samples": 65}))),
        (400, "/views/0/samples", "", view(json!({"samples": 0}))),
        (400, "/views/0/colour", "unknown field", view(json!({"colour": 1}))),
        (422, "/views/0/scene/mesh", "mesh", view(json!({"scene": {"mesh": "blob"}}))),
        (422, "/gain", "for itself", json!({"kind": "image", "gain": true, "views": []})),
        (422, "/samples", "only a picture", json!({"kind": "merl", "samples": 1})),
        (422, "/gain", "only a picture", json!({"kind": "merl", "gain": false})),
        (422, "/clip_from", "only a picture", json!({"kind": "merl", "clip_from": "off"})),
        (422, "/clip_from", "for itself", json!({"kind": "image", "clip_from": 250, "views": []})),
        (422, "/views", "only a picture", json!({"kind": "merl", "views": []})),
        (422, "/crop", "only a picture", json!({"kind": "merl", "crop": [0, 0, 9, 9]})),
        (422, "/crop", "for itself", json!({"kind": "image", "crop": [0, 0, 9, 9], "views": []})),
        (422, "/views/0/crop", "lie within", view(json!({"crop": [0, 0, 65, 64]}))),
        (422, "/views/0/crop", "not be empty", view(json!({"crop": [0, 0, 0, 64]}))),
        (422, "/views/0/crop", "too small", view(json!({"crop": [0, 0, 7, 64]}))),
        (400, "/views/0/crop/2", "", view(json!({"crop": [0, 0, -1, 64]}))),
        (400, "/views/0/crop", "", view(json!({"crop": [0, 0, 64]}))),
    ];
    for (status, pointer, words, spec) in rows {
        let problem = server.post_parts(&spec, &[("a", &picture)]).await.problem(status);
        assert_eq!(problem["pointer"], pointer, "{spec}: {problem}");
        assert!(text_of(&problem["detail"]).contains(words), "{spec}: {problem}");
    }
    let extra: [(&str, &[u8]); 2] = [("a", &picture), ("b", &picture)];
    let problem = server.post_parts(&view(json!({})), &extra).await.problem(400);
    assert!(text_of(&problem["detail"]).contains("there is a part b"), "{problem}");
    server.post_parts(&json!({"kind": "image"}), &[]).await.problem(400);
    let list = server.get("/v1/targets").await.expect(200).json();
    assert_eq!(list["items"], json!([]), "a refused upload stores nothing");
}
