//! Broods per second of 1 to 8 servers, each with a quota of a processor, so that the database and
//! the load have the rest of the machine.

use std::fmt::Write;

use anyhow::{Context, Result};

use super::goal::Goal;
use super::sample::{Lab, Load, Sample, json_of_series, spread};
use super::statistics::quartiles;

/// Numbers of servers; the first is compared with.
const SERVERS: [u32; 4] = [1, 2, 4, 8];
const CHILDREN: [u32; 2] = [4, 20];
/// Share of one processor that each server may use.
const QUOTA: f64 = 0.1;
/// Clients of each server: enough to use its quota.
const CLIENTS: u32 = 8;
/// Share of linear growth that is the goal up to [`MOST`] servers.
const GOAL: f64 = 0.95;
const MOST: u32 = 4;

/// Measured broods.
pub struct Births {
    cells: Vec<((u32, u32), Vec<Sample>)>,
}

impl Births {
    /// Measures all numbers of servers in turn.
    pub fn measure(lab: &Lab, rounds: u32) -> Result<Self> {
        let keys: Vec<(u32, u32)> = CHILDREN
            .into_iter()
            .flat_map(|children| SERVERS.map(|servers| (children, servers)))
            .collect();
        Ok(Self { cells: lab.rounds(rounds, &keys, load)? })
    }

    /// All samples for the report.
    pub fn json(&self) -> serde_json::Value {
        json_of_series(&self.cells, load)
    }

    /// Broods per second as a share of linear growth from one server, in each round.
    fn shares(&self, children: u32, servers: u32) -> Result<Vec<f64>> {
        let (own, one) = (self.cell(children, servers)?, self.cell(children, SERVERS[0])?);
        let share = |(own, one): (&Sample, &Sample)| {
            Ok(own.broods_per_s()? / (f64::from(servers) * one.broods_per_s()?))
        };
        own.iter().zip(one).map(share).collect()
    }

    fn cell(&self, children: u32, servers: u32) -> Result<&[Sample]> {
        let found = self.cells.iter().find(|(key, _)| *key == (children, servers));
        found.map(|(_, samples)| samples.as_slice()).context("find a measured number of servers")
    }

    /// Time in milliseconds that a brood takes at each other server, by its message: growth of the
    /// servers' CPU time for a brood with their number.
    pub fn message_ms(&self) -> Result<f64> {
        let of = |servers| {
            let samples = self.cell(CHILDREN[0], servers)?;
            Ok::<_, anyhow::Error>(spread(samples, |one| Ok(one.cpu_ms()?[0]))?[1])
        };
        let most = SERVERS[SERVERS.len() - 1];
        Ok((of(most)? - of(SERVERS[0])?) / f64::from(most - SERVERS[0]))
    }

    /// Goals with the measured values.
    pub fn goals(&self) -> Result<Vec<Goal>> {
        let mut goals = Vec::new();
        for children in CHILDREN {
            for servers in SERVERS.into_iter().filter(|servers| (2..=MOST).contains(servers)) {
                goals.push(Goal {
                    what: format!("broods of {children} at {servers} servers, of linear"),
                    goal: GOAL,
                    found: quartiles(&self.shares(children, servers)?)[1],
                });
            }
        }
        Ok(goals)
    }

    /// The table.
    pub fn markdown(&self) -> Result<String> {
        let mut text = format!(
            "\n## Broods of several servers\n\nEach server has {:.0} % of one processor and {CLIENTS} clients. Medians, \
             and quartiles; rounds in turn: {}. Quota: the part of it that the servers used.\n\n\
             | children | servers | broods/s | of linear | median, ms | p99, ms | quota | PostgreSQL, cores | load, cores |\n\
             |---:|---:|---:|---:|---:|---:|---:|---:|---:|\n",
            100.0 * QUOTA,
            self.cells.first().map_or(0, |(_, samples)| samples.len()),
        );
        for ((children, servers), samples) in &self.cells {
            let [low, rate, high] = spread(samples, Sample::broods_per_s)?;
            let [least, share, most] =
                quartiles(&self.shares(*children, *servers)?).map(|share| 100.0 * share);
            let ms = |pointer: &str| {
                Ok::<_, anyhow::Error>(spread(samples, |one| one.number(pointer))?[1])
            };
            let core =
                |at: usize| Ok::<_, anyhow::Error>(spread(samples, |one| Ok(one.cores()[at]))?[1]);
            writeln!(
                text,
                "| {children} | {servers} | {rate:.1} ({low:.1} to {high:.1}) | {share:.0} % ({least:.0} to {most:.0}) \
                 | {:.0} | {:.0} | {:.0} % | {:.2} | {:.2} |",
                ms("/median_ms")?,
                ms("/p99_ms")?,
                100.0 * core(0)? / (QUOTA * f64::from(*servers)),
                core(1)?,
                core(2)?,
            )?;
        }
        Ok(text)
    }
}

fn load((children, servers): (u32, u32)) -> Load {
    Load { servers, quota: Some(QUOTA), ..Load::new(CLIENTS * servers, children) }
}
