//! Reproducibility: one script on empty data directories gives the same materials and pictures,
//! byte for byte, on every run and every backend.

use brood_tests::{ServerOptions, TestLineage, TestServer, hashes, ids, text_of};
use serde_json::{Value, json};

/// Wedge with texture coordinates, so that the mesh needs tangents.
const WEDGE: &str = "\
v -1 -1 -1
v 1 -1 -1
v 1 -1 1
v -1 -1 1
v -1 0.5 -1
v 1 0.8 -1
vt 0 0
vt 1 0
vt 1 1
vt 0 1
f 1/1 2/2 3/3 4/4
f 4/1 3/2 6/3 5/4
f 2/1 1/2 5/3 6/4
f 3/1 2/2 6/3
f 1/1 4/2 5/3
";

/// Results of a script: hashes by generation, and the bytes of every picture by name.
#[derive(PartialEq)]
struct Seen {
    hashes: Vec<Vec<String>>,
    pictures: Vec<(String, Vec<u8>)>,
}

/// Uploads an object, breeds three generations by mutation and one by recombination, and fetches
/// all pictures.
async fn script(server: &TestServer) -> Seen {
    let mesh = server.post_bytes("/v1/meshes", "model/obj", WEDGE).await.expect(201).json();
    let scene = json!({"mesh": mesh["id"], "rotation_deg": [10, 40, 0]});
    let scene = server.post("/v1/scenes", &scene).await.expect(201).json();
    let body = json!({
        "name": "script", "thumbnail_px": 64, "scene": scene["id"], "saturation": 0.65,
        "dialect": {"opcodes": "extended", "registers": 10},
    });
    let lineage = TestLineage::with(server, body).await;
    let mut generations: Vec<Value> = Vec::new();
    for number in 0..4 {
        let child = |back: usize, slot: usize| ids(&generations[number - back])[slot].clone();
        let parents = match number {
            0 => Vec::new(),
            3 => vec![child(1, 6), child(2, 11)],
            _ => vec![child(1, 4)],
        };
        let body = json!({"parents": parents, "seed": 42 + number, "mutation": 0.4});
        generations.push(lineage.breed(body).await);
    }
    let mut pictures = Vec::new();
    for generation in &generations {
        let mut shown: Vec<&Value> = generation["individuals"].as_array().unwrap().iter().collect();
        shown.extend(Some(&generation["centre"]).filter(|centre| !centre.is_null()));
        for individual in shown {
            let answer = server.get(&text_of(&individual["thumbnail"])).await.expect(200);
            pictures.push((format!("thumbnail of {}", individual["hash"]), answer.body));
        }
        let path = format!("/v1/generations/{}/sheet.png", text_of(&generation["id"]));
        let name = format!("sheet {}", generation["index"]);
        pictures.push((name, server.get(&path).await.expect(200).body));
    }
    let last = &generations[3]["individuals"][0];
    for kind in ["png", "exr"] {
        let path = format!(
            "/v1/individuals/{}/render.{kind}?size=80&samples=4&light_deg=30",
            text_of(&last["id"])
        );
        pictures.push((kind.to_owned(), server.get(&path).await.expect(200).body));
    }
    Seen { hashes: generations.iter().map(hashes).collect(), pictures }
}

async fn run_on(backend: &'static str) -> Seen {
    let options = ServerOptions { backend, ..ServerOptions::default() };
    let server = TestServer::start_with(options);
    let seen = script(&server).await;
    let system = server.get("/v1/system").await.expect(200).json();
    if system["backend"]["name"] != backend {
        // Without a driver the worker reports so and uses the CPU; with a driver it must use the
        // GPU.
        let required = std::env::var_os("BROOD_REQUIRE_GPU").is_some();
        assert!(!required, "asked for {backend}, used {}", system["backend"]);
        println!("no adapter: compared the fallback ({})", system["backend"]["reason"]);
    }
    seen
}

fn assert_same(one: &Seen, other: &Seen) {
    assert_eq!(one.hashes, other.hashes);
    assert_eq!(one.pictures.len(), other.pictures.len());
    for (one, other) in one.pictures.iter().zip(&other.pictures) {
        assert_eq!(one.0, other.0);
        assert!(one.1 == other.1, "{} differs", one.0);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn script_gives_the_same_results_when_run_twice_on_empty_data() {
    let (one, other) = (run_on("cpu").await, run_on("cpu").await);
    assert_eq!(one.hashes.iter().map(Vec::len).collect::<Vec<_>>(), [20; 4]);
    // 20 children in each generation, the centre in three, a sheet in each, two larger pictures.
    assert_eq!(one.pictures.len(), 4 * 20 + 3 + 4 + 2);
    assert_same(&one, &other);
}

#[tokio::test(flavor = "multi_thread")]
async fn script_gives_the_same_bytes_when_run_on_the_gpu() {
    assert_same(&run_on("cpu").await, &run_on("gpu").await);
}
