//! Comparisons over HTTP: values equal to the command's, pictures, and refused requests.

use brood_tests::{TestServer, brood, text_of};
use serde_json::{Value, json};
use tempfile::TempDir;

/// Returns the text of a preset.
fn text(name: &str) -> String {
    brood(["preset", name]).success().stdout
}

/// Adopts presets into a lineage; returns the ids of the individuals.
async fn adopted(server: &TestServer, presets: &[&str]) -> Vec<String> {
    let new = json!({"name": "compared", "thumbnail_px": 32});
    let lineage = server.post("/v1/lineages", &new).await.expect(201).json();
    let path = format!("/v1/lineages/{}/adoptions", text_of(&lineage["id"]));
    let made = server.post(&path, &json!({ "presets": presets })).await.expect(201).json();
    made["individuals"].as_array().unwrap().iter().map(|one| text_of(&one["id"])).collect()
}

/// Asserts that two documents are equal up to the last bits of their numbers.
fn same(a: &Value, b: &Value, place: &str) {
    match (a, b) {
        (Value::Number(a), Value::Number(b)) => {
            let (a, b) = (a.as_f64().unwrap(), b.as_f64().unwrap());
            assert!((a - b).abs() <= 1e-9 * a.abs().max(1.0), "{place}: {a} and {b}");
        }
        (Value::Array(a), Value::Array(b)) => {
            assert_eq!(a.len(), b.len(), "{place}");
            a.iter()
                .zip(b)
                .enumerate()
                .for_each(|(at, (a, b))| same(a, b, &format!("{place}/{at}")));
        }
        (Value::Object(a), Value::Object(b)) => {
            assert!(a.keys().eq(b.keys()), "{place}: {a:?} and {b:?}");
            a.iter().for_each(|(key, value)| same(value, &b[key], &format!("{place}/{key}")));
        }
        _ => assert_eq!(a, b, "{place}"),
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn comparison_has_the_values_of_the_command() {
    let presets = ["model-gold", "red-plastic", "model-two-layers"];
    let folder = TempDir::new().unwrap();
    let files = presets.map(|name| {
        let path = folder.path().join(format!("{name}.brood"));
        std::fs::write(&path, text(name)).unwrap();
        path.to_string_lossy().into_owned()
    });
    let out = folder.path().join("out").to_string_lossy().into_owned();
    let arguments = ["--size", "48", "--backend", "cpu", "--json", "-o", &out];
    let all = [&["compare", &files[0], &files[1], &files[2]][..], &arguments[..]].concat();
    let command: Value = serde_json::from_str(&brood(all).success().stdout).unwrap();

    let server = TestServer::start();
    let ids = adopted(&server, &presets).await;
    let path = format!("/v1/comparison?materials={}&size=48", ids.join(","));
    let answer = server.get(&path).await.expect(200);
    let found = answer.json();
    same(&found["exposure_ev"], &command["exposure_ev"], "exposure_ev");
    for (index, id) in ids.iter().enumerate() {
        let (one, other) = (&found["materials"][index], &command["materials"][index]);
        assert_eq!(text_of(&one["material"]), *id);
        for part in ["curves", "phenomena"] {
            same(&one[part], &other[part], &format!("{index}/{part}"));
        }
        for part in ["rmse", "flip"] {
            same(&one["difference"][part], &other["difference"][part], &format!("{index}/{part}"));
        }
        let of_command = |what: &str| {
            image::open(folder.path().join(format!("out/{index:02}-{what}.png")))
                .unwrap()
                .to_rgba8()
        };
        let pictures = [("picture", &one["picture"]), ("other-light", &one["other_light"])];
        let apart = [("difference", &one["difference"]["picture"])];
        for (what, place) in pictures.into_iter().chain(apart.into_iter().take(index.min(1))) {
            let picture = server.get(&text_of(place)).await.expect(200).picture();
            assert_eq!(picture, of_command(what), "{index}: {what}");
        }
    }
    assert!(found["materials"][0]["difference"].is_null());
    assert_eq!(found["materials"][2]["layers"], json!(["lambert", "ward", "cook-torrance"]));
    let tag = answer.header("etag");
    let again = server.request(reqwest::Method::GET, &path).header("if-none-match", tag);
    assert!(server.send(again).await.expect(304).body.is_empty());
}

#[tokio::test(flavor = "multi_thread")]
async fn saved_genomes_are_compared_in_the_default_scene_and_in_any_other() {
    let server = TestServer::start();
    let mut hashes = Vec::new();
    for name in ["model-gold", "model-clay"] {
        let saved = server.post_bytes("/v1/genomes", "text/x-brood", text(name)).await.expect(201);
        hashes.push(text_of(&saved.json()["hash"]));
    }
    let path = format!("/v1/comparison?materials={}&size=32", hashes.join(","));
    let found = server.get(&path).await.expect(200).json();
    assert_eq!(found["materials"][1]["hash"], json!(hashes[1]));
    let fixed = json!({"mesh": "knob", "film": {"exposure": 1.5}});
    let scene = server.post("/v1/scenes", &fixed).await.expect(201).json();
    let elsewhere = format!("{path}&scene={}", text_of(&scene["id"]));
    let elsewhere = server.get(&elsewhere).await.expect(200).json();
    assert_eq!((&elsewhere["exposure_ev"], &elsewhere["scene"]), (&json!(1.5), &scene["id"]));
    assert_ne!(elsewhere["materials"][0]["picture"], found["materials"][0]["picture"]);
    let curves = |found: &Value| found["materials"][0]["curves"].clone();
    assert_eq!(curves(&elsewhere), curves(&found), "the curves do not depend on the scene");
}

#[tokio::test(flavor = "multi_thread")]
async fn comparison_is_refused_with_a_reason_when_a_parameter_is_invalid() {
    let server = TestServer::start();
    let ids = adopted(&server, &["gold", "satin"]).await;
    let (one, two) = (&ids[0], ids.join(","));
    let unknown = "00000000-0000-7000-8000-000000000000";
    let hash = "0".repeat(64);
    for (query, status, words) in [
        (format!("materials={one}"), 400, "2 to 6 items, got 1"),
        (format!("materials={}", [one.as_str(); 7].join(",")), 400, "2 to 6 items, got 7"),
        ("materials=".to_owned(), 400, "2 to 6"),
        ("size=64".to_owned(), 400, "materials"),
        (format!("materials={one},gold"), 400, "neither an individual's id nor a genome hash"),
        (format!("materials={one},{unknown}"), 404, unknown),
        (format!("materials={hash},{one}"), 404, &hash[..32]),
        (format!("materials={two}&scene={unknown}"), 404, "nothing"),
        (format!("materials={two}&size=8"), 400, "16 to 1024"),
        (format!("materials={two}&light=3"), 400, "light"),
    ] {
        let problem = server.get(&format!("/v1/comparison?{query}")).await.problem(status);
        let detail = text_of(&problem["detail"]);
        assert!(detail.contains(words), "{query}: {detail}");
    }
    let three = format!("/v1/comparison/difference.png?materials={two},{one}");
    let problem = server.get(&three).await.problem(400);
    assert!(text_of(&problem["detail"]).contains("must be exactly 2"), "{problem}");
}
