//! Share of time for which workers that sleep are busy. Each client breeds a brood of 20, waits for
//! the last of its pictures, and breeds the next; a brood is one job of about 20 pictures.

use std::fmt::Write;

use anyhow::{Context, Result};

use super::goal::Goal;
use super::sample::{Lab, Load, Sample, json_of_series, spread};

/// Number of servers, of workers, and milliseconds of a picture.
type Key = (u32, u32, u32);

/// Measured numbers. With pictures of 100 ms, 256 workers do as much work as 51 of 20 ms.
const KEYS: [Key; 9] = [
    (1, 1, 20),
    (1, 4, 20),
    (1, 16, 20),
    (1, 64, 20),
    (1, 128, 20),
    (1, 256, 20),
    (1, 256, 100),
    (2, 64, 20),
    (2, 256, 20),
];
const CHILDREN: u32 = 20;
/// Goals: numbers with their least share of busy time.
const GOALS: [(Key, f64); 2] = [((1, 64, 20), 0.95), ((1, 256, 20), 0.9)];
/// Number whose CPU time is that of a picture in the load model.
const MODEL: Key = (1, 16, 20);
/// Number whose connections at a server count in the load model.
const AT_SEVERAL: Key = (2, 64, 20);
/// Most clients, below the connections of a server that are not those of workers.
const MOST_CLIENTS: u32 = 480;

/// Measured workers.
pub struct Workers {
    cells: Vec<(Key, Vec<Sample>)>,
}

impl Workers {
    /// Measures all numbers in turn.
    pub fn measure(lab: &Lab, rounds: u32) -> Result<Self> {
        Ok(Self { cells: lab.rounds(rounds, &KEYS, load)? })
    }

    /// All samples for the report.
    pub fn json(&self) -> serde_json::Value {
        json_of_series(&self.cells, load)
    }

    fn cell(&self, key: Key) -> Result<&[Sample]> {
        let found = self.cells.iter().find(|(own, _)| *own == key);
        found.map(|(_, samples)| samples.as_slice()).context("find a measured number of workers")
    }

    /// CPU time of a server for each picture in milliseconds, if a brood alone takes `brood_ms`:
    /// hand-over of the job, results, cache, and one request of a client for a brood.
    pub fn picture_ms(&self, brood_ms: f64) -> Result<f64> {
        let figure = |one: &Sample| {
            let pictures = one.number("/workers/all_pictures")?.max(1.0);
            Ok((one.cpu_ms()?[0] - brood_ms) * one.all_broods()? / pictures)
        };
        Ok(spread(self.cell(MODEL)?, figure)?[1].max(0.0))
    }

    /// Connections of each worker at each server.
    pub fn connections(&self) -> Result<f64> {
        let (_, workers, _) = AT_SEVERAL;
        let figure = |one: &Sample| one.number("/workers/connections");
        Ok(spread(self.cell(AT_SEVERAL)?, figure)?[1] / f64::from(workers))
    }

    /// Goals with the measured values.
    pub fn goals(&self) -> Result<Vec<Goal>> {
        let goal = |(key, goal)| {
            let (_, workers, ms) = key;
            let found = spread(self.cell(key)?, |one| one.number("/workers/busy"))?[1];
            Ok(Goal { what: format!("{workers} workers busy, {ms} ms a picture"), goal, found })
        };
        GOALS.into_iter().map(goal).collect()
    }

    /// The table.
    pub fn markdown(&self) -> Result<String> {
        let mut text = format!(
            "\n## Workers that sleep\n\nNo quota; each worker claims jobs at all servers, over the code of a worker that \
             renders. Busy: pictures times their stated time, of the time of all workers. Medians, and quartiles; rounds in \
             turn: {}. Servers, PostgreSQL, clients and workers share the machine: if their cores together come \
             near those of the machine, it is the limit.\n\n\
             | servers | workers | ms a picture | busy | pictures/s | brood p99, ms | servers, cores | PostgreSQL, cores \
             | load and workers, cores | connections at a server | refused |\n\
             |---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n",
            self.cells.first().map_or(0, |(_, samples)| samples.len()),
        );
        for ((servers, workers, ms), samples) in &self.cells {
            let of = |pointer: &str| spread(samples, |one| one.number(pointer));
            let core =
                |at: usize| Ok::<_, anyhow::Error>(spread(samples, |one| Ok(one.cores()[at]))?[1]);
            let [low, busy, high] = of("/workers/busy")?.map(|share| 100.0 * share);
            writeln!(
                text,
                "| {servers} | {workers} | {ms} | {busy:.1} % ({low:.1} to {high:.1}) | {:.0} | {:.0} | {:.2} | {:.2} \
                 | {:.2} | {:.0} | {:.0} |",
                of("/workers/pictures_per_s")?[1],
                of("/p99_ms")?[1],
                core(0)?,
                core(1)?,
                core(2)?,
                of("/workers/connections")?[1],
                of("/all_refused")?[1],
            )?;
        }
        Ok(text)
    }
}

fn load((servers, workers, picture_ms): Key) -> Load {
    // Two jobs for each worker, one of them ahead, and a few that wait.
    let clients = (2 * workers + 8).min(MOST_CLIENTS);
    Load { servers, workers, picture_ms, ..Load::new(clients, CHILDREN) }
}
