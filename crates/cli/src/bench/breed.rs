//! Breeds again and again and times what a person waits for, 20 children and their parent, all 21 pictures, and where
//! that time goes.

mod stage;

use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};
use brood_protocol::{Backend, Generation, Lineage};
use clap::Args;
use futures::future::try_join_all;
use reqwest::header::HeaderMap;
use reqwest::{Client, RequestBuilder};
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use self::stage::{Sample, figures, slowest, stages};
use super::own_server::OwnServer;
use crate::supervisor::TOKEN_VARIABLE;
use crate::{logging, output, place};

/// Options of `brood bench breed`.
#[derive(Debug, Args)]
pub struct BenchBreedArgs {
    /// A running server; without it one is started on a temporary directory
    #[arg(long, value_name = "URL")]
    server: Option<String>,
    /// Token of scope breed, where the server wants one
    #[arg(long, value_name = "TOKEN", env = TOKEN_VARIABLE, hide_env_values = true, requires = "server")]
    token: Option<String>,
    /// How often to breed
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    count: u32,
    /// Side of a thumbnail in pixels
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(16..=1024))]
    size: u32,
    /// Worker processes of the started server
    #[arg(long, value_name = "N", default_value_t = 1, conflicts_with = "server")]
    workers: u16,
    /// Evaluator of the started server
    #[arg(long, value_name = "BACKEND", default_value = "auto", conflicts_with = "server")]
    backend: Backend,
    /// Seed of the first brood; the others count on from it
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// How many of the slowest broods are told one by one.
const SLOWEST: usize = 8;

/// Runs the command.
pub fn run(args: &BenchBreedArgs, json: bool) -> Result<()> {
    logging::start_offline();
    place::runtime()?.block_on(async {
        let own = match &args.server {
            Some(_) => None,
            None => Some(OwnServer::start(args.workers, args.backend).await?),
        };
        let url = own.as_ref().map(OwnServer::url).or(args.server.as_deref());
        let url = url.context("a server was given or started")?.trim_end_matches('/');
        let result = measure(args, url).await;
        if let Some(own) = own {
            own.stop().await?;
        }
        let (samples, backend) = result?;
        print(args, &samples, &backend, json)
    })
}

async fn measure(args: &BenchBreedArgs, url: &str) -> Result<(Vec<Sample>, Value)> {
    let api = Api::new(url, args.token.clone())?;
    let body = json!({ "name": "bench", "thumbnail_px": args.size });
    let (lineage, _): (Lineage, _) = api.post("/v1/lineages", &body).await?;
    let path = format!("/v1/lineages/{}/generations", lineage.id);
    // A random start that is not timed: it makes the mesh and the sample set, opens the connections and gives a parent.
    let (mut generation, _): (Generation, _) =
        api.post(&path, &json!({ "seed": args.seed })).await?;
    api.pictures(&generation).await?;
    let bar = output::bar(args.count.into(), "breeding");
    let mut samples = Vec::with_capacity(args.count as usize);
    for index in 0..args.count {
        let parents = &generation.individuals;
        let parent = parents[index as usize % parents.len()].id;
        let body = json!({ "parents": [parent], "seed": args.seed + 1 + u64::from(index) });
        let start = Instant::now();
        let headers;
        (generation, headers) = api.post(&path, &body).await?;
        let breed = start.elapsed();
        let pictures = api.pictures(&generation).await?;
        let total = start.elapsed();
        ensure!(pictures == 21, "a brood has 21 pictures, not {pictures}");
        let job = match stage::job_path(&headers) {
            Some(path) => Some(api.get(path).await?),
            None => None,
        };
        samples.push(Sample { breed, total, server: stage::server_timing(&headers), job });
        bar.inc(1);
    }
    bar.finish_and_clear();
    let system: Value = api.get("/v1/system").await?;
    Ok((samples, system.get("backend").cloned().unwrap_or_default()))
}

fn print(args: &BenchBreedArgs, samples: &[Sample], backend: &Value, json: bool) -> Result<()> {
    let stages: Vec<_> =
        stages(samples).into_iter().map(|(stage, times)| (stage, figures(times))).collect();
    if json {
        let by_key: serde_json::Map<_, _> =
            stages.iter().map(|(stage, figures)| (stage.key.to_owned(), json!(figures))).collect();
        return output::print_json(&json!({
            "count": args.count,
            "size_px": args.size,
            "pictures_each": 21,
            "backend": backend,
            "total": by_key.get("total"),
            "breed": by_key.get("breed"),
            "pictures": by_key.get("pictures"),
            "stages": by_key,
            "slowest": slowest(samples, SLOWEST),
        }));
    }
    let mut text = format!("{} broods, 21 pictures of {} px each\n", args.count, args.size);
    for (stage, f) in &stages {
        text += &format!(
            "{:<38} median {:8.2} ms  p99 {:8.2} ms  min {:8.2} ms  max {:8.2} ms\n",
            stage.label, f.median_ms, f.p99_ms, f.min_ms, f.max_ms
        );
    }
    text +=
        "\nthe slowest      total    breed   commit   render     film  sets made  rough samples\n";
    for it in slowest(samples, SLOWEST) {
        let told = |ms: Option<f64>| ms.map_or("-".to_owned(), |ms| format!("{ms:.2}"));
        text += &format!(
            "brood {:<6} {:>8.2} {:>8.2} {:>8} {:>8} {:>8} {:>10} {:>14}\n",
            it.brood,
            it.total_ms,
            it.breed_ms,
            told(it.commit_ms),
            told(it.render_ms),
            told(it.film_ms),
            it.sets_made,
            it.rough_samples
        );
    }
    output::print(&text)
}

/// The server over kept-alive connections.
struct Api {
    http: Client,
    url: String,
    token: Option<String>,
}

impl Api {
    fn new(url: &str, token: Option<String>) -> Result<Self> {
        let http = Client::builder()
            .timeout(Duration::from_secs(60))
            .tcp_nodelay(true)
            .no_proxy()
            .build()
            .context("set up HTTP")?;
        Ok(Self { http, url: url.to_owned(), token })
    }

    async fn post<T: DeserializeOwned>(&self, path: &str, body: &Value) -> Result<(T, HeaderMap)> {
        let request = self.http.post(format!("{}{path}", self.url)).json(body);
        let (body, headers) = self.send(request).await?;
        Ok((serde_json::from_slice(&body).with_context(|| path.to_owned())?, headers))
    }

    async fn get<T: DeserializeOwned>(&self, path: &str) -> Result<T> {
        let request = self.http.get(format!("{}{path}", self.url));
        serde_json::from_slice(&self.send(request).await?.0).with_context(|| path.to_owned())
    }

    /// Fetches the pictures of all children and of the centre at once.
    async fn pictures(&self, generation: &Generation) -> Result<usize> {
        let individuals = generation.individuals.iter().chain(&generation.centre);
        let fetch = individuals.map(|individual| async {
            let request = self.http.get(format!("{}{}", self.url, individual.thumbnail));
            let (bytes, _) = self.send(request).await?;
            ensure!(bytes.starts_with(b"\x89PNG"), "a thumbnail is not a PNG");
            Ok(())
        });
        Ok(try_join_all(fetch).await?.len())
    }

    async fn send(&self, mut request: RequestBuilder) -> Result<(Vec<u8>, HeaderMap)> {
        if let Some(token) = &self.token {
            request = request.bearer_auth(token);
        }
        let response = request.send().await.context("reach the server")?;
        let status = response.status();
        let headers = response.headers().clone();
        let body = response.bytes().await.context("read the answer")?;
        if !status.is_success() {
            let text = String::from_utf8_lossy(&body);
            bail!("the server answered {status}: {}", text.chars().take(300).collect::<String>());
        }
        Ok((body.into(), headers))
    }
}
