//! Searches that load the server while broods are timed; started once, then paused and resumed
//! together.

use std::time::Duration;

use anyhow::{Context, Result, bail};
use brood_brdf::{Model, ModelKind};
use brood_export::samples_csv;
use brood_target::draw_pairs;
use serde_json::{Value, json};

use crate::api::Api;

const SAMPLES: usize = 4000;
/// Budget of a search; longer than any benchmark.
const SECONDS: f64 = 24.0 * 3600.0;
/// Longest wait for a worker to start a search.
const WAIT: Duration = Duration::from_secs(30);

/// Ids of the search jobs.
pub struct Searches(Vec<String>);

impl Searches {
    /// Starts `count` searches and pauses them.
    pub async fn begin(api: &Api, count: u16) -> Result<Self> {
        let mut jobs = Vec::new();
        if count == 0 {
            return Ok(Self(jobs));
        }
        let spec = json!({ "kind": "samples", "name": "bench" }).to_string();
        let target: Value =
            api.post_parts("/v1/targets", [("spec", &spec), ("file", &metal())]).await?;
        for seed in 1..=count {
            let body =
                json!({ "kind": "fit", "target": target["id"], "seconds": SECONDS, "seed": seed });
            let (job, _): (Value, _) = api.post("/v1/jobs", &body).await?;
            jobs.push(job["id"].as_str().context("a job has an id")?.to_owned());
        }
        let all = Self(jobs);
        all.pause(api).await?;
        Ok(all)
    }

    /// Resumes the searches and waits until at least one runs.
    pub async fn resume(&self, api: &Api) -> Result<()> {
        self.change(api, "resume").await?;
        let begun = std::time::Instant::now();
        while begun.elapsed() < WAIT {
            for id in &self.0 {
                let job: Value = api.get(&format!("/v1/jobs/{id}")).await?;
                if job["state"] == "running" {
                    return Ok(());
                }
            }
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
        bail!(
            "no search started within {} s: the server needs a worker that runs searches",
            WAIT.as_secs()
        )
    }

    /// Pauses the searches and gives the worker a second to finish its generation.
    pub async fn pause(&self, api: &Api) -> Result<()> {
        self.change(api, "pause").await?;
        tokio::time::sleep(Duration::from_secs(1)).await;
        Ok(())
    }

    /// Cancels the searches and returns the number of generations completed by all of them.
    pub async fn end(&self, api: &Api) -> Result<u64> {
        let mut generations = 0;
        for id in &self.0 {
            let job: Value = api.get(&format!("/v1/jobs/{id}")).await?;
            generations += job["generation"].as_u64().unwrap_or_default();
        }
        self.change(api, "cancel").await?;
        Ok(generations)
    }

    async fn change(&self, api: &Api, action: &str) -> Result<()> {
        for id in &self.0 {
            let (_, _): (Value, _) =
                api.post(&format!("/v1/jobs/{id}/{action}"), &json!({})).await?;
        }
        Ok(())
    }
}

/// Samples of a rough metal, as CSV.
fn metal() -> String {
    let metal = Model::new(ModelKind::Conductor).brdf();
    samples_csv(draw_pairs(SAMPLES, 1).iter().map(|pair| (pair, metal.f(pair).to_array())))
}
