//! One measurement of searches on a new database with one server and two workers: a search with
//! islands, or as many searches without.

use std::path::Path;
use std::process::{Child, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};
use serde_json::{Value, json};

use super::http::Client;
use super::sample::{Lab, since};
use super::{cpu, glossy};
use crate::shell;

/// Strategy of the searches, whose programs migrate.
pub const STRATEGY: &str = "gp";
/// Generations of each search without islands, and of each island.
pub const GENERATIONS: u32 = 128;
/// Generations of the search before the measurement.
const FIRST_GENERATIONS: u32 = 8;
/// Samples of the target.
pub const SAMPLES: usize = 600;
/// Number of workers. Each has up to four searches at a time, so that up to eight run at once.
pub const WORKERS: u32 = 2;
/// Time between two questions whether a search has ended.
pub const INTERVAL: Duration = Duration::from_millis(100);
/// Longest time until the last search has ended.
const LONGEST: Duration = Duration::from_secs(600);
/// Seed of the first search; each further one has the next.
const SEED: u32 = 1;

/// Division of the work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    /// One search with islands.
    Islands,
    /// Searches without islands.
    Searches,
}

/// Searches that run at the same time.
#[derive(Debug, Clone, Copy)]
pub struct Plan {
    /// Division of the work.
    pub way: Way,
    /// Number of islands, or of searches.
    pub count: u32,
}

/// Searches that have ended.
#[derive(Debug, Clone)]
pub struct Searched {
    /// Time from the start of the first to the end of the last in seconds.
    pub run_s: f64,
    /// CPU time of the server in seconds.
    pub server_s: f64,
    /// CPU time of PostgreSQL in seconds.
    pub database_s: f64,
    /// CPU time of the workers in seconds.
    pub workers_s: f64,
    /// Least E_log of a material on the validation samples.
    pub e_log: f64,
    /// Operations of that material.
    pub operations: f64,
}

impl Plan {
    /// Runs the searches.
    pub fn measure(self, lab: &Lab) -> Result<Searched> {
        println!("{self:?}");
        let searched = lab.on_new_database(|database| self.measure_on(lab, database))?;
        println!("  {:.2} s", searched.run_s);
        Ok(searched)
    }

    fn measure_on(self, lab: &Lab, database: &str) -> Result<Searched> {
        let server = lab.server_on(database)?;
        let client = Client::new(server.url(), lab.token(&server, "breed", database)?)?;
        let token = lab.token(&server, "work", database)?;
        // Dropped before the server.
        let mut workers = Searchers::start(lab.brood(), server.url(), &token)?;
        let spec = json!({ "kind": "samples", "name": "glossy" });
        let target = client.upload("/v1/targets", &spec, &glossy::csv(SAMPLES))?;
        let target = text(&target, "id")?;
        // A short one first: its end shows that workers are connected.
        run(&client, &mut workers, &[body(target, SEED, FIRST_GENERATIONS, 1)])?;
        let before = [server.cpu_s()?, lab.database_s()?, workers.cpu_s()?];
        let jobs = run(&client, &mut workers, &self.bodies(target))?;
        let after = [server.cpu_s()?, lab.database_s()?, workers.cpu_s()?];
        let [server_s, database_s, workers_s] = since(before, after);
        let Outcome { run_s, e_log, operations } = Outcome::of(&jobs)?;
        Ok(Searched { run_s, server_s, database_s, workers_s, e_log, operations })
    }

    /// Requests for the searches.
    fn bodies(self, target: &str) -> Vec<Value> {
        let (searches, islands) = match self.way {
            Way::Islands => (1, self.count),
            Way::Searches => (self.count, 1),
        };
        (0..searches).map(|number| body(target, SEED + number, GENERATIONS, islands)).collect()
    }
}

impl Searched {
    /// The searches for the report.
    pub fn json(&self) -> Value {
        json!({
            "run_s": self.run_s,
            "cpu_s": { "server": self.server_s, "database": self.database_s, "workers": self.workers_s },
            "e_log": self.e_log,
            "operations": self.operations,
        })
    }
}

/// Result of searches that have ended.
#[derive(Debug, PartialEq)]
struct Outcome {
    run_s: f64,
    e_log: f64,
    operations: f64,
}

impl Outcome {
    /// Time by the server's clock, which is more exact than the questions, and the best material.
    fn of(jobs: &[Value]) -> Result<Self> {
        let all = |pointer: &str| -> Result<Vec<f64>> {
            jobs.iter().map(|job| number(job, pointer)).collect()
        };
        let start_ms = all("/created_ms")?.into_iter().fold(f64::INFINITY, f64::min);
        let end_ms = all("/ended_ms")?.into_iter().fold(f64::NEG_INFINITY, f64::max);
        let best = all("/best/e_log")?.into_iter().zip(all("/best/operations")?);
        let best = best.min_by(|a, b| a.0.total_cmp(&b.0));
        let (e_log, operations) = best.context("find a search that has ended")?;
        Ok(Self { run_s: (end_ms - start_ms) / 1e3, e_log, operations })
    }
}

/// Processes that search, killed when they are dropped.
struct Searchers(Vec<Child>);

impl Searchers {
    fn start(brood: &Path, url: &str, token: &str) -> Result<Self> {
        let mut all = Self(Vec::new());
        for _ in 0..WORKERS {
            let mut command = shell::command(brood);
            command.args(["worker", "--server", url, "--searches", "--threads", "1"]);
            command.args(["--backend", "cpu"]).env("BROOD_LOG", "error").stdout(Stdio::null());
            command.env("BROOD_TOKEN", token).env_remove("BROOD_TOKEN_FILE");
            all.0.push(command.spawn().context("start a worker")?);
        }
        Ok(all)
    }

    /// CPU time that they have used, in seconds.
    fn cpu_s(&self) -> Result<f64> {
        self.0.iter().map(|worker| cpu::own(worker.id())).sum()
    }

    /// Error if one of them has ended.
    fn check(&mut self) -> Result<()> {
        for worker in &mut self.0 {
            if let Some(status) = worker.try_wait().context("look at a worker")? {
                bail!("a worker ended with {status} before the searches");
            }
        }
        Ok(())
    }
}

impl Drop for Searchers {
    fn drop(&mut self) {
        for worker in &mut self.0 {
            // It may have ended already.
            let _ = worker.kill();
            let _ = worker.wait();
        }
    }
}

/// Request for a search.
fn body(target: &str, seed: u32, generations: u32, islands: u32) -> Value {
    json!({
        "kind": "fit",
        "target": target,
        "strategy": STRATEGY,
        "seed": seed.to_string(),
        "threads": 1,
        "generations": generations,
        "islands": islands,
    })
}

/// Starts searches, and returns them when all have ended.
fn run(client: &Client, workers: &mut Searchers, bodies: &[Value]) -> Result<Vec<Value>> {
    let start = Instant::now();
    let mut ids = Vec::new();
    for body in bodies {
        let job = client.post("/v1/jobs", body)?;
        ids.push(text(&job, "id")?.to_owned());
    }
    // One after the other: the server gets as many questions about searches as about islands.
    ids.iter().map(|id| wait(client, workers, id, start)).collect()
}

/// Waits until a search has ended, and returns it.
fn wait(client: &Client, workers: &mut Searchers, id: &str, start: Instant) -> Result<Value> {
    loop {
        let job = client.get(&format!("/v1/jobs/{id}"))?;
        let state = text(&job, "state")?;
        ensure!(!["failed", "cancelled"].contains(&state), "a search did not succeed: {job}");
        if state == "succeeded" {
            return Ok(job);
        }
        workers.check()?;
        let is_early = start.elapsed() < LONGEST;
        ensure!(is_early, "a search has not ended after {} s: {job}", LONGEST.as_secs());
        thread::sleep(INTERVAL);
    }
}

/// Field of an answer.
fn text<'a>(answer: &'a Value, field: &str) -> Result<&'a str> {
    answer[field].as_str().with_context(|| format!("find {field} in {answer}"))
}

/// Number in an answer.
fn number(answer: &Value, pointer: &str) -> Result<f64> {
    let found = answer.pointer(pointer).and_then(Value::as_f64);
    found.with_context(|| format!("find {pointer} in {answer}"))
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::{GENERATIONS, Outcome, Plan, Way};

    #[test]
    fn plan_is_a_search_with_islands_or_searches_with_seeds_of_their_own() {
        let of = |way| {
            let bodies = Plan { way, count: 3 }.bodies("t");
            assert!(bodies.iter().all(|body| body["generations"] == GENERATIONS), "{bodies:?}");
            let key = |body: &serde_json::Value| json!([body["seed"], body["islands"]]);
            bodies.iter().map(key).collect::<Vec<_>>()
        };
        assert_eq!(of(Way::Islands), [json!(["1", 3])]);
        assert_eq!(of(Way::Searches), [json!(["1", 1]), json!(["2", 1]), json!(["3", 1])]);
    }

    #[test]
    fn outcome_is_the_whole_time_and_the_best_material() {
        let job = |created: i64, ended: i64, e_log: f64, operations: u32| {
            let best = json!({ "e_log": e_log, "operations": operations });
            json!({ "created_ms": created, "ended_ms": ended, "best": best })
        };
        let jobs = [job(1_000, 5_000, 0.2, 30), job(1_500, 4_000, 0.1, 50)];
        let outcome = Outcome::of(&jobs).unwrap();
        assert_eq!(outcome, Outcome { run_s: 4.0, e_log: 0.1, operations: 50.0 });
        let unended = json!({ "created_ms": 1, "ended_ms": null, "best": null });
        let error = Outcome::of(&[unended]).unwrap_err();
        assert!(error.to_string().starts_with("find /ended_ms in"), "{error}");
        assert!(Outcome::of(&[]).is_err());
    }
}
