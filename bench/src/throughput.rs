//! `brood bench throughput`: broods per second of many clients at running servers, and the share of
//! time for which workers that sleep instead of rendering are busy.

mod breeder;
mod tally;

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use brood_protocol::TOKEN_VARIABLE;
use brood_worker::{SleepCounters, SleeperConfig, run_sleepers};
use clap::Args;
use futures::stream::{self, StreamExt, TryStreamExt};
use serde_json::{Value, json};
use tokio::task::JoinSet;
use tokio::time::{sleep, timeout};

use self::breeder::Breeder;
use self::tally::Tally;
use crate::api::Api;
use crate::measure::{median, quantile};
use crate::{logging, output};

/// Options of `brood bench throughput`.
#[derive(Debug, Args)]
pub struct BenchThroughputArgs {
    /// URLs of running servers, as a list with commas; clients are spread over them
    #[arg(long, value_name = "URL", required = true, value_delimiter = ',')]
    server: Vec<String>,
    /// Token of scope breed, if the servers require one
    #[arg(long, value_name = "TOKEN", env = TOKEN_VARIABLE, hide_env_values = true)]
    token: Option<String>,
    /// Number of clients; each breeds in a lineage of its own
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u16).range(1..=4096))]
    clients: u16,
    /// Number of children of each brood
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=256))]
    children: u32,
    /// Measured time in seconds
    #[arg(long, value_name = "S", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=3600))]
    seconds: u32,
    /// Time before the measured one in seconds
    #[arg(long, value_name = "S", default_value_t = 2, value_parser = clap::value_parser!(u32).range(0..=600))]
    warm_up: u32,
    /// Number of workers that sleep instead of rendering, for servers with test data only: each
    /// picture becomes blank. Each client then waits for the pictures of a brood before the next
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=4096))]
    workers: u16,
    /// Time for which a worker sleeps for each picture in milliseconds
    #[arg(long, value_name = "MS", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=60_000))]
    picture_ms: u32,
    /// Token of scope work, for the workers
    #[arg(long, value_name = "TOKEN", env = "BROOD_WORKER_TOKEN", hide_env_values = true)]
    worker_token: Option<String>,
}

/// Number of lineages that are created at a time.
const AT_ONCE: usize = 16;
/// Longest time for the last brood of each client.
const END: Duration = Duration::from_secs(60);
/// Requests for metrics, and the wait between them.
const ATTEMPTS: u32 = 20;
const AGAIN: Duration = Duration::from_millis(100);
/// Gauge of a server: connections of workers.
const WORKER_CONNECTIONS: &str = "brood_worker_connections ";

/// Runs the command.
pub fn run(args: &BenchThroughputArgs, json: bool) -> Result<()> {
    logging::start_offline();
    let runtime = tokio::runtime::Runtime::new().context("start the async runtime")?;
    let measured = runtime.block_on(measure(args));
    // Workers wait for jobs until the process ends.
    runtime.shutdown_background();
    let measured = measured?;
    if json {
        return output::print_json(&measured.json(args));
    }
    output::print(&measured.text(args))
}

/// Result of the command.
struct Measured {
    /// Measured time in seconds.
    seconds: f64,
    /// Times from request to answer in milliseconds, of broods in the measured time.
    times_ms: Vec<f64>,
    /// Number of broods of the whole run.
    all_broods: u64,
    /// Number of refused requests of the whole run.
    refused: u64,
    /// Work of the workers in the measured time.
    slept: Slept,
    /// Number of pictures of the whole run.
    all_pictures: u64,
    /// Largest number of connections of workers at a server.
    worker_connections: u64,
}

/// State of the counters of workers.
#[derive(Debug, Clone, Copy, Default)]
struct Slept {
    jobs: u64,
    pictures: u64,
    us: u64,
}

impl Slept {
    fn now(counters: &SleepCounters) -> Self {
        Self {
            jobs: counters.jobs.load(Ordering::Relaxed),
            pictures: counters.pictures.load(Ordering::Relaxed),
            us: counters.slept_us.load(Ordering::Relaxed),
        }
    }

    fn since(self, earlier: Self) -> Self {
        Self {
            jobs: self.jobs - earlier.jobs,
            pictures: self.pictures - earlier.pictures,
            us: self.us - earlier.us,
        }
    }
}

async fn measure(args: &BenchThroughputArgs) -> Result<Measured> {
    let urls: Vec<&str> = args.server.iter().map(|url| url.trim_end_matches('/')).collect();
    let apis = urls.iter().map(|url| Api::new(url, args.token.clone()).map(Arc::new));
    let apis: Vec<Arc<Api>> = apis.collect::<Result<_>>()?;
    let starts = (0..u64::from(args.clients))
        .zip(apis.iter().cycle())
        .map(|(number, api)| Breeder::new(api.clone(), number, args.children, args.workers > 0));
    let breeders: Vec<Breeder> = stream::iter(starts).buffered(AT_ONCE).try_collect().await?;
    let counters = Arc::<SleepCounters>::default();
    let mut workers: JoinSet<Result<()>> = JoinSet::new();
    if args.workers > 0 {
        let config = SleeperConfig {
            servers: urls.iter().map(|url| (*url).to_owned()).collect(),
            token: args.worker_token.clone().context("--workers needs --worker-token")?,
            workers: args.workers.into(),
            picture: Duration::from_millis(args.picture_ms.into()),
        };
        let counters = counters.clone();
        let sleepers = run_sleepers(config, counters);
        workers.spawn(async move { sleepers.await.map_err(anyhow::Error::from) });
    }
    let tally = Arc::<Tally>::default();
    let mut clients: JoinSet<Result<()>> = JoinSet::new();
    let warm_up = Duration::from_secs(args.warm_up.into());
    for (number, breeder) in (0_u32..).zip(breeders) {
        // Spread over the first half of the warm-up: many first broods at once would be refused.
        let delay = warm_up / 2 * number / u32::from(args.clients);
        clients.spawn(breeder.run(delay, tally.clone()));
    }
    wait(warm_up, &mut clients, &mut workers).await?;
    tally.open();
    let (start, before) = (Instant::now(), Slept::now(&counters));
    let time = Duration::from_secs(args.seconds.into());
    wait(time, &mut clients, &mut workers).await?;
    let times_ms = tally.close();
    let (seconds, after) = (start.elapsed().as_secs_f64(), Slept::now(&counters));
    let mut worker_connections = 0;
    for api in &apis {
        worker_connections = worker_connections.max(connections_at(api).await?);
    }
    let end = async {
        while let Some(ended) = clients.join_next().await {
            ended.context("run a client")??;
        }
        Ok::<_, anyhow::Error>(())
    };
    match timeout(END, end).await {
        Ok(ended) => ended?,
        Err(_) => tracing::warn!("the last broods of some clients took too long"),
    }
    let (all_broods, refused) = tally.totals();
    Ok(Measured {
        seconds,
        times_ms,
        all_broods,
        refused,
        slept: after.since(before),
        all_pictures: Slept::now(&counters).pictures,
        worker_connections,
    })
}

/// Waits. Error if a client or the workers end meanwhile.
async fn wait(
    time: Duration,
    clients: &mut JoinSet<Result<()>>,
    workers: &mut JoinSet<Result<()>>,
) -> Result<()> {
    let (who, ended) = tokio::select! {
        () = sleep(time) => return Ok(()),
        Some(ended) = clients.join_next() => ("client", ended),
        Some(ended) = workers.join_next() => ("worker", ended),
    };
    ended.with_context(|| format!("run a {who}"))??;
    bail!("a {who} ended early")
}

/// Asks a server for its number of connections of workers.
async fn connections_at(api: &Api) -> Result<u64> {
    for _ in 0..ATTEMPTS {
        if let Some(metrics) = api.text_unless_busy("/metrics").await? {
            return Ok(connections(&metrics));
        }
        sleep(AGAIN).await;
    }
    bail!("the server is too busy to answer GET /metrics")
}

/// Reads the number of connections of workers from the metrics of a server; 0 if it is not there.
fn connections(metrics: &str) -> u64 {
    let value = metrics.lines().find_map(|line| line.strip_prefix(WORKER_CONNECTIONS));
    value.and_then(|value| value.trim().parse::<f64>().ok()).map_or(0, |value| value as u64)
}

impl Measured {
    fn broods_per_s(&self) -> f64 {
        self.times_ms.len() as f64 / self.seconds
    }

    /// Share of the time of all workers for which they were busy, by the stated time of a picture.
    fn busy(&self, args: &BenchThroughputArgs) -> f64 {
        let stated_s = self.slept.pictures as f64 * f64::from(args.picture_ms) / 1e3;
        stated_s / (f64::from(args.workers) * self.seconds)
    }

    /// The same by the time that they slept. More than the stated one if the machine is busy.
    fn slept(&self, args: &BenchThroughputArgs) -> f64 {
        self.slept.us as f64 / 1e6 / (f64::from(args.workers) * self.seconds)
    }

    fn json(&self, args: &BenchThroughputArgs) -> Value {
        let broods_per_s = self.broods_per_s();
        let mut report = json!({
            "servers": args.server.len(),
            "clients": args.clients,
            "children": args.children,
            "seconds": self.seconds,
            "broods": self.times_ms.len(),
            "broods_per_s": broods_per_s,
            "children_per_s": broods_per_s * f64::from(args.children),
            "median_ms": median(&self.times_ms),
            "p99_ms": quantile(&self.times_ms, 0.99),
            "all_broods": self.all_broods,
            "all_refused": self.refused,
        });
        if args.workers > 0 {
            report["workers"] = json!({
                "count": args.workers,
                "picture_ms": args.picture_ms,
                "jobs": self.slept.jobs,
                "pictures": self.slept.pictures,
                "pictures_per_s": self.slept.pictures as f64 / self.seconds,
                "busy": self.busy(args),
                "slept": self.slept(args),
                "all_pictures": self.all_pictures,
                "connections": self.worker_connections,
            });
        }
        report
    }

    fn text(&self, args: &BenchThroughputArgs) -> String {
        let mut text = format!(
            "{} clients at {} servers, broods of {}, {:.1} s\n{:.1} broods/s, median {:.1} ms, p99 {:.1} ms, \
             {} requests refused in the whole run\n",
            args.clients,
            args.server.len(),
            args.children,
            self.seconds,
            self.broods_per_s(),
            median(&self.times_ms),
            quantile(&self.times_ms, 0.99),
            self.refused,
        );
        if args.workers > 0 {
            text += &format!(
                "{} workers that sleep {} ms a picture: {:.1} % busy, {:.0} pictures/s, {} connections at a server\n",
                args.workers,
                args.picture_ms,
                100.0 * self.busy(args),
                self.slept.pictures as f64 / self.seconds,
                self.worker_connections,
            );
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        args: BenchThroughputArgs,
    }

    #[test]
    fn busy_share_is_the_stated_time_of_the_pictures() {
        let words = ["x", "--server", "http://a,http://b", "--workers", "4", "--clients", "6"];
        let args = Line::parse_from(words).args;
        let measured = Measured {
            seconds: 10.0,
            times_ms: vec![5.0; 30],
            all_broods: 40,
            refused: 2,
            slept: Slept { jobs: 90, pictures: 1800, us: 38_000_000 },
            all_pictures: 2000,
            worker_connections: 17,
        };
        let report = measured.json(&args);
        assert_eq!((&report["servers"], &report["broods_per_s"]), (&json!(2), &json!(3.0)));
        let workers = &report["workers"];
        assert_eq!((&workers["busy"], &workers["slept"]), (&json!(0.9), &json!(0.95)));
        assert!(measured.text(&args).contains("90.0 % busy, 180 pictures/s, 17 connections"));
    }

    #[test]
    fn connections_of_workers_are_read_from_metrics() {
        let text = "# TYPE brood_worker_connections gauge\nbrood_worker_connections 12\nother 3\n";
        assert_eq!((connections(text), connections("")), (12, 0));
    }
}
