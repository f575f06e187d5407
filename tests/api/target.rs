//! Targets: uploaded, described, kept while a job needs them, and refused with a reason.

use brood_tests::{TestServer, glossy_csv, text_of, upload};
use serde_json::{Value, json};

/// Returns the reason for which a file is refused.
async fn reason(server: &TestServer, kind: &str, file: &[u8]) -> String {
    let problem = server.post_target(&json!({"kind": kind}), file).await.problem(422);
    text_of(&problem["detail"])
}

/// Returns an EXR of this size.
fn exr(side: u32, value: f32) -> Vec<u8> {
    let picture = image::Rgb32FImage::from_pixel(side, side, image::Rgb([value; 3]));
    let mut bytes = std::io::Cursor::new(Vec::new());
    picture.write_to(&mut bytes, image::ImageFormat::OpenExr).unwrap();
    bytes.into_inner()
}

#[tokio::test(flavor = "multi_thread")]
async fn target_is_described_listed_and_deleted() {
    let server = TestServer::start();
    let spec = json!({"kind": "samples", "name": "glossy <b>"});
    let answer = server.post_target(&spec, glossy_csv(600, 1)).await.expect(201);
    let (place, target) = (answer.header("location"), answer.json());
    assert_eq!(place, format!("/v1/targets/{}", text_of(&target["id"])));
    assert_eq!((&target["kind"], &target["name"]), (&json!("samples"), &json!("glossy <b>")));
    assert_eq!(
        (&target["fitted_samples"], &target["held_out_samples"]),
        (&json!(480), &json!(120))
    );
    assert_eq!((&target["samples"], &target["reciprocal_floor"]), (&json!(600), &Value::Null));
    assert!(target["largest_f"].as_f64().unwrap() > 0.3, "{target}");
    assert_eq!(server.get(&place).await.expect(200).json(), target);
    let slice = server.post_target(&json!({"kind": "slice"}), exr(90, 0.5)).await.expect(201);
    let list = server.get("/v1/targets").await.expect(200).json();
    assert_eq!(list["items"], json!([slice.json(), target]));
    let first = server.get("/v1/targets?limit=1").await.expect(200).json();
    let next = format!("/v1/targets?limit=1&cursor={}", text_of(&first["next"]));
    assert_eq!(server.get(&next).await.expect(200).json()["items"], json!([target]));
    server.delete(&place).await.expect(204);
    server.get(&place).await.problem(404);
    server.delete(&place).await.problem(404);
}

/// Returns a MERL table of a constant BRDF with this albedo.
fn even_merl(albedo: f64) -> Vec<u8> {
    let mut bytes = [90i32, 90, 180].map(i32::to_le_bytes).concat();
    for scale in [1.0, 1.15, 1.66] {
        let value = albedo / std::f64::consts::PI * 1500.0 / scale;
        bytes.extend(std::iter::repeat_n(value.to_le_bytes(), 90 * 90 * 180).flatten());
    }
    bytes
}

#[tokio::test(flavor = "multi_thread")]
async fn target_has_its_largest_albedo() {
    let server = TestServer::start();
    for albedo in [0.5, 1.5] {
        let answer = server.post_target(&json!({"kind": "merl"}), even_merl(albedo)).await;
        let most = answer.expect(201).json()["largest_albedo"].clone();
        assert!((most["albedo"].as_f64().unwrap() - albedo).abs() < 0.01 * albedo, "{most}");
        assert!(most["theta_deg"].as_f64().is_some(), "{most}");
    }
    let told = server.post_target(&json!({"kind": "samples"}), glossy_csv(200, 1)).await;
    assert_eq!(
        told.expect(201).json()["largest_albedo"],
        Value::Null,
        "null if the target does not cover all directions"
    );
}

#[tokio::test(flavor = "multi_thread")]
async fn repeated_upload_is_stored_once() {
    let server = TestServer::start();
    let send = async |rows: usize| {
        let (kind, body) = upload("{\"kind\": \"samples\"}", glossy_csv(rows, 1).as_bytes());
        let request = server.request(reqwest::Method::POST, "/v1/targets");
        let request = request.header("content-type", kind).header("idempotency-key", "once");
        server.send(request.body(body)).await
    };
    let first = send(200).await.expect(201).json();
    assert_eq!(send(200).await.expect(201).json(), first);
    send(201).await.problem(422);
    let list = server.get("/v1/targets").await.expect(200).json();
    assert_eq!(list["items"].as_array().unwrap().len(), 1);
}

#[tokio::test(flavor = "multi_thread")]
async fn invalid_target_is_refused_with_a_reason() {
    let server = TestServer::start();
    let head = "wix,wiy,wiz,wox,woy,woz,r,g,b\n";
    let rows = |value: &str, count: usize| {
        format!("{head}{}", format!("0,0,1,0.6,0,0.8,{value},{value},{value}\n").repeat(count))
    };
    let mut short = [90i32, 90, 180].map(i32::to_le_bytes).concat();
    short.extend([0; 100]);
    let told = [
        ("samples", rows("1", 9).into_bytes(), "9 samples are above the surface"),
        ("samples", rows("NaN", 200).into_bytes(), "not a finite number"),
        ("samples", rows("0", 200).into_bytes(), "reflects nothing"),
        ("samples", rows("1e30", 200).into_bytes(), "must be a finite number"),
        ("samples", b"r,g,b\n".to_vec(), "column wix"),
        ("merl", [90i32, 90, 90].map(i32::to_le_bytes).concat(), "90 x 90 x 180"),
        ("merl", short, "bytes"),
        ("rgl", b"tensor_file\0".to_vec(), "ends within"),
        ("slice", exr(1, 0.5), "90 x 90"),
        ("slice", exr(90, f32::NAN), "not a finite number"),
        ("slice", b"no picture".to_vec(), "no EXR"),
        ("cornell", b"analytic\n".to_vec(), "formula"),
        ("hologram", b"x".to_vec(), "one of samples"),
    ];
    for (kind, file, words) in told {
        let reason = reason(&server, kind, &file).await;
        assert!(reason.contains(words), "{kind}: {reason}");
    }
    let scene = json!({"kind": "samples", "scene": {}});
    let problem = server.post_target(&scene, rows("1", 200)).await.problem(422);
    assert_eq!(problem["pointer"], "/scene");
    let unknown = json!({"kind": "samples", "colour": 1});
    server.post_target(&unknown, rows("1", 200)).await.problem(400);
    server.post("/v1/targets", &json!({"kind": "samples"})).await.problem(415);
    let (kind, body) = upload("{\"kind\": \"samples\"}", b"x");
    server.post_bytes("/v1/targets", &kind, &body[..body.len() / 2]).await.problem(400);
    let large = vec![b'0'; (64 << 20) + 1];
    server.post_target(&json!({"kind": "samples"}), large).await.problem(413);
    let list = server.get("/v1/targets").await.expect(200).json();
    assert_eq!(list["items"], json!([]), "a refused upload stores nothing");
}

#[tokio::test(flavor = "multi_thread")]
async fn target_cannot_be_deleted_while_a_job_uses_it() {
    let server = TestServer::start();
    let target = server.glossy_target().await;
    let body = json!({"kind": "fit", "target": target, "seconds": 3600});
    let job = text_of(&server.post("/v1/jobs", &body).await.expect(202).json()["id"]);
    let place = format!("/v1/targets/{target}");
    server.delete(&place).await.problem(409);
    server.post(&format!("/v1/jobs/{job}/cancel"), &json!({})).await.expect(200);
    server.delete(&place).await.expect(204);
    let told = server.get(&format!("/v1/jobs/{job}")).await.expect(200).json();
    assert_eq!(text_of(&told["target"]), target, "the job still names its target");
    let again = server.post("/v1/jobs", &body).await.problem(404);
    assert_eq!(again["pointer"], "/target");
}
