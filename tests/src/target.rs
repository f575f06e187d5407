//! Targets of searches: samples of a glossy material, and uploads.

use std::fmt::Write;

use serde_json::{Value, json};

use crate::{Answer, TestServer, text_of};

/// Boundary between the parts of an upload.
const BOUNDARY: &str = "----between-the-parts";

/// Returns samples of a coloured, glossy, reciprocal material as CSV, at directions drawn from a
/// seed.
#[must_use]
pub fn glossy_csv(rows: usize, seed: u64) -> String {
    let mut state = seed.wrapping_mul(2).wrapping_add(1);
    let mut draw = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut direction = || {
        let (z, turn) = (0.05 + 0.95 * draw(), std::f64::consts::TAU * draw());
        let across = (1.0f64 - z * z).sqrt();
        [across * turn.cos(), across * turn.sin(), z]
    };
    let mut text = String::from("wix,wiy,wiz,wox,woy,woz,r,g,b\n");
    for _ in 0..rows {
        let (i, o) = (direction(), direction());
        let sum: [f64; 3] = std::array::from_fn(|axis| i[axis] + o[axis]);
        let length = sum.iter().map(|part| part * part).sum::<f64>().sqrt();
        let gloss = 0.3 * (sum[2] / length).powi(24);
        let [r, g, b] = [0.25, 0.12, 0.05].map(|diffuse| diffuse + gloss);
        let numbers = [i, o, [r, g, b]].concat();
        let numbers: Vec<String> = numbers.iter().map(f64::to_string).collect();
        writeln!(text, "{}", numbers.join(",")).expect("writing to a string cannot fail");
    }
    text
}

/// Returns the content type and the body of an upload.
#[must_use]
pub fn upload(spec: &str, file: &[u8]) -> (String, Vec<u8>) {
    upload_parts(spec, &[("file", file)])
}

/// Returns the content type and the body of an upload with any parts.
#[must_use]
pub fn upload_parts(spec: &str, parts: &[(&str, &[u8])]) -> (String, Vec<u8>) {
    let mut body = Vec::new();
    for (name, bytes) in [("spec", spec.as_bytes())].iter().chain(parts) {
        let head =
            format!("--{BOUNDARY}\r\nContent-Disposition: form-data; name=\"{name}\"\r\n\r\n");
        body.extend(head.bytes());
        body.extend(*bytes);
        body.extend(b"\r\n");
    }
    body.extend(format!("--{BOUNDARY}--\r\n").bytes());
    (format!("multipart/form-data; boundary={BOUNDARY}"), body)
}

impl TestServer {
    /// Uploads a target.
    pub async fn post_target(&self, spec: &Value, file: impl AsRef<[u8]>) -> Answer {
        let (kind, body) = upload(&spec.to_string(), file.as_ref());
        self.post_bytes("/v1/targets", &kind, body).await
    }

    /// Uploads a target of several parts.
    pub async fn post_parts(&self, spec: &Value, parts: &[(&str, &[u8])]) -> Answer {
        let (kind, body) = upload_parts(&spec.to_string(), parts);
        self.post_bytes("/v1/targets", &kind, body).await
    }

    /// Uploads a glossy material; returns its id.
    pub async fn glossy_target(&self) -> String {
        let spec = json!({"kind": "samples", "name": "glossy"});
        let target = self.post_target(&spec, glossy_csv(600, 1)).await.expect(201).json();
        text_of(&target["id"])
    }

    /// Waits until the job satisfies `is_wanted`, and returns it.
    ///
    /// # Panics
    /// If it does not within two minutes.
    pub async fn job_once(&self, id: &str, is_wanted: impl Fn(&Value) -> bool) -> Value {
        let deadline = std::time::Instant::now() + std::time::Duration::from_secs(120);
        loop {
            let job = self.get(&format!("/v1/jobs/{id}")).await.expect(200).json();
            if is_wanted(&job) {
                return job;
            }
            assert!(std::time::Instant::now() < deadline, "{job}");
            tokio::time::sleep(std::time::Duration::from_millis(20)).await;
        }
    }
}
