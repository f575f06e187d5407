//! Genomes by hash: stored, read, and refused with the position of the error.

use brood_tests::{Answer, TestLineage, TestServer, hashes, text_of};
use reqwest::Method;
use serde_json::json;

const TEXT: &str = "text/x-brood";

async fn read(server: &TestServer, hash: &str, accept: &str) -> Answer {
    let request = server.request(Method::GET, &format!("/v1/genomes/{hash}"));
    server.send(request.header("accept", accept)).await.expect(200)
}

#[tokio::test(flavor = "multi_thread")]
async fn genome_has_the_same_hash_when_its_text_is_stored_again() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let other = TestServer::start();
    for hash in hashes(&lineage.random(7).await) {
        let text = read(&server, &hash, TEXT).await;
        assert!(text.header("content-type").starts_with(TEXT));
        assert!(text.text().starts_with("brood 1\n"));
        let saved = other.post_bytes("/v1/genomes", TEXT, text.body.clone()).await.expect(201);
        assert_eq!(saved.json()["hash"], json!(hash));
        assert_eq!(read(&other, &hash, TEXT).await.body, text.body);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn genome_is_a_parent_when_it_was_saved_as_text() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let mut text =
        "brood 1\n.dialect paper smooth registers 7\n.const C0 0.5 0.25 0.125 0\n".to_owned();
    text.push_str(&"MOV R0, C0\n".repeat(100));
    let saved = server.post_bytes("/v1/genomes", TEXT, text).await.expect(201).json();
    let body = json!({"parents": [saved["hash"]], "count": 3, "seed": 1});
    let generation = lineage.breed(body).await;
    assert_eq!(hashes(&generation).len(), 3);
    let short = "brood 1\n.dialect paper smooth registers 7\nMOV R0, R1\n";
    let saved = server.post_bytes("/v1/genomes", TEXT, short).await.expect(201).json();
    let body = json!({"parents": [text_of(&saved["hash"])], "count": 3});
    // A genome of one instruction does not fit a lineage of a hundred.
    server.post(&lineage.path("/generations"), &body).await.problem(422);
}

#[tokio::test(flavor = "multi_thread")]
async fn genome_text_is_refused_with_line_and_column_when_it_is_invalid() {
    let server = TestServer::start();
    let head = "brood 1\n.dialect paper smooth registers 7\n";
    let rows = [
        ("", 1),
        ("brood 2\n", 1),
        ("brood 1\n.dialect paper rough registers 7\nMOV R0, R1\n", 2),
        ("brood 1\n.dialect paper smooth registers 3\nMOV R0, R1\n", 2),
        ("MAX R0, R1, R2", 3),
        ("MOV R9, R1", 3),
        ("MOV R0, R7", 3),
        ("MOV R0.yx, R1", 3),
        ("MOV R0, R1.xy", 3),
        ("ADD R0, R1", 3),
        ("ADD R0, C1, C2", 3),
        ("SIN R0, R1", 3),
        ("MOV R0, C128", 3),
        (".const C0 1 2 3 nan\nMOV R0, C0", 3),
        (".const C0 1 2 3 1e30\nMOV R0, C0", 3),
        ("MOV R0, R1\nRCP R0, R1.x", 4),
    ];
    for (text, line) in rows {
        let whole = if text.starts_with("brood") || text.is_empty() {
            text.to_owned()
        } else {
            format!("{head}{text}\n")
        };
        let problem = server.post_bytes("/v1/genomes", TEXT, whole.clone()).await.problem(422);
        assert_eq!(problem["line"], line, "{whole}: {problem}");
        assert!(problem["column"].as_u64().is_some_and(|column| column >= 1), "{problem}");
    }
    let bytes = b"brood 1\n\xff\xfe\n".to_vec();
    let answer = server.post_bytes("/v1/genomes", TEXT, bytes).await;
    assert!(matches!(answer.status, 400 | 422), "{}", answer.text());
}

#[tokio::test(flavor = "multi_thread")]
async fn genome_json_is_refused_with_a_pointer_when_it_is_invalid() {
    let server = TestServer::start();
    let dialect = json!({
        "opcodes": "paper", "parametrisation": "smooth", "registers": 7, "length": 1,
        "isotropic": false, "homogeneous": false,
    });
    let genome = |instruction: serde_json::Value| json!({"brood": 1, "dialect": dialect, "constants": {}, "instructions": [instruction]});
    let good = genome(json!({"opcode": "MOV", "dst": "R0", "src": ["R1.xxyz"]}));
    server.post("/v1/genomes", &good).await.expect(201);
    let rows = [
        json!({"opcode": "MAX", "dst": "R0", "src": ["R1"]}),
        json!({"opcode": "MOV", "dst": "R7", "src": ["R1"]}),
        json!({"opcode": "MOV", "dst": "R0", "src": ["R1", "R2"]}),
        json!({"opcode": "ADD", "dst": "R0", "src": ["C1", "C2"]}),
    ];
    for instruction in rows {
        let answer = server.post("/v1/genomes", &genome(instruction.clone())).await;
        let problem = answer.problem(422);
        let pointer = problem["pointer"].as_str().unwrap_or_default();
        assert!(pointer.starts_with("/instructions/0"), "{instruction}: {problem}");
    }
}
