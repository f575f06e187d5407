//! Broods per second of 64 clients at one server, on SQLite and on PostgreSQL.

use std::fmt::Write;

use anyhow::{Context, Result};

use super::goal::Goal;
use super::sample::{Engine, Lab, Load, Sample, json_of_series, spread};
use super::statistics::quartiles;

const CHILDREN: [u32; 2] = [4, 20];
const CLIENTS: u32 = 64;

/// Number of children and engine.
type Key = (u32, Engine);

/// Measured engines.
pub struct Engines {
    cells: Vec<(Key, Vec<Sample>)>,
}

impl Engines {
    /// Measures both engines in turn.
    pub fn measure(lab: &Lab, rounds: u32) -> Result<Self> {
        let keys: Vec<Key> = CHILDREN
            .into_iter()
            .flat_map(|children| {
                [Engine::Sqlite, Engine::Postgres].map(|engine| (children, engine))
            })
            .collect();
        Ok(Self { cells: lab.rounds(rounds, &keys, load)? })
    }

    /// All samples for the report.
    pub fn json(&self) -> serde_json::Value {
        json_of_series(&self.cells, load)
    }

    fn cell(&self, key: Key) -> Result<&[Sample]> {
        let found = self.cells.iter().find(|(own, _)| *own == key);
        found.map(|(_, samples)| samples.as_slice()).context("find a measured engine")
    }

    /// Broods per second of PostgreSQL relative to SQLite, in each round.
    fn ratios(&self, children: u32) -> Result<Vec<f64>> {
        let cell = |engine| self.cell((children, engine));
        let ratio =
            |(own, other): (&Sample, &Sample)| Ok(own.broods_per_s()? / other.broods_per_s()?);
        cell(Engine::Postgres)?.iter().zip(cell(Engine::Sqlite)?).map(ratio).collect()
    }

    /// Goals with the measured values.
    pub fn goals(&self) -> Result<Vec<Goal>> {
        let goal = |children| {
            Ok(Goal {
                what: format!("broods of {children} on PostgreSQL, of SQLite's, {CLIENTS} clients"),
                goal: 1.0,
                found: quartiles(&self.ratios(children)?)[1],
            })
        };
        CHILDREN.into_iter().map(goal).collect()
    }

    /// The table.
    pub fn markdown(&self) -> Result<String> {
        let mut text = format!(
            "\n## SQLite and PostgreSQL\n\nOne server without quota, {CLIENTS} clients. SQLite runs in the server. Medians, \
             and quartiles; rounds in turn: {}.\n\n\
             | children | engine | broods/s | median, ms | p99, ms | server, cores | PostgreSQL, cores | load, cores \
             | refused |\n|---:|---|---:|---:|---:|---:|---:|---:|---:|\n",
            self.cells.first().map_or(0, |(_, samples)| samples.len()),
        );
        for ((children, engine), samples) in &self.cells {
            let [low, rate, high] = spread(samples, Sample::broods_per_s)?;
            let of = |pointer: &str| {
                Ok::<_, anyhow::Error>(spread(samples, |one| one.number(pointer))?[1])
            };
            let core =
                |at: usize| Ok::<_, anyhow::Error>(spread(samples, |one| Ok(one.cores()[at]))?[1]);
            writeln!(
                text,
                "| {children} | {} | {rate:.0} ({low:.0} to {high:.0}) | {:.0} | {:.0} | {:.2} | {:.2} | {:.2} | {:.0} |",
                engine.name(),
                of("/median_ms")?,
                of("/p99_ms")?,
                core(0)?,
                core(1)?,
                core(2)?,
                of("/all_refused")?,
            )?;
        }
        for children in CHILDREN {
            let [low, ratio, high] = quartiles(&self.ratios(children)?);
            writeln!(
                text,
                "\nPostgreSQL relative to SQLite, broods of {children}: {ratio:.2} ({low:.2} to {high:.2})."
            )?;
        }
        Ok(text)
    }
}

fn load((children, engine): Key) -> Load {
    Load { engine, ..Load::new(CLIENTS, children) }
}
