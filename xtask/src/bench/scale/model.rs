//! Load model: demands that were measured, extrapolated to 1,000 workers and 10^9 individuals by
//! the utilisation law: a resource is full when demand times rate is its capacity.

use std::fmt::Write;

use anyhow::Result;
use serde_json::{Value, json};

use super::births::Births;
use super::demands::{Demands, Part};
use super::workers::Workers;

/// Extrapolated number of workers.
const WORKERS: f64 = 1000.0;
/// Time of a worker for a picture in seconds.
const PICTURE_S: f64 = 0.02;
/// Children of a brood, each with a new picture.
const CHILDREN: u32 = 20;
/// Extrapolated number of individuals.
const INDIVIDUALS: f64 = 1e9;

/// Assumed machine of PostgreSQL: processors, bytes of log that its disk writes in a second, bytes
/// of its disk, and bytes of its memory for indices.
const DATABASE_CORES: f64 = 16.0;
const LOG_BYTES_PER_S: f64 = 500e6;
const DISK_BYTES: f64 = 4e12;
const MEMORY_BYTES: f64 = 64e9;
/// Limit of the connections of workers to a server, `WORKER_CONNECTIONS` in `server/src/limit.rs`.
const CONNECTIONS: f64 = 2048.0;
/// Assumed entries of a page of an index: 8 KiB, two thirds full of entries of 28 bytes.
const FANOUT: f64 = 200.0;

/// A resource that can be full.
struct Resource {
    name: String,
    /// Use by one worker or one individual.
    each: f64,
    capacity: f64,
    unit: &'static str,
}

impl Resource {
    /// Number of workers or individuals at which it is full.
    fn most(&self) -> f64 {
        self.capacity / self.each
    }
}

/// Extrapolation, the first limit first.
pub struct Model {
    of_workers: Vec<Resource>,
    of_individuals: Vec<Resource>,
    /// Processors of servers for all workers, if pictures were measured.
    server_cores: Option<f64>,
}

impl Model {
    /// Extrapolates what was measured.
    pub fn new(
        demands: &Demands,
        births: Option<&Births>,
        workers: Option<&Workers>,
    ) -> Result<Self> {
        let broods_per_s = 1.0 / (PICTURE_S * f64::from(CHILDREN));
        let brood_ms = demands.at(Part::Server, CHILDREN)?;
        let mut of_workers = vec![
            Resource {
                name: format!("processors of PostgreSQL, {DATABASE_CORES}"),
                each: broods_per_s * demands.at(Part::Database, CHILDREN)? / 1e3,
                capacity: DATABASE_CORES,
                unit: "cores",
            },
            Resource {
                name: format!("log of PostgreSQL, {:.0} MB/s", LOG_BYTES_PER_S / 1e6),
                each: broods_per_s * demands.at(Part::Log, CHILDREN)? / 1e6,
                capacity: LOG_BYTES_PER_S / 1e6,
                unit: "MB/s",
            },
        ];
        let mut server_cores = None;
        if let Some(workers) = workers {
            let all_ms = brood_ms + f64::from(CHILDREN) * workers.picture_ms(brood_ms)?;
            server_cores = Some(WORKERS * broods_per_s * all_ms / 1e3);
            of_workers.push(Resource {
                name: format!("connections of workers at each server, {CONNECTIONS}"),
                each: workers.connections()?,
                capacity: CONNECTIONS,
                unit: "connections",
            });
        }
        if let Some(births) = births {
            of_workers.push(Resource {
                name: "a processor of each server, for messages of the others".to_owned(),
                // Below what can be measured if it is not positive.
                each: broods_per_s * births.message_ms()?.max(0.0) / 1e3,
                capacity: 1.0,
                unit: "cores",
            });
        }
        let of = |part| Ok::<_, anyhow::Error>(demands.at(part, CHILDREN)? / f64::from(CHILDREN));
        let mut of_individuals = vec![
            Resource {
                name: format!("disk of PostgreSQL, {:.0} TB", DISK_BYTES / 1e12),
                each: of(Part::Stored)?,
                capacity: DISK_BYTES,
                unit: "bytes",
            },
            Resource {
                name: format!("indices in memory, {:.0} GB", MEMORY_BYTES / 1e9),
                each: of(Part::Indices)?,
                capacity: MEMORY_BYTES,
                unit: "bytes",
            },
        ];
        for resources in [&mut of_workers, &mut of_individuals] {
            resources.sort_by(|a, b| a.most().total_cmp(&b.most()));
        }
        Ok(Self { of_workers, of_individuals, server_cores })
    }

    /// The extrapolation for the report.
    pub fn json(&self) -> Value {
        let rows = |resources: &[Resource]| -> Vec<Value> {
            let row = |one: &Resource| {
                json!({ "resource": one.name, "each": one.each, "unit": one.unit,
                        "capacity": one.capacity, "most": one.most() })
            };
            resources.iter().map(row).collect()
        };
        json!({
            "workers": rows(&self.of_workers),
            "individuals": rows(&self.of_individuals),
            "server_cores": self.server_cores,
        })
    }

    /// The tables.
    pub fn markdown(&self) -> Result<String> {
        let pictures_per_s = WORKERS / PICTURE_S;
        let mut text = format!(
            "\n## Extrapolation\n\nNot measured: demands above, times the rate. {WORKERS:.0} workers that are always busy at \
             {:.0} ms a picture make {pictures_per_s:.0} pictures/s, all of them of new children in broods of {CHILDREN}. \
             Capacities are assumed, except the limit of connections. The first row breaks first.\n\n\
             | resource | use by a worker | at {WORKERS:.0} workers | full at |\n|---|---:|---:|---:|\n",
            1e3 * PICTURE_S,
        );
        for one in &self.of_workers {
            writeln!(
                text,
                "| {} | {:.5} {} | {:.1} {} | {:.0} workers |",
                one.name,
                one.each,
                one.unit,
                WORKERS * one.each,
                one.unit,
                one.most(),
            )?;
        }
        if let Some(cores) = self.server_cores {
            writeln!(
                text,
                "\nServers need {cores:.1} processors for {WORKERS:.0} workers; more of them can be added."
            )?;
        }
        write!(
            text,
            "\n| resource | bytes of an individual | at 10^9 individuals | full at |\n|---|---:|---:|---:|\n"
        )?;
        for one in &self.of_individuals {
            let (bytes, all) = (one.each, INDIVIDUALS * one.each / 1e9);
            writeln!(
                text,
                "| {} | {bytes:.0} | {all:.0} GB | {:.1e} individuals |",
                one.name,
                one.most()
            )?;
        }
        let (hours, depth) = (INDIVIDUALS / pictures_per_s / 3600.0, depth_of(INDIVIDUALS));
        writeln!(
            text,
            "\n{WORKERS:.0} workers make 10^9 individuals in {hours:.1} hours. An index of 10^9 entries, {FANOUT:.0} a page \
             (assumed), has {depth} levels, and one of 10^6 {}. Entries of hashes and ids are at random places: \
             once the indices are larger than the memory, each child reads pages from the disk.",
            depth_of(1e6),
        )?;
        Ok(text)
    }
}

/// Levels of an index with this many entries.
fn depth_of(entries: f64) -> u32 {
    let (mut levels, mut reach) = (1, FANOUT);
    while reach < entries {
        levels += 1;
        reach *= FANOUT;
    }
    levels
}

#[cfg(test)]
mod tests {
    use super::{Resource, depth_of};

    #[test]
    fn index_grows_a_level_for_each_factor_of_its_fanout() {
        assert_eq!([1.0, 200.0, 201.0, 1e6, 1e9].map(depth_of), [1, 1, 2, 3, 4]);
    }

    #[test]
    fn unused_resource_is_never_full() {
        let of = |each| Resource { name: String::new(), each, capacity: 8.0, unit: "cores" };
        assert_eq!((of(2.0).most(), of(0.0).most()), (4.0, f64::INFINITY));
    }
}
