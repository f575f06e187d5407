//! Lights over HTTP: kinds, uploaded profiles and environments, scenes that refer to them, and
//! refused scenes.

use std::io::Cursor;

use brood_tests::{TestServer, text_of};
use serde_json::{Value, json};

/// IES profile: 100 cd straight down, falling to 0 at the horizon.
const PROFILE: &str =
    "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 3 1 1 2 0 0 0\n1 1 60\n0 45 90\n0\n100 60 0\n";

/// EXR environment: blue above, red below.
pub fn environment() -> Vec<u8> {
    let pixel = |_, y| image::Rgb(if y < 4 { [0.1f32, 0.2, 2.0] } else { [0.8, 0.1, 0.0] });
    let picture = image::Rgb32FImage::from_fn(16, 8, pixel);
    let mut bytes = Vec::new();
    picture.write_to(&mut Cursor::new(&mut bytes), image::ImageFormat::OpenExr).unwrap();
    bytes
}

/// Breeds a clay under these lights, in its own lineage; returns the lineage's URL.
async fn clay(server: &TestServer, lights: &Value) -> String {
    let scene =
        json!({"lights": lights, "film": {"tone": "filmic"}, "shadows": true, "mesh": "knob"});
    let scene = server.post("/v1/scenes", &scene).await.expect(201).json();
    let body = json!({"name": "lit", "thumbnail_px": 32, "scene": scene["id"]});
    let lineage = server.post("/v1/lineages", &body).await.expect(201).json();
    let lineage = format!("/v1/lineages/{}", text_of(&lineage["id"]));
    let body = json!({"presets": ["matt-clay"]});
    let made = server.post(&format!("{lineage}/adoptions"), &body).await.expect(201).json();
    let one = &made["individuals"][0];
    server.get(&text_of(&one["thumbnail"])).await.expect(200).picture();
    lineage
}

async fn thumbnail(server: &TestServer, lineage: &str) -> Vec<u8> {
    let generations = server.get(&format!("{lineage}/generations")).await.expect(200).json();
    let individual = &generations["items"][0]["individuals"][0];
    server.get(&text_of(&individual["thumbnail"])).await.expect(200).body
}

#[tokio::test(flavor = "multi_thread")]
async fn scenes_are_lit_by_uploaded_files_which_are_exported_with_their_lineage() {
    let server = TestServer::start();
    let profile = server.post_bytes("/v1/profiles", "application/x-ies", PROFILE).await;
    let profile = profile.expect(201).json();
    assert!((profile["peak_candela"].as_f64().unwrap() - 100.0).abs() < 1e-9, "{profile}");
    assert!((50.0..400.0).contains(&profile["lumens"].as_f64().unwrap()), "{profile}");
    let again = server.post_bytes("/v1/profiles", "application/x-ies", PROFILE).await;
    assert_eq!(again.expect(201).json()["id"], profile["id"]);
    let map = server.post_bytes("/v1/environments", "image/x-exr", environment()).await;
    let map = map.expect(201).json();
    assert!(map["mean_radiance"][2].as_f64() > Some(0.5), "{map}");
    let lamp = json!([{"kind": "ies", "profile": profile["id"], "position": [0, 4, 0]}]);
    let sky = json!([{"kind": "environment", "image": map["id"], "samples": 16}]);
    let (under_lamp, under_sky) = (clay(&server, &lamp).await, clay(&server, &sky).await);
    let pictures = [thumbnail(&server, &under_lamp).await, thumbnail(&server, &under_sky).await];
    assert_ne!(pictures[0], pictures[1]);
    let other = TestServer::start();
    for (lineage, picture) in [(under_lamp, &pictures[0]), (under_sky, &pictures[1])] {
        let file = server.get(&format!("{lineage}/file")).await.expect(200).body;
        let there = other.post_bytes("/v1/lineages/import", "application/json", file).await;
        let id = text_of(&there.expect(201).json()["id"]).to_owned();
        assert_eq!(&thumbnail(&other, &format!("/v1/lineages/{id}")).await, picture);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn environments_have_mean_lights() {
    let server = TestServer::start();
    let map = server.post_bytes("/v1/environments", "image/x-exr", environment()).await;
    let map = map.expect(201).json();
    let path = |name: &str| format!("/v1/environments/{name}/mean");
    let mean = server.get(&path(&text_of(&map["id"]))).await.expect(200).json();
    assert_eq!(mean["radiance"], map["mean_radiance"]);
    let studio = server.get(&path("studio")).await.expect(200).json();
    assert!(studio["direction"][1].as_f64() > Some(0.2), "light from above: {studio}");
    server.get(&path("nowhere")).await.problem(404);
}

#[tokio::test(flavor = "multi_thread")]
async fn built_in_environments_are_named_in_scenes() {
    let server = TestServer::start();
    let mut seen = Vec::new();
    for name in ["studio", "overcast", "low-sun", "interior"] {
        let lights = json!([{"kind": "environment", "image": name, "rotation_deg": 30}]);
        let picture = thumbnail(&server, &clay(&server, &lights).await).await;
        assert!(!seen.contains(&picture), "{name}");
        seen.push(picture);
    }
    let lights = json!([{"kind": "environment", "image": "beach"}]);
    let refused = server.post("/v1/scenes", &json!({"lights": lights})).await.expect(404).json();
    assert_eq!(refused["pointer"], "/lights/0/image", "{refused}");
    let words = text_of(&refused["detail"]);
    assert!(words.contains("studio, overcast, low-sun, interior"), "{words}");
}

#[tokio::test(flavor = "multi_thread")]
async fn lit_spheres_hold_a_material_in_the_environments_of_a_scene() {
    let server = TestServer::start();
    let scene = async |extra: Value| {
        let studio = json!({"kind": "environment", "image": "studio", "fixed": true});
        let mut scene = json!({"lights": [{}, studio]});
        scene.as_object_mut().unwrap().extend(extra.as_object().unwrap().clone());
        server.post("/v1/scenes", &scene).await.expect(201).json()["id"].clone()
    };
    let own = scene(json!({})).await;
    let body = json!({"name": "lit", "thumbnail_px": 32, "scene": own});
    let lineage = server.post("/v1/lineages", &body).await.expect(201).json();
    let adoptions = format!("/v1/lineages/{}/adoptions", text_of(&lineage["id"]));
    let body = json!({"presets": ["matt-clay", "checkered-ceramic"]});
    let made = server.post(&adoptions, &body).await.expect(201).json();
    let path = |slot: usize, query: &str| {
        let id = text_of(&made["individuals"][slot]["id"]).to_owned();
        format!("/v1/individuals/{id}/lit-spheres{query}")
    };
    let file = server.get(&path(0, "?texels=20")).await.expect(200).body;
    assert_eq!((&file[..8], file.len()), (b"broodlit".as_slice(), 24 + 6 * 60 * 60));
    assert_eq!(file[12..20], [20u32.to_le_bytes(), 1u32.to_le_bytes()].concat());
    assert!(file[24..].iter().any(|byte| *byte != 0));
    let whole = server.get(&path(0, "")).await.expect(200).body;
    assert_eq!(whole.len(), 24 + 6 * 144 * 144);
    // Only camera and environments count.
    let turned = scene(json!({"mesh": "torus", "rotation_deg": [10, 20, 30]})).await;
    let query = format!("?texels=20&light_deg=90&scene={}", text_of(&turned));
    assert_eq!(server.get(&path(0, &query)).await.expect(200).body, file);
    let near = scene(json!({"camera": {"fov_y_deg": 60}})).await;
    let query = format!("?texels=20&scene={}", text_of(&near));
    assert_ne!(server.get(&path(0, &query)).await.expect(200).body, file);
    // Those of several turns are the same for all rotations of the environments.
    let turned = server.get(&path(0, "?texels=16&turns=4")).await.expect(200).body;
    assert_eq!(turned.len(), 24 + 6 * 16 * (3 * 16 * 4));
    let studio = json!({"kind": "environment", "image": "studio", "rotation_deg": 70});
    let other = scene(json!({"lights": [{}, studio]})).await;
    let query = format!("?texels=16&turns=4&light_deg=20&scene={}", text_of(&other));
    assert_eq!(server.get(&path(0, &query)).await.expect(200).body, turned);
    // A genome needs not be stored.
    let genome = format!("/v1/genomes/{}", text_of(&made["individuals"][0]["hash"]));
    let genome = server.get(&genome).await.expect(200).json();
    let posted = format!("/v1/lit-spheres?texels=20&scene={}", text_of(&own));
    assert_eq!(server.post(&posted, &genome).await.expect(200).body, file);
    let refused = server.post(&posted, &json!({"red": [1]})).await.expect(422).json();
    assert!(!text_of(&refused["detail"]).is_empty());
    // Textured materials have none, nor have scenes with shadows or without an environment.
    assert!(server.get(&path(1, "")).await.expect(204).body.is_empty());
    for extra in [json!({"shadows": true}), json!({"lights": [{}]})] {
        let query = format!("?scene={}", text_of(&scene(extra).await));
        let refused = server.get(&path(0, &query)).await.expect(422).json();
        assert!(text_of(&refused["detail"]).contains("environments that cast no shadows"));
    }
    let bad = ["?texels=8", "?texels=129", "?texels=many", "?light_deg=nan", "?size=64"];
    for query in bad.into_iter().chain(["?turns=0", "?turns=25", "?texels=128&turns=12"]) {
        server.get(&path(0, query)).await.expect(400);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn lit_angles_hold_the_shadows_of_lights_without_size() {
    let server = TestServer::start();
    let path = async |scene: &Value, query: &str| {
        let scene = server.post("/v1/scenes", scene).await.expect(201).json();
        format!("/v1/scenes/{}/lit-angles?{query}", text_of(&scene["id"]))
    };
    let scene = json!({"mesh": "knob", "shadows": true, "lights": [{}, {"position": [1, 2, 3]}]});
    let file = server.get(&path(&scene, "side=40").await).await.expect(200).body;
    assert_eq!((&file[..8], file.len()), (b"broodang".as_slice(), 20 + 16 * 2 * 40 * 40));
    assert_eq!(file[12..20], [40u32.to_le_bytes(), 2u32.to_le_bytes()].concat());
    // They do not depend on where the lights are on the circle, nor on their strength.
    let mut other = scene.clone();
    other["light_deg"] = json!(70);
    other["lights"][1]["intensity"] = json!(5);
    assert_eq!(server.get(&path(&other, "side=40").await).await.expect(200).body, file);
    other["rotation_deg"] = json!([0, 50, 0]);
    assert_ne!(server.get(&path(&other, "side=40").await).await.expect(200).body, file);
    // A clear subject has them twice; the second time it casts no shadow on itself.
    let clear = server.get(&path(&scene, "side=40&clear=true").await).await.expect(200).body;
    assert_eq!(clear[20..file.len()], file[20..]);
    assert_eq!(clear.len(), file.len() + 16 * 2 * 40 * 40);
    assert_ne!(clear[file.len()..], file[20..]);
    // Nor on materials, but on the other objects.
    let mut among = scene.clone();
    among["ground"] = json!({});
    among["objects"] = json!([{"mesh": "ball", "position": [1, 0, 1], "scale": 0.4}]);
    let beside = server.get(&path(&among, "side=40").await).await.expect(200).body;
    assert_eq!(beside.len(), file.len());
    assert_ne!(beside, file);
    among["ground"]["material"] = json!("gold");
    among["objects"][0]["material"] = json!("paint-toon");
    assert_eq!(server.get(&path(&among, "side=40").await).await.expect(200).body, beside);
    // Where a spot light shines, it has the shadows of a point light.
    let mut spot = scene.clone();
    spot["lights"][1] = json!({"kind": "spot", "position": [1, 2, 3], "falloff_deg": 20});
    assert_eq!(server.get(&path(&spot, "side=40").await).await.expect(200).body, file);
    let mut sun = scene.clone();
    sun["lights"][1] = json!({"kind": "directional", "direction": [-1, -2, -1]});
    let of_sun = server.get(&path(&sun, "side=40").await).await.expect(200).body;
    assert_eq!(of_sun.len(), file.len());
    assert_ne!(of_sun, file);
    sun["lights"][1]["illuminance_lx"] = json!(500);
    assert_eq!(server.get(&path(&sun, "side=40").await).await.expect(200).body, of_sun);
    for (lights, shadows) in [
        (json!([{}]), false),
        (json!([{"kind": "sphere", "position": [0, 3, 3], "radius": 1}]), true),
        (json!([{}, {"kind": "environment", "image": "studio"}]), true),
    ] {
        let scene = json!({"lights": lights, "shadows": shadows});
        let refused = server.get(&path(&scene, "side=40").await).await.expect(422).json();
        assert!(
            text_of(&refused["detail"]).contains("point, spot or directional lights alone"),
            "{refused}"
        );
    }
    for query in ["side=15", "side=1025", "side=many", "", "side=40&light_deg=1"] {
        server.get(&path(&scene, query).await).await.expect(400);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn ray_ends_hold_what_a_clear_subject_shows() {
    let server = TestServer::start();
    let path = async |scene: &Value, query: &str| {
        let scene = server.post("/v1/scenes", scene).await.expect(201).json();
        format!("/v1/scenes/{}/ray-ends?{query}", text_of(&scene["id"]))
    };
    let word = |file: &[u8], at: usize| u32::from_le_bytes(*file[at..].first_chunk().unwrap());
    let scene = json!({"mesh": "sphere", "ground": {}, "backdrop": {"kind": "color",
        "color": [0.1, 0.2, 0.3]}});
    let file = server.get(&path(&scene, "side=40&index=1.5").await).await.expect(200).body;
    assert_eq!((&file[..8], word(&file, 12)), (b"broodend".as_slice(), 40));
    assert_eq!(word(&file, 20), 3, "the subject, the ground, and what is behind");
    let rows: Vec<u32> = (0..3).map(|part| word(&file, 28 + 4 * part)).collect();
    assert!(rows[1] > 0 && rows[2] > 0, "{rows:?}");
    let ends = (word(&file, 16) * rows.iter().sum::<u32>()) as usize;
    assert_eq!(file.len(), 28 + 4 * 3 + 24 * 40 * 40 + 48 * ends);
    // They depend neither on lights nor on materials and what the backdrop shows.
    let mut other = scene.clone();
    other["lights"] = json!([{"kind": "directional"}, {"position": [1, 2, 3]}]);
    other["backdrop"] = json!(null);
    other["ground"]["material"] = json!("gold");
    assert_eq!(server.get(&path(&other, "side=40&index=1.5").await).await.expect(200).body, file);
    assert_ne!(server.get(&path(&scene, "side=40&index=1.33").await).await.expect(200).body, file);
    // With shadows, the angles of both lights follow twice.
    other["shadows"] = json!(true);
    let lit = server.get(&path(&other, "side=40&index=1.5").await).await.expect(200).body;
    assert_eq!((word(&lit, 24), lit.len()), (4, file.len() + 16 * 4 * ends));
    other["lights"] = json!([{"kind": "sphere", "position": [0, 3, 3], "radius": 1}]);
    assert_eq!(server.get(&path(&other, "side=40&index=1.5").await).await.expect(200).body, file);
    other["lights"] = json!(vec![json!({}); 16]);
    other["shadows"] = json!(true);
    let refused = server.get(&path(&other, "side=640&index=1.5").await).await.expect(400).json();
    assert!(text_of(&refused["detail"]).contains("must be 16 to 396"), "{refused}");
    for query in [
        "side=15&index=1.5",
        "side=40&index=2.5",
        "side=40&index=nan",
        "side=40&index=glass",
        "side=40",
        "side=40&index=1.5&light_deg=1",
    ] {
        server.get(&path(&scene, query).await).await.expect(400);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn every_kind_of_light_makes_a_different_picture() {
    let server = TestServer::start();
    let lights = [
        json!({"kind": "point", "position": [2, 2, 3]}),
        json!({"kind": "directional", "direction": [-1, -1, -1]}),
        json!({"kind": "spot", "position": [0, 3, 3]}),
        json!({"kind": "sphere", "position": [0, 3, 3], "radius": 1}),
        json!({"kind": "disk", "position": [0, 3, 3], "radius": 1}),
        json!({"kind": "rectangle", "position": [0, 3, 3]}),
        json!({"kind": "ambient"}),
    ];
    let mut pictures = Vec::new();
    for light in &lights {
        let lineage = clay(&server, &json!([light])).await;
        pictures.push(thumbnail(&server, &lineage).await);
    }
    for (index, picture) in pictures.iter().enumerate() {
        let twin = pictures[..index].iter().position(|other| other == picture);
        assert!(twin.is_none(), "{} and {twin:?}", lights[index]);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn invalid_lights_are_refused_with_a_pointer() {
    let server = TestServer::start();
    let refused = |lights: Value| {
        let server = &server;
        async move {
            let scene = json!({"lights": lights});
            let answer = server.post("/v1/scenes", &scene).await;
            let problem = answer.json();
            assert!(matches!(problem["status"].as_u64(), Some(404 | 422)), "{problem}");
            text_of(&problem["pointer"]).to_owned()
        }
    };
    let unknown = json!({"kind": "ies", "profile": "0".repeat(64)});
    assert_eq!(refused(json!([{}, unknown])).await, "/lights/1/profile");
    let map = server.post_bytes("/v1/environments", "image/x-exr", environment()).await;
    let map = map.expect(201).json();
    assert_eq!(refused(json!([{"kind": "ies", "profile": map["id"]}])).await, "/lights/0/profile");
    let many = json!({"kind": "sphere", "position": [0, 3, 3], "radius": 1, "samples": 256});
    assert_eq!(refused(json!([many, many])).await, "/lights");
    let bad = server.post_bytes("/v1/profiles", "application/x-ies", "no profile").await;
    let problem = bad.expect(422).json();
    assert!(text_of(&problem["detail"]).contains("line 1"), "{problem}");
    server.post_bytes("/v1/environments", "image/x-exr", "no picture").await.expect(422);
    server.post_bytes("/v1/environments", "image/png", environment()).await.expect(415);
}
