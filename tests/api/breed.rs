//! Breeding: the answer, and reproducibility from a seed.

use std::collections::HashMap;

use brood_tests::{TestLineage, TestServer, hashes, ids, seed_of};
use serde_json::{Value, json};

#[tokio::test(flavor = "multi_thread")]
async fn generation_has_twenty_children_by_default() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let generation = lineage.breed(json!({"parents": [], "seed": 1})).await;
    assert_eq!(generation["index"], 0);
    assert_eq!(seed_of(&generation), 1);
    assert_eq!(generation["centre"], Value::Null);
    let children = generation["individuals"].as_array().unwrap();
    assert_eq!(children.len(), 20);
    for (slot, child) in children.iter().enumerate() {
        assert_eq!(child["slot"], slot);
        assert_eq!(child["operator"], "random", "{child}");
        assert_eq!(child["parents"], json!([]));
        assert!(child["live_instructions"].as_u64().is_some(), "{child}");
        let thumbnail = child["thumbnail"].as_str().unwrap();
        assert!(thumbnail.starts_with("/v1/thumbnails/") && thumbnail.ends_with(".png"));
    }
    let mut different = hashes(&generation);
    different.sort();
    different.dedup();
    assert_eq!(different.len(), 20, "all children of a distinct brood differ");
}

#[tokio::test(flavor = "multi_thread")]
async fn children_have_their_parents_and_operator_when_bred_from_one_or_two() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let first = ids(&lineage.random(1).await);
    let mutated = lineage.breed(json!({"parents": [first[2]], "count": 3, "seed": 2})).await;
    assert_eq!(mutated["index"], 1);
    assert_eq!(mutated["centre"]["id"], json!(first[2]));
    for child in mutated["individuals"].as_array().unwrap() {
        assert_eq!(child["parents"], json!([first[2]]));
        assert_eq!(child["operator"], "mutate");
    }
    let body = json!({"parents": [first[1], first[3]], "count": 3, "seed": 3});
    let recombined = lineage.breed(body).await;
    assert_eq!(recombined["centre"]["id"], json!(first[1]), "the first parent is the centre");
    for child in recombined["individuals"].as_array().unwrap() {
        assert_eq!(child["parents"], json!([first[1], first[3]]));
        assert_eq!(child["operator"], "recombine");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn breeding_from_two_parents_is_refused_when_all_children_would_be_identical() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let parents = ids(&lineage.random(1).await)[..2].to_vec();
    for curation in ["off", "distinct", "diverse"] {
        for share in [0.0, 1.0] {
            let body = json!({
                "parents": parents, "mutation": 0, "recombination": share, "curation": curation,
            });
            let answer = server.post(&lineage.path("/generations"), &body).await;
            assert_eq!(answer.problem(422)["pointer"], "/recombination", "{body}");
        }
    }
    let body = json!({"parents": parents, "mutation": 0, "recombination": 0.5, "count": 4});
    let mut different = hashes(&lineage.breed(body).await);
    different.dedup();
    assert_eq!(different.len(), 4);
}

#[tokio::test(flavor = "multi_thread")]
async fn children_are_the_same_when_the_seed_is_the_same_on_two_empty_servers() {
    let mut broods = Vec::new();
    for _ in 0..2 {
        let server = TestServer::start();
        let lineage = TestLineage::new(&server).await;
        broods.push(family(&lineage, [11, u64::MAX, 13, 14]).await);
    }
    let second = broods.pop().unwrap();
    assert_eq!(broods.pop().unwrap(), second);
}

#[tokio::test(flavor = "multi_thread")]
async fn children_do_not_depend_on_history_when_the_seed_is_the_same() {
    let server = TestServer::start();
    let here = TestLineage::new(&server).await;
    let there = TestLineage::new(&server).await;
    let early = here.random(5).await;
    for seed in 100..103 {
        there.random(seed).await;
    }
    let late = there.random(5).await;
    assert_eq!(hashes(&early), hashes(&late), "neither index nor history enters");
    assert_ne!(hashes(&early), hashes(&here.random(6).await), "the seed does");
    let more = there.breed(json!({"parents": [], "count": 9, "seed": 5})).await;
    assert_eq!(
        hashes(&more)[..4],
        hashes(&early)[..],
        "a larger brood begins with the children of a smaller one"
    );
}

#[tokio::test(flavor = "multi_thread")]
async fn drawn_seed_is_reported_and_reproduces_the_brood() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let drawn = lineage.breed(json!({"parents": [], "count": 4})).await;
    let other = lineage.breed(json!({"parents": [], "count": 4})).await;
    assert_ne!(seed_of(&drawn), seed_of(&other), "each brood draws its own seed");
    let again = lineage.breed(json!({"parents": [], "count": 4, "seed": drawn["seed"]})).await;
    assert_eq!(hashes(&again), hashes(&drawn));
    let number = seed_of(&drawn);
    let again = lineage.breed(json!({"parents": [], "count": 4, "seed": number})).await;
    assert_eq!(hashes(&again), hashes(&drawn), "a seed may be a number or a string");
}

#[tokio::test(flavor = "multi_thread")]
async fn genomes_obey_the_constraints_when_given() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let constraints = json!({"isotropic": true, "homogeneous": true});
    let body = json!({"parents": [], "count": 2, "seed": 1, "constraints": constraints});
    let generation = lineage.breed(body).await;
    for hash in hashes(&generation) {
        let request = server.request(reqwest::Method::GET, &format!("/v1/genomes/{hash}"));
        let text = server.send(request.header("accept", "text/x-brood")).await.expect(200).text();
        let dialect = text.lines().find(|line| line.starts_with(".dialect")).unwrap();
        assert!(dialect.contains(" isotropic") && dialect.contains(" homogeneous"), "{dialect}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn parent_may_be_the_hash_of_a_genome() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let first = lineage.random(1).await;
    let by_id = json!({"parents": [ids(&first)[0]], "count": 3, "seed": 9});
    let by_hash = json!({"parents": [hashes(&first)[0]], "count": 3, "seed": 9});
    let (by_id, by_hash) = (lineage.breed(by_id).await, lineage.breed(by_hash).await);
    assert_eq!(hashes(&by_id), hashes(&by_hash));
}

#[tokio::test(flavor = "multi_thread")]
async fn lineage_has_the_same_hashes_when_replayed_from_its_recorded_seeds() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    family(&lineage, [21, 22, 23, 24]).await;
    // The server draws the seed of this one, bred from a child of the recombination.
    let listed = server.get(&lineage.path("/generations")).await.expect(200).json();
    let last = listed["items"].as_array().unwrap().last().unwrap().clone();
    lineage.breed(json!({"parents": [ids(&last)[0]], "count": 4, "mutation": 0.7})).await;

    let recorded = server.get(&lineage.path("/generations")).await.expect(200).json();
    let fresh = TestServer::start();
    let replayed = TestLineage::new(&fresh).await;
    let mut names: HashMap<String, String> = HashMap::new();
    for generation in recorded["items"].as_array().unwrap() {
        let parents = generation["parents"].as_array().unwrap().iter();
        let parents: Vec<String> = parents.map(|it| names[it.as_str().unwrap()].clone()).collect();
        let again = replayed
            .breed(json!({
                "parents": parents,
                "count": ids(generation).len(),
                "seed": generation["seed"],
                "mutation": generation["mutation"],
                "recombination": generation["recombination"],
                "curation": generation["curation"],
            }))
            .await;
        assert_eq!(hashes(&again), hashes(generation), "generation {}", generation["index"]);
        names.extend(ids(generation).into_iter().zip(ids(&again)));
    }
}

/// Breeds three generations by mutation and one by recombination; returns the hashes of all
/// children.
async fn family(lineage: &TestLineage<'_>, seeds: [u64; 4]) -> Vec<Vec<String>> {
    let first = lineage.random(seeds[0]).await;
    let body = json!({"parents": [ids(&first)[1]], "count": 4, "seed": seeds[1].to_string()});
    let second = lineage.breed(body).await;
    let body = json!({"parents": [ids(&second)[0]], "count": 4, "seed": seeds[2], "mutation": 0.6});
    let third = lineage.breed(body).await;
    let parents = [ids(&third)[2].clone(), ids(&first)[3].clone()];
    let body = json!({"parents": parents, "count": 4, "seed": seeds[3], "recombination": 0.4});
    let fourth = lineage.breed(body).await;
    [first, second, third, fourth].iter().map(hashes).collect()
}

#[tokio::test(flavor = "multi_thread")]
async fn steered_brood_is_repeatable_and_its_words_are_stored_and_exported() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let parent = ids(&lineage.random(1).await)[0].clone();
    let body = |steer: Value| {
        let given = json!({"parents": [parent], "count": 6, "seed": 4});
        let mut body = json!({"curation": "diverse", "steer": steer});
        body.as_object_mut().unwrap().extend(given.as_object().unwrap().clone());
        body
    };
    let steered = lineage.breed(body(json!(["warmer", "glossier"]))).await;
    assert_eq!(steered["steer"], json!(["warmer", "glossier"]));
    assert_eq!(hashes(&lineage.breed(body(json!(["warmer", "glossier"]))).await), hashes(&steered));
    let plain = lineage.breed(body(json!([]))).await;
    assert_eq!(plain.get("steer"), None);
    assert_ne!(hashes(&plain), hashes(&steered));
    let path = format!("/v1/generations/{}", steered["id"].as_str().unwrap());
    assert_eq!(server.get(&path).await.expect(200).json()["steer"], steered["steer"]);

    let file = server.get(&lineage.path("/file")).await.expect(200).json();
    assert_eq!(file["generations"][1]["steer"], steered["steer"]);
    let imported = server.post("/v1/lineages/import", &file).await.expect(201).json();
    let path = format!("/v1/lineages/{}/generations", imported["id"].as_str().unwrap());
    let listed = server.get(&path).await.expect(200).json();
    assert_eq!(listed["items"][1]["steer"], steered["steer"]);
    assert_eq!(listed["items"][3].get("steer"), None);
}

#[tokio::test(flavor = "multi_thread")]
async fn steer_is_refused_when_its_words_or_the_brood_do_not_allow_it() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let parent = ids(&lineage.random(1).await)[0].clone();
    let parents = json!([parent]);
    let homogeneous = json!({"homogeneous": true});
    let cases = [
        (json!({"parents": parents, "steer": ["warmer", "cooler"]}), "/steer", "contradicts"),
        (json!({"parents": parents, "steer": ["rougher", "rougher"]}), "/steer", "twice"),
        (json!({"steer": ["warmer"]}), "/steer", "needs a parent"),
        (
            json!({"parents": parents, "steer": ["warmer"], "curation": "off"}),
            "/curation",
            "`distinct` or `diverse`",
        ),
        (
            json!({"parents": parents, "steer": ["more-pattern"], "constraints": homogeneous}),
            "/steer",
            "homogeneous",
        ),
    ];
    for (body, pointer, words) in cases {
        let answer = server.post(&lineage.path("/generations"), &body).await;
        let problem = answer.problem(422);
        assert_eq!(problem["pointer"], pointer, "{body}: {problem}");
        assert!(problem["detail"].as_str().unwrap().contains(words), "{body}: {problem}");
    }
    let body = json!({"parents": parents, "steer": ["purple"]});
    let answer = server.post(&lineage.path("/generations"), &body).await;
    assert_eq!(answer.problem(400)["pointer"], "/steer/0");
}
