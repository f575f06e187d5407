//! One measurement: servers on a new database under load, with the CPU time and the disk space that
//! each part has used.

use std::cell::Cell;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use anyhow::{Context, Result};
use serde_json::{Value, json};

use super::cpu;
use super::server::Server;
use super::statistics::quartiles;
use crate::bench::environment::json_of;
use crate::postgres::{Cluster, DATABASE};
use crate::shell;

/// Seconds of load before each measurement.
const WARM_UP_S: &str = "5";
/// Sizes of a database in bytes: all of it, the indices of its tables, and the log written so far.
const SIZES: &str = "SELECT pg_database_size(current_database()), \
    (SELECT coalesce(sum(pg_indexes_size(oid)), 0) FROM pg_class WHERE relkind = 'r' \
    AND relnamespace NOT IN (SELECT oid FROM pg_namespace WHERE nspname LIKE 'pg\\_%' \
    OR nspname = 'information_schema')), \
    pg_wal_lsn_diff(pg_current_wal_insert_lsn(), '0/0')";

/// Engine of a database.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Engine {
    /// Embedded, in the process of the only server.
    Sqlite,
    /// Shared by all servers.
    Postgres,
}

impl Engine {
    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sqlite => "SQLite",
            Self::Postgres => "PostgreSQL",
        }
    }
}

/// Servers, and the load on them.
#[derive(Debug, Clone, Copy)]
pub struct Load {
    /// Engine of the database.
    pub engine: Engine,
    /// Number of servers.
    pub servers: u32,
    /// Share of one processor that each server may use; `None` for no quota.
    pub quota: Option<f64>,
    /// Number of clients of all servers.
    pub clients: u32,
    /// Number of children of each brood.
    pub children: u32,
    /// Number of workers that sleep; without any, no pictures are made.
    pub workers: u32,
    /// Time for which a worker sleeps for each picture in milliseconds.
    pub picture_ms: u32,
}

impl Load {
    /// One server on PostgreSQL without quota and workers.
    pub fn new(clients: u32, children: u32) -> Self {
        let engine = Engine::Postgres;
        Self { engine, servers: 1, quota: None, clients, children, workers: 0, picture_ms: 20 }
    }

    /// The load for the report.
    fn json(&self) -> Value {
        json!({
            "engine": self.engine.name(),
            "servers": self.servers,
            "quota": self.quota,
            "clients": self.clients,
            "children": self.children,
            "workers": self.workers,
            "picture_ms": self.picture_ms,
        })
    }
}

/// Result of a measurement. CPU time and bytes are those of the whole run, warm-up included.
#[derive(Debug, Clone)]
pub struct Sample {
    /// Report of `brood bench throughput`.
    pub report: Value,
    /// CPU time of all servers in seconds.
    pub server_s: f64,
    /// CPU time of PostgreSQL in seconds.
    pub database_s: f64,
    /// CPU time of clients and sleeping workers in seconds.
    pub load_s: f64,
    /// Time of the whole run in seconds.
    pub run_s: f64,
    /// Growth of the database in bytes; 0 on SQLite, as the two below.
    pub database_bytes: f64,
    /// Growth of the indices in bytes.
    pub index_bytes: f64,
    /// Growth of the write-ahead log in bytes.
    pub log_bytes: f64,
}

impl Sample {
    /// Number of the report; NaN if it is null, as are quantiles of no values.
    pub fn number(&self, pointer: &str) -> Result<f64> {
        let value = self.report.pointer(pointer);
        let value = value.filter(|value| value.is_number() || value.is_null());
        let value = value.with_context(|| format!("find {pointer} in {}", self.report))?;
        Ok(value.as_f64().unwrap_or(f64::NAN))
    }

    /// Acknowledged broods per second.
    pub fn broods_per_s(&self) -> Result<f64> {
        self.number("/broods_per_s")
    }

    /// Broods of the whole run.
    pub fn all_broods(&self) -> Result<f64> {
        Ok(self.number("/all_broods")?.max(1.0))
    }

    /// Processors that were used on average: by servers, PostgreSQL, and load.
    pub fn cores(&self) -> [f64; 3] {
        [self.server_s, self.database_s, self.load_s].map(|seconds| seconds / self.run_s)
    }

    /// CPU time for each brood in milliseconds: of servers, PostgreSQL, and load.
    pub fn cpu_ms(&self) -> Result<[f64; 3]> {
        let broods = self.all_broods()?;
        Ok([self.server_s, self.database_s, self.load_s].map(|seconds| 1e3 * seconds / broods))
    }

    /// Bytes for each brood: of the database, of its indices among them, and of the log.
    pub fn bytes(&self) -> Result<[f64; 3]> {
        let broods = self.all_broods()?;
        Ok([self.database_bytes, self.index_bytes, self.log_bytes].map(|bytes| bytes / broods))
    }

    /// The sample for the report.
    pub fn json(&self) -> Value {
        json!({
            "report": self.report,
            "run_s": self.run_s,
            "cpu_s": { "servers": self.server_s, "database": self.database_s, "load": self.load_s },
            "bytes": { "database": self.database_bytes, "indices": self.index_bytes, "log": self.log_bytes },
        })
    }
}

/// Differences of three counters.
pub fn since(before: [f64; 3], after: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|at| after[at] - before[at])
}

/// Machine under test: the binary, the cluster, and a folder for data directories.
pub struct Lab {
    brood: PathBuf,
    cluster: Cluster,
    folder: PathBuf,
    seconds: u32,
    count: Cell<u32>,
}

impl Lab {
    /// Starts PostgreSQL.
    pub fn new(brood: &Path, seconds: u32) -> Result<Self> {
        let folder = std::env::temp_dir().join(format!("brood-scale-{}", std::process::id()));
        let cluster = Cluster::start()?;
        Ok(Self { brood: brood.to_owned(), cluster, folder, seconds, count: Cell::new(0) })
    }

    /// Version of PostgreSQL.
    pub fn version(&self) -> Result<String> {
        self.cluster.query(DATABASE, "SHOW server_version")
    }

    /// Settings of PostgreSQL on which the durability of a commit depends.
    pub fn durability(&self) -> Result<String> {
        let names = ["fsync", "synchronous_commit", "full_page_writes", "wal_sync_method"];
        let show =
            |name| Ok(format!("{name} {}", self.cluster.query(DATABASE, &format!("SHOW {name}"))?));
        Ok(names.into_iter().map(show).collect::<Result<Vec<_>>>()?.join(", "))
    }

    /// Path of the binary.
    pub fn brood(&self) -> &Path {
        &self.brood
    }

    /// Measures one load on new servers with a new database.
    pub fn measure(&self, load: &Load) -> Result<Sample> {
        if load.engine == Engine::Sqlite {
            return self.measure_on(load, &self.new_name(), None);
        }
        self.on_new_database(|name| self.measure_on(load, name, Some(name)))
    }

    /// Measures something on a new database of PostgreSQL, given its name, and removes it.
    pub fn on_new_database<T>(&self, measure: impl FnOnce(&str) -> Result<T>) -> Result<T> {
        let name = self.new_name();
        self.cluster.query(DATABASE, &format!("CREATE DATABASE {name}"))?;
        self.cluster.query(DATABASE, "CHECKPOINT")?;
        let measured = measure(&name);
        self.cluster.query(DATABASE, &format!("DROP DATABASE {name} WITH (FORCE)"))?;
        measured
    }

    /// Starts the only server on a database, without quota.
    pub fn server_on(&self, database: &str) -> Result<Server> {
        let address = self.cluster.address_of(database);
        Server::start(&self.brood, &self.folder.join(database), Some(address.as_str()))
    }

    /// Adds a token of a scope at a server on a database; returns it.
    pub fn token(&self, server: &Server, scope: &str, database: &str) -> Result<String> {
        let address = self.cluster.address_of(database);
        server.add_token(&self.brood, scope, Some(address.as_str()))
    }

    /// CPU time that PostgreSQL has used, in seconds.
    pub fn database_s(&self) -> Result<f64> {
        cpu::with_children(self.cluster.process()?)
    }

    fn new_name(&self) -> String {
        self.count.set(self.count.get() + 1);
        format!("scale{}", self.count.get())
    }

    fn measure_on(&self, load: &Load, name: &str, database: Option<&str>) -> Result<Sample> {
        println!("{load:?}");
        let address = database.map(|database| self.cluster.address_of(database));
        let mut servers = Vec::new();
        for number in 0..load.servers {
            let data = self.folder.join(format!("{name}-{number}"));
            let mut server = Server::start(&self.brood, &data, address.as_deref())?;
            if let Some(share) = load.quota {
                server.limit(share)?;
            }
            servers.push(server);
        }
        let mut command = self.command(load, &servers);
        if load.workers > 0
            && let Some(first) = servers.first()
        {
            let token = |scope| first.add_token(&self.brood, scope, address.as_deref());
            command.env("BROOD_TOKEN", token("breed")?);
            command.env("BROOD_WORKER_TOKEN", token("work")?);
        }
        let sizes = || database.map_or(Ok([0.0; 3]), |database| self.sizes(database));
        let (small, before) = (sizes()?, self.cpu_s(&servers)?);
        let start = Instant::now();
        let report = json_of(&mut command)?;
        let run_s = start.elapsed().as_secs_f64();
        let [server_s, database_s, load_s] = since(before, self.cpu_s(&servers)?);
        let [database_bytes, index_bytes, log_bytes] = since(small, sizes()?);
        let sample = Sample {
            report,
            server_s,
            database_s,
            load_s,
            run_s,
            database_bytes,
            index_bytes,
            log_bytes,
        };
        println!("  {:.1} broods/s", sample.broods_per_s()?);
        Ok(sample)
    }

    /// Command that loads the servers.
    fn command(&self, load: &Load, servers: &[Server]) -> Command {
        let urls: Vec<&str> = servers.iter().map(Server::url).collect();
        let mut command = shell::command(&self.brood);
        command.args(["bench", "throughput", "--json", "--warm-up", WARM_UP_S]);
        command.args(["--server", &urls.join(",")]);
        for (option, value) in [
            ("--seconds", self.seconds),
            ("--clients", load.clients),
            ("--children", load.children),
            ("--workers", load.workers),
            ("--picture-ms", load.picture_ms),
        ] {
            command.args([option, &value.to_string()]);
        }
        command.env_remove("BROOD_TOKEN");
        command
    }

    /// Measures each load once a round. Returns the samples of each.
    pub fn rounds<K: Copy>(
        &self,
        rounds: u32,
        keys: &[K],
        load: impl Fn(K) -> Load,
    ) -> Result<Vec<(K, Vec<Sample>)>> {
        let mut all: Vec<(K, Vec<Sample>)> = keys.iter().map(|key| (*key, Vec::new())).collect();
        for _ in 0..rounds {
            for (key, samples) in &mut all {
                samples.push(self.measure(&load(*key))?);
            }
        }
        Ok(all)
    }

    /// CPU time in seconds of servers, PostgreSQL and load.
    fn cpu_s(&self, servers: &[Server]) -> Result<[f64; 3]> {
        let server_s = servers.iter().map(Server::cpu_s).sum::<Result<f64>>()?;
        Ok([server_s, self.database_s()?, cpu::of_ended_children()?])
    }

    fn sizes(&self, database: &str) -> Result<[f64; 3]> {
        let row = self.cluster.query(database, SIZES)?;
        let numbers: Vec<f64> =
            row.split('|').filter_map(|word| word.trim().parse().ok()).collect();
        numbers.try_into().ok().with_context(|| format!("read the sizes of a database from {row}"))
    }
}

impl Drop for Lab {
    fn drop(&mut self) {
        // Missing if no server has started.
        if self.folder.exists()
            && let Err(error) = std::fs::remove_dir_all(&self.folder)
        {
            eprintln!("cannot remove {}: {error}", self.folder.display());
        }
    }
}

/// Samples of a series as JSON.
pub fn json_of_series<K: Copy>(series: &[(K, Vec<Sample>)], load: impl Fn(K) -> Load) -> Value {
    let each = series.iter().map(|(key, samples)| {
        let samples: Vec<Value> = samples.iter().map(Sample::json).collect();
        json!({ "load": load(*key).json(), "samples": samples })
    });
    Value::Array(each.collect())
}

/// Quartiles of a figure over samples.
pub fn spread(samples: &[Sample], figure: impl Fn(&Sample) -> Result<f64>) -> Result<[f64; 3]> {
    let values: Vec<f64> = samples.iter().map(figure).collect::<Result<_>>()?;
    Ok(quartiles(&values))
}
