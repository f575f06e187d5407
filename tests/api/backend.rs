//! The same pictures, byte for byte, whichever evaluator made them.

use brood_tests::{ServerOptions, TestLineage, TestServer, text_of};
use serde_json::json;

#[tokio::test(flavor = "multi_thread")]
async fn pictures_are_byte_equal_when_made_on_the_gpu_and_on_the_cpu() {
    let mut sheets = Vec::new();
    for backend in ["cpu", "gpu"] {
        let options = ServerOptions { backend, ..ServerOptions::default() };
        let server = TestServer::start_with(options);
        let body = json!({"name": "same", "thumbnail_px": 64});
        let lineage = TestLineage::with(&server, body).await;
        let generation = lineage.breed(json!({"parents": [], "seed": 42})).await;
        let mut pictures = Vec::new();
        for child in generation["individuals"].as_array().unwrap() {
            let answer = server.get(&text_of(&child["thumbnail"])).await.expect(200);
            pictures.push((child["hash"].clone(), answer.body));
        }
        let system = server.get("/v1/system").await.expect(200).json();
        let used = text_of(&system["backend"]["name"]);
        if used != backend {
            // Without any driver the worker says so and uses the CPU; where a driver was installed it has to be used.
            let required = std::env::var_os("BROOD_REQUIRE_GPU").is_some();
            assert!(!required, "asked for {backend}, used {}", system["backend"]);
            println!("no adapter: compared the fallback ({})", system["backend"]["reason"]);
        }
        sheets.push(pictures);
    }
    assert_eq!(sheets[0].len(), 20);
    for (cpu, gpu) in sheets[0].iter().zip(&sheets[1]) {
        assert_eq!(cpu.0, gpu.0, "the same genome");
        assert!(cpu.1 == gpu.1, "genome {} has other pictures on cpu and gpu", cpu.0);
    }
}
