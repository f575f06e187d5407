//! Energy limit and inspection: from the lineage's default to pictures and exports.

use brood_tests::{TestLineage, TestServer, hashes, ids, text_of};
use serde_json::{Value, json};

async fn inspection(server: &TestServer, id: &str) -> Value {
    server.get(&format!("/v1/individuals/{id}/inspection")).await.expect(200).json()
}

#[tokio::test(flavor = "multi_thread")]
async fn limit_reaches_children_genomes_exports_and_the_inspection() {
    let server = TestServer::start();
    let free = TestLineage::new(&server).await;
    let body = json!({"name": "held", "thumbnail_px": 32, "energy_limit": true});
    let held = TestLineage::with(&server, body).await;
    let (bright, limited) = (free.random(5).await, held.random(5).await);
    assert_eq!((&bright["energy_limit"], &limited["energy_limit"]), (&json!(false), &json!(true)));
    let mut held_back = 0;
    for slot in 0..4 {
        let (before, after) = (&ids(&bright)[slot], &ids(&limited)[slot]);
        let (before_hash, after_hash) = (&hashes(&bright)[slot], &hashes(&limited)[slot]);
        assert_ne!(before_hash, after_hash);
        let request = server.request(reqwest::Method::GET, &format!("/v1/genomes/{after_hash}"));
        let text = server.send(request.header("accept", "text/x-brood")).await.expect(200).text();
        assert!(text.contains("\n.limit on\n"), "{text}");
        let (before, after) = (inspection(&server, before).await, inspection(&server, after).await);
        let albedo = |of: &Value| of["energy"]["max_albedo"].as_f64().unwrap();
        assert_eq!(before["energy"]["max_albedo"], after["energy"]["unlimited_albedo"]);
        assert!(albedo(&after) <= 1.0, "{after}");
        assert_eq!(after["energy"]["limited"], json!(true));
        if albedo(&before) > 1.001 {
            held_back += 1;
            assert_ne!(before["program_hash"], after["program_hash"]);
            let max = |of: &Value| of["physics"]["max_f"].as_f64().unwrap();
            let divisor = after["energy"]["divisor"].as_f64().unwrap();
            assert!((max(&before) / divisor / max(&after) - 1.0).abs() < 1e-5);
        } else {
            assert_eq!(before["program_hash"], after["program_hash"]);
        }
    }
    assert!(held_back > 0, "at least one of four random materials reflects more than it receives");
    // A child of a limited parent is limited too, unless requested otherwise.
    let parent = &ids(&limited)[0];
    let kept = held.breed(json!({"parents": [parent], "count": 1, "seed": 1})).await;
    let loose = json!({"parents": [parent], "count": 1, "seed": 1, "energy_limit": false});
    let loose = held.breed(loose).await;
    let is_limited = async |generation: &Value| {
        inspection(&server, &ids(generation)[0]).await["energy"]["limited"].clone()
    };
    assert_eq!(is_limited(&kept).await, json!(true));
    assert_eq!(is_limited(&loose).await, json!(false));
    // The lineage's default may change; existing individuals stay as they are.
    let tag = held.server.get(&held.path("")).await.expect(200).header("etag");
    let patched = server.patch(&held.path(""), Some(&tag), &json!({"energy_limit": false})).await;
    assert_eq!(patched.expect(200).json()["energy_limit"], json!(false));
    assert_eq!(held.random(5).await["energy_limit"], json!(false));
    assert_eq!(is_limited(&limited).await, json!(true));
}

#[tokio::test(flavor = "multi_thread")]
async fn inspection_lists_live_code_and_dependencies() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let generation = lineage.random(7).await;
    let id = &ids(&generation)[0];
    let told = inspection(&server, id).await;
    assert_eq!(text_of(&told["hash"]), hashes(&generation)[0]);
    let live = told["live"].as_array().unwrap();
    assert_eq!(live.len(), 100);
    let count = live.iter().filter(|live| **live == json!(true)).count();
    assert_eq!(json!(count), generation["individuals"][0]["live_instructions"]);
    for (live, channels) in live.iter().zip(told["channels"].as_array().unwrap()) {
        assert_eq!(
            live == &json!(true),
            channels != &json!(""),
            "an instruction is live if a channel depends on it"
        );
    }
    assert_eq!(told["physics"]["not_reciprocal"], json!(0));
    assert_eq!(told["physics"]["non_finite"], json!(0));
    let planes = told["planes"].as_array().unwrap();
    let angles = planes[0]["theta_o_deg"].as_array().unwrap().len();
    assert_eq!(planes[0]["curves"][0]["f"][2].as_array().unwrap().len(), angles);
    assert!(text_of(&told["source"]).lines().count() > 100);
    let slice = server.get(&format!("/v1/individuals/{id}/slice.png?size=48")).await.expect(200);
    assert_eq!(slice.picture().dimensions(), (48, 48));
    server.get(&format!("/v1/individuals/{id}/slice.png?size=8")).await.problem(400);
    let unknown = "0197f3c0-0000-7000-8000-000000000000";
    server.get(&format!("/v1/individuals/{unknown}/inspection")).await.problem(404);
}

#[tokio::test(flavor = "multi_thread")]
async fn limits_and_locks_travel_with_a_lineage_file() {
    let server = TestServer::start();
    let body = json!({"name": "held", "thumbnail_px": 32, "energy_limit": true});
    let lineage = TestLineage::with(&server, body).await;
    let first = lineage.random(1).await;
    let locks = json!({"instructions": [3, 40], "constants": [7], "channels": ["g"]});
    let asked = json!({"parents": [ids(&first)[0]], "count": 3, "seed": 2, "locks": locks});
    let second = lineage.breed(asked).await;
    assert_eq!(second["locks"], locks);
    let file = server.get(&lineage.path("/file")).await.expect(200).json();
    let other = TestServer::start();
    let there = other.post("/v1/lineages/import", &file).await.expect(201).json();
    assert_eq!(there["energy_limit"], json!(true));
    let path = format!("/v1/lineages/{}/generations", text_of(&there["id"]));
    let list = other.get(&path).await.expect(200).json();
    assert_eq!(hashes(&list["items"][1]), hashes(&second));
    assert_eq!(list["items"][1]["locks"], locks);
    assert_eq!(list["items"][0]["energy_limit"], json!(true));
    // Pictures depend only on the program: bit for bit the same, limited or not.
    let url = |it: &Value| text_of(&it["individuals"][1]["thumbnail"]);
    let here = server.get(&url(&second)).await.expect(200).body;
    assert_eq!(other.get(&url(&list["items"][1])).await.expect(200).body, here);
    let mut broken = file.clone();
    broken["generations"][1]["locks"]["instructions"] = json!([100]);
    let problem = other.post("/v1/lineages/import", &broken).await.problem(422);
    assert_eq!(problem["pointer"], "/generations/1/locks/instructions/0");
}

#[tokio::test(flavor = "multi_thread")]
async fn export_is_limited_like_the_genome_or_as_requested() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let text = "brood 1\n.dialect paper smooth registers 7\n.const C0 2 1 0 0\nMOV R0, C0\n";
    let saved = server.post_bytes("/v1/genomes", "text/x-brood", text).await.expect(201).json();
    let adopted = json!({"genomes": [saved["hash"]]});
    let made = server.post(&lineage.path("/adoptions"), &adopted).await.expect(201).json();
    let path = format!("/v1/individuals/{}/exports/wgsl", ids(&made)[0]);
    let export = async |query: &str| server.get(&format!("{path}{query}")).await.expect(200).text();
    let (free, held) = (export("").await, export("?energy_limit=true").await);
    assert_eq!(export("?energy_limit=false").await, free);
    assert_ne!(free, held);
    // f is 4 in red, so it is divided by 4 pi: the scale is 1 / (4 pi).
    assert!(held.contains("0.0795"), "{held}");
    server.get(&format!("{path}?energy_limit=yes")).await.problem(400);
}
