//! Breeds again and again and times what a person waits for: 20 children and their parent, all 21 pictures.

use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};
use brood_protocol::{Backend, Generation, Lineage};
use clap::Args;
use futures::future::try_join_all;
use reqwest::{Client, RequestBuilder};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

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
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=100_000))]
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

/// Times of one brood.
#[derive(Debug, Clone, Copy)]
struct Sample {
    /// Request to the whole answer.
    breed: Duration,
    /// Request to the last byte of the last picture.
    total: Duration,
}

#[derive(Debug, Serialize)]
struct Figures {
    median_ms: f64,
    p99_ms: f64,
    min_ms: f64,
    max_ms: f64,
}

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
    let lineage: Lineage =
        api.post("/v1/lineages", &json!({ "name": "bench", "thumbnail_px": args.size })).await?;
    let path = format!("/v1/lineages/{}/generations", lineage.id);
    // A random start that is not timed: it makes the mesh and the sample set, opens the connections and gives a parent.
    let mut generation: Generation = api.post(&path, &json!({ "seed": args.seed })).await?;
    api.pictures(&generation).await?;
    let bar = output::bar(args.count.into(), "breeding");
    let mut samples = Vec::with_capacity(args.count as usize);
    for index in 0..args.count {
        let parents = &generation.individuals;
        let parent = parents[index as usize % parents.len()].id;
        let body = json!({ "parents": [parent], "seed": args.seed + 1 + u64::from(index) });
        let start = Instant::now();
        generation = api.post(&path, &body).await?;
        let breed = start.elapsed();
        let pictures = api.pictures(&generation).await?;
        let total = start.elapsed();
        ensure!(pictures == 21, "a brood has 21 pictures, not {pictures}");
        samples.push(Sample { breed, total });
        bar.inc(1);
    }
    bar.finish_and_clear();
    let system: Value = api.get("/v1/system").await?;
    Ok((samples, system.get("backend").cloned().unwrap_or_default()))
}

fn print(args: &BenchBreedArgs, samples: &[Sample], backend: &Value, json: bool) -> Result<()> {
    let total = figures(samples.iter().map(|sample| sample.total));
    let breed = figures(samples.iter().map(|sample| sample.breed));
    let pictures = figures(samples.iter().map(|sample| sample.total - sample.breed));
    if json {
        return output::print_json(&json!({
            "count": args.count,
            "size_px": args.size,
            "pictures_each": 21,
            "backend": backend,
            "total": total,
            "breed": breed,
            "pictures": pictures,
        }));
    }
    let line = |name: &str, f: &Figures| {
        format!(
            "{name:<28} median {:8.2} ms  p99 {:8.2} ms  min {:8.2} ms  max {:8.2} ms\n",
            f.median_ms, f.p99_ms, f.min_ms, f.max_ms
        )
    };
    let head = format!("{} broods, 21 pictures of {} px each\n", args.count, args.size);
    output::print(&format!(
        "{head}{}{}{}",
        line("request to last picture", &total),
        line("  request to 201", &breed),
        line("  201 to last picture", &pictures)
    ))
}

fn figures(times: impl Iterator<Item = Duration>) -> Figures {
    let mut times: Vec<f64> = times.map(|time| time.as_secs_f64() * 1e3).collect();
    times.sort_by(f64::total_cmp);
    let rank = |share: usize| times[(share * times.len()).div_ceil(100).max(1) - 1];
    Figures { median_ms: rank(50), p99_ms: rank(99), min_ms: rank(0), max_ms: rank(100) }
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

    async fn post<T: DeserializeOwned>(&self, path: &str, body: &Value) -> Result<T> {
        let request = self.http.post(format!("{}{path}", self.url)).json(body);
        serde_json::from_slice(&self.send(request).await?).with_context(|| path.to_owned())
    }

    async fn get<T: DeserializeOwned>(&self, path: &str) -> Result<T> {
        let request = self.http.get(format!("{}{path}", self.url));
        serde_json::from_slice(&self.send(request).await?).with_context(|| path.to_owned())
    }

    /// Fetches the pictures of all children and of the centre at once.
    async fn pictures(&self, generation: &Generation) -> Result<usize> {
        let individuals = generation.individuals.iter().chain(&generation.centre);
        let fetch = individuals.map(|individual| async {
            let request = self.http.get(format!("{}{}", self.url, individual.thumbnail));
            let bytes = self.send(request).await?;
            ensure!(bytes.starts_with(b"\x89PNG"), "a thumbnail is not a PNG");
            Ok(())
        });
        Ok(try_join_all(fetch).await?.len())
    }

    async fn send(&self, mut request: RequestBuilder) -> Result<Vec<u8>> {
        if let Some(token) = &self.token {
            request = request.bearer_auth(token);
        }
        let response = request.send().await.context("reach the server")?;
        let status = response.status();
        let body = response.bytes().await.context("read the answer")?;
        if !status.is_success() {
            let text = String::from_utf8_lossy(&body);
            bail!("the server answered {status}: {}", text.chars().take(300).collect::<String>());
        }
        Ok(body.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_taken_by_rank() {
        let found = figures((1..=100).rev().map(Duration::from_millis));
        let got = (found.median_ms, found.p99_ms, found.min_ms, found.max_ms);
        assert_eq!(got, (50.0, 99.0, 1.0, 100.0));
        let one = figures(std::iter::once(Duration::from_millis(7)));
        assert_eq!((one.median_ms, one.p99_ms), (7.0, 7.0));
    }
}
