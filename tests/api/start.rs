//! Starts of lineages: believable, models, painted, wild.

use brood_tests::{TestLineage, TestServer, hashes, ids, text_of};
use serde_json::{Value, json};

async fn genome(server: &TestServer, hash: &str) -> String {
    let request = server.request(reqwest::Method::GET, &format!("/v1/genomes/{hash}"));
    server.send(request.header("accept", "text/x-brood")).await.expect(200).text()
}

/// Instructions of a genome.
fn code(text: &str) -> Vec<&str> {
    text.lines().filter(|line| !line.starts_with('.')).collect()
}

#[tokio::test(flavor = "multi_thread")]
async fn believable_lineage_draws_limited_programs_that_vary_by_constants() {
    let server = TestServer::start();
    let body = json!({"name": "likely", "thumbnail_px": 32, "start": "believable"});
    let lineage = TestLineage::with(&server, body).await;
    let made = server.get(&lineage.path("")).await.expect(200).json();
    assert_eq!((&made["start"], &made["energy_limit"]), (&json!("believable"), &json!(true)));
    assert_eq!(made["dialect"]["opcodes"], json!("extended"));
    let (first, again) = (lineage.random(4).await, lineage.random(4).await);
    assert_eq!(hashes(&first), hashes(&again), "equal seeds draw equal genomes");
    // Under both switches, all programs have one structure.
    let switches = json!({"isotropic": true, "homogeneous": true});
    let plain = json!({"parents": [], "count": 4, "seed": 1, "constraints": switches});
    let first = lineage.breed(plain).await;
    let parent = genome(&server, &hashes(&first)[0]).await;
    assert!(parent.contains("\n.limit on\n"), "{parent}");
    let breed = json!({"parents": [ids(&first)[0]], "count": 4, "seed": 2});
    let mate = json!({"parents": [ids(&first)[0], ids(&first)[1]], "count": 4, "seed": 2});
    for breed in [breed, mate] {
        for hash in hashes(&lineage.breed(breed).await) {
            let child = genome(&server, &hash).await;
            assert_ne!(child, parent);
            assert_eq!(code(&child), code(&parent), "only constants differ");
        }
    }
    // A saved lineage keeps its start.
    let file = server.get(&lineage.path("/file")).await.expect(200).json();
    assert_eq!(file["start"], json!("believable"));
    let copy = server.post("/v1/lineages/import", &file).await.expect(201).json();
    assert_eq!(copy["start"], json!("believable"));
}

#[tokio::test(flavor = "multi_thread")]
async fn start_and_dialect_follow_from_each_other() {
    let server = TestServer::start();
    let made = async |more: Value| {
        let mut body = json!({"name": "any", "thumbnail_px": 32});
        body.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        server.post("/v1/lineages", &body).await
    };
    let cases = [
        (json!({}), "wild", 100, false),
        (json!({"start": "wild"}), "wild", 100, false),
        (json!({"dialect": {"length": 40}}), "wild", 40, false),
        (json!({"dialect": {"length": 0}}), "models", 0, false),
        (json!({"start": "models"}), "models", 0, false),
        (json!({"start": "believable", "energy_limit": false}), "believable", 120, false),
        (json!({"start": "painted"}), "painted", 0, false),
    ];
    for (more, start, length, limit) in cases {
        let lineage = made(more).await.expect(201).json();
        assert_eq!(text_of(&lineage["start"]), start);
        assert_eq!(lineage["dialect"]["length"], json!(length));
        assert_eq!(lineage["energy_limit"], json!(limit));
    }
    for more in [
        json!({"start": "models", "dialect": {"length": 5}}),
        json!({"start": "wild", "dialect": {"length": 0}}),
        json!({"start": "believable", "dialect": {}}),
        json!({"start": "painted", "dialect": {}}),
    ] {
        assert_eq!(made(more).await.problem(422)["pointer"], json!("/dialect"));
    }
    let problem = made(json!({"start": "tame"})).await;
    let words = problem.text();
    assert!(words.contains("believable") && words.contains("models") && words.contains("wild"));
}

#[tokio::test(flavor = "multi_thread")]
async fn painted_lineage_draws_mutates_and_crosses_painted_materials() {
    let server = TestServer::start();
    let body = json!({"name": "toons", "thumbnail_px": 32, "start": "painted"});
    let lineage = TestLineage::with(&server, body).await;
    let made = server.get(&lineage.path("")).await.expect(200).json();
    assert_eq!((&made["start"], &made["energy_limit"]), (&json!("painted"), &json!(false)));
    let (first, again) = (lineage.random(4).await, lineage.random(4).await);
    assert_eq!(hashes(&first), hashes(&again), "equal seeds draw equal genomes");
    let all = hashes(&first);
    let parent = genome(&server, &all[0]).await;
    assert!(parent.starts_with("brood 1\n.effect light\npalette #"), "{parent}");
    let colors =
        |text: &str| text.lines().find(|line| line.starts_with("palette")).map(str::to_owned);
    let locks = json!({"effect_parameters": [{"effect": "light", "name": "palette"}]});
    let breed = json!({"parents": [ids(&first)[0]], "count": 4, "seed": 2, "locks": locks});
    for hash in hashes(&lineage.breed(breed).await) {
        let child = genome(&server, &hash).await;
        assert_ne!(child, parent);
        assert_eq!(colors(&child), colors(&parent));
    }
    let mate = json!({"parents": [ids(&first)[0], ids(&first)[1]], "count": 4, "mutation": 0});
    let other = genome(&server, &all[1]).await;
    for hash in hashes(&lineage.breed(mate).await) {
        let child = genome(&server, &hash).await;
        assert!([colors(&parent), colors(&other)].contains(&colors(&child)), "{child}");
    }
    // Options of BRDFs are refused.
    let path = lineage.path("/generations");
    let parents = json!([ids(&first)[0]]);
    for (more, pointer) in [
        (json!({"saturation": 0.5}), "/saturation"),
        (json!({"energy_limit": true}), "/energy_limit"),
        (json!({"steer": ["warmer"], "parents": parents}), "/steer"),
        (json!({"locks": {"channels": ["r"]}, "parents": parents}), "/locks/channels"),
        (
            json!({"locks": {"effect_parameters": [{"effect": "light", "name": "width"}]},
                "parents": parents}),
            "/locks/effect_parameters/0/name",
        ),
    ] {
        let problem = server.post(&path, &more).await;
        assert_eq!(problem.problem(422)["pointer"], json!(pointer), "{more}");
    }
    let dull = json!({"name": "dull", "start": "painted", "saturation": 0.5});
    let problem = server.post("/v1/lineages", &dull).await.problem(422);
    assert_eq!(problem["pointer"], json!("/saturation"));
    let adopted = json!({"presets": ["model-gold"]});
    let adopted = server.post(&lineage.path("/adoptions"), &adopted).await.expect(201).json();
    let mixed = json!({"parents": [ids(&first)[0], ids(&adopted)[0]], "count": 2, "seed": 4});
    let mixed = server.post(&path, &mixed).await.expect(201).json();
    for hash in hashes(&mixed) {
        let genome = server.get(&format!("/v1/genomes/{hash}")).await.expect(200).json();
        assert_eq!(genome["effects"][0]["parameters"]["by"], json!("brdf"), "the BRDF is painted");
    }
    // A saved lineage keeps its start.
    let file = server.get(&lineage.path("/file")).await.expect(200).json();
    assert_eq!(file["start"], json!("painted"));
    let copy = server.post("/v1/lineages/import", &file).await.expect(201).json();
    assert_eq!(copy["start"], json!("painted"));
}
