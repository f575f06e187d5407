//! `brood bench breed`: times broods of 20 children, from the request to the last of 21 pictures
//! (the parent's included), and splits that time into stages.

mod load;
mod search;
mod stage;

use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};
use brood_protocol::{Backend, Generation, Lineage, TOKEN_VARIABLE};
use clap::Args;
use serde_json::{Value, json};

use self::load::Load;
use self::search::Searches;
use self::stage::{Sample, figures, slowest, stages};
use super::own_server::OwnServer;
use crate::api::Api;
use crate::{logging, output};

/// Options of `brood bench breed`.
#[derive(Debug, Args)]
pub struct BenchBreedArgs {
    /// URL of a running server; by default one is started on a temporary directory
    #[arg(long, value_name = "URL")]
    server: Option<String>,
    /// Token of scope breed, if the server requires one
    #[arg(long, value_name = "TOKEN", env = TOKEN_VARIABLE, hide_env_values = true, requires = "server")]
    token: Option<String>,
    /// Number of broods
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    count: u32,
    /// Side of a thumbnail in pixels
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(16..=1024))]
    size: u32,
    /// Number of worker processes of the started server
    #[arg(long, value_name = "N", default_value_t = 1, conflicts_with = "server")]
    workers: u16,
    /// Evaluator of the started server: auto, cpu, gpu or reference
    #[arg(long, value_name = "BACKEND", default_value = "auto", conflicts_with = "server")]
    backend: Backend,
    /// Number of searches; with N > 0 as many broods again are bred while N searches run, in turns
    /// with undisturbed ones
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=16))]
    searches: u16,
    /// Breeds as many broods again while other clients ask for long work
    #[arg(long, value_name = "LOAD", conflicts_with = "searches")]
    beside: Option<Load>,
    /// Seed of the first brood; later broods use the numbers after it
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// Broods between pausing and resuming the searches: a few seconds, enough for a second generation
/// of each search.
const TURN: u32 = 100;
/// Time for a load to fill the queues.
const WARM_UP: Duration = Duration::from_secs(2);
/// Number of slowest broods printed one by one.
const SLOWEST: usize = 8;

/// Runs the command.
pub fn run(args: &BenchBreedArgs, json: bool) -> Result<()> {
    logging::start_offline();
    let runtime = tokio::runtime::Runtime::new().context("start the async runtime")?;
    runtime.block_on(async {
        let own = match &args.server {
            Some(_) => None,
            None => Some(OwnServer::start(args.workers, args.backend).await?),
        };
        let url = own.as_ref().map(OwnServer::url).or(args.server.as_deref());
        let url =
            url.context("neither --server was given nor a server started")?.trim_end_matches('/');
        let result = measure(args, url).await;
        if let Some(own) = own {
            own.stop().await?;
        }
        let measured = result?;
        if json {
            return output::print_json(&measured.json(args));
        }
        output::print(&measured.text(args))
    })
}

/// Measured times.
struct Measured {
    /// Without searches.
    alone: Vec<Sample>,
    /// While searches run.
    beside: Vec<Sample>,
    /// Generations completed by the searches meanwhile.
    generations: u64,
    /// Evaluator, as the server reports it.
    backend: Value,
}

/// Breeds all broods, each from a child of the last.
async fn measure(args: &BenchBreedArgs, url: &str) -> Result<Measured> {
    let api = Arc::new(Api::new(url, args.token.clone())?);
    let body = json!({ "name": "bench", "thumbnail_px": args.size });
    let (lineage, _): (Lineage, _) = api.post("/v1/lineages", &body).await?;
    let path = format!("/v1/lineages/{}/generations", lineage.id);
    // An untimed random start: it builds the mesh and the sample set, opens the connections and
    // provides a parent.
    let (mut generation, _): (Generation, _) =
        api.post(&path, &json!({ "seed": args.seed })).await?;
    api.pictures(&generation).await?;
    let searches = Searches::begin(&api, args.searches).await?;
    let has_searches = args.searches > 0;
    let has_company = has_searches || args.beside.is_some();
    let all = if has_company { 2 * args.count } else { args.count };
    let bar = output::bar(all.into(), "breeding");
    let (mut alone, mut beside) = (Vec::new(), Vec::new());
    let (mut index, mut load) = (0, None);
    while index < all {
        if let Some(kind) = args.beside
            && index >= args.count
            && load.is_none()
        {
            load = Some(kind.begin(&api, &generation));
            tokio::time::sleep(WARM_UP).await;
        }
        let is_beside = load.is_some() || has_searches && (index / TURN) % 2 == 1;
        if is_beside && has_searches {
            searches.resume(&api).await?;
        }
        let end = if load.is_none() && args.beside.is_some() { args.count } else { all };
        for _ in 0..TURN.min(end - index) {
            let parents = &generation.individuals;
            let parent = parents[index as usize % parents.len()].id;
            let body = json!({ "parents": [parent], "seed": args.seed + 1 + u64::from(index) });
            let sample;
            (generation, sample) = brood(&api, &path, &body).await?;
            if is_beside { &mut beside } else { &mut alone }.push(sample);
            index += 1;
            bar.inc(1);
        }
        if is_beside && has_searches {
            searches.pause(&api).await?;
        }
    }
    bar.finish_and_clear();
    drop(load);
    let generations = searches.end(&api).await?;
    let system: Value = api.get("/v1/system").await?;
    let backend = system.get("backend").cloned().unwrap_or_default();
    Ok(Measured { alone, beside, generations, backend })
}

/// Breeds one brood and fetches all its pictures.
async fn brood(api: &Api, path: &str, body: &Value) -> Result<(Generation, Sample)> {
    let start = Instant::now();
    let (generation, headers): (Generation, _) = api.post(path, body).await?;
    let breed = start.elapsed();
    let pictures = api.pictures(&generation).await?;
    let total = start.elapsed();
    ensure!(pictures == 21, "expected 21 pictures of a brood, got {pictures}");
    let job = match stage::job_path(&headers) {
        Some(path) => Some(api.get(path).await?),
        None => None,
    };
    let server = stage::server_timing(&headers);
    Ok((generation, Sample { breed, total, server, job }))
}

impl Measured {
    fn json(&self, args: &BenchBreedArgs) -> Value {
        let by_key = |samples: &[Sample]| -> serde_json::Map<String, Value> {
            let stages = stages(samples).into_iter();
            stages.map(|(stage, times)| (stage.key.to_owned(), json!(figures(times)))).collect()
        };
        let alone = by_key(&self.alone);
        let mut told = json!({
            "count": args.count,
            "size_px": args.size,
            "pictures_each": 21,
            "backend": self.backend,
            "total": alone.get("total"),
            "breed": alone.get("breed"),
            "pictures": alone.get("pictures"),
            "stages": alone,
            "slowest": slowest(&self.alone, SLOWEST),
        });
        match args.beside {
            Some(load) => {
                told["beside"] = load.name().into();
                told["beside_load"] = json!(by_key(&self.beside));
            }
            None if !self.beside.is_empty() => {
                told["searches"] = args.searches.into();
                told["search_generations"] = self.generations.into();
                told["beside_searches"] = json!(by_key(&self.beside));
            }
            None => {}
        }
        told
    }

    fn text(&self, args: &BenchBreedArgs) -> String {
        let mut text = format!("{} broods, 21 pictures of {} px each\n", args.count, args.size);
        text += &rows(&self.alone);
        text += &slow_rows(&self.alone);
        if !self.beside.is_empty() {
            text += &match args.beside {
                Some(load) => format!("\nas many broods beside {}\n", load.name()),
                None => format!(
                    "\nas many broods while {} searches ran ({} generations), in turns of {TURN} broods\n",
                    args.searches, self.generations
                ),
            };
            text += &rows(&self.beside);
            text += &slow_rows(&self.beside);
            let of = |samples: &[Sample]| figures(samples.iter().map(|sample| sample.total));
            let (alone, beside) = (of(&self.alone), of(&self.beside));
            text += &format!(
                "\nrequest to last picture, beside over alone: median {:.2}, p99 {:.2} (goal: 2)\n",
                beside.median_ms / alone.median_ms,
                beside.p99_ms / alone.p99_ms
            );
        }
        text
    }
}

/// Returns a line for each stage.
fn rows(samples: &[Sample]) -> String {
    let row = |(stage, times): (stage::StageName, Vec<_>)| {
        let f = figures(times);
        format!(
            "{:<38} median {:8.2} ms  p99 {:8.2} ms  min {:8.2} ms  max {:8.2} ms\n",
            stage.label, f.median_ms, f.p99_ms, f.min_ms, f.max_ms
        )
    };
    stages(samples).into_iter().map(row).collect()
}

/// Returns a line for each of the slowest broods.
fn slow_rows(samples: &[Sample]) -> String {
    let mut text = String::from(
        "\nthe slowest      total    breed   commit   render     film  sets made  rough samples\n",
    );
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
    text
}
