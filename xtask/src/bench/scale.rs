//! `cargo xtask bench scale`: several servers on one machine. Broods of servers under CPU quota,
//! workers that sleep, both engines, a load model fitted to the demands of broods, and searches
//! with islands.
//!
//! Owns the series and the report; `brood bench throughput` is the load of broods.

mod births;
mod cgroup;
mod cpu;
mod demands;
mod engines;
mod glossy;
mod goal;
mod http;
mod islands;
mod model;
mod sample;
mod searches;
mod server;
mod statistics;
mod workers;

use anyhow::{Context, Result};
use serde_json::{Value, json};

use self::births::Births;
use self::cgroup::CpuGroup;
use self::demands::Demands;
use self::engines::Engines;
use self::islands::Islands;
use self::model::Model;
use self::sample::Lab;
use self::workers::Workers;
use super::environment::Environment;
use super::{Options, Task, paragraphs, require_all, write_report};
use crate::shell;

/// Seconds of each measurement, by default.
const SECONDS: u32 = 10;

/// Series of measurements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Series {
    /// Broods of several servers under quota.
    Births,
    /// Workers that sleep.
    Workers,
    /// SQLite beside PostgreSQL.
    Engines,
    /// CPU time and bytes of a brood.
    Demands,
    /// Searches with islands beside searches without.
    Islands,
}

impl Series {
    const ALL: [Self; 5] =
        [Self::Births, Self::Workers, Self::Engines, Self::Demands, Self::Islands];

    /// Name on the command line.
    fn name(self) -> &'static str {
        match self {
            Self::Births => "births",
            Self::Workers => "workers",
            Self::Engines => "engines",
            Self::Demands => "demands",
            Self::Islands => "islands",
        }
    }

    /// Series of `--only`; all by default.
    fn chosen(only: Option<&str>) -> Result<Vec<Self>> {
        let Some(only) = only else { return Ok(Self::ALL.to_vec()) };
        let find = |name: &str| {
            let found = Self::ALL.into_iter().find(|series| series.name() == name);
            found.with_context(|| {
                format!("--only takes births, workers, engines, demands and islands, got {name}")
            })
        };
        only.split(',').map(find).collect()
    }
}

/// Runs the benchmark.
pub fn run(words: &[&str]) -> Result<()> {
    let options = Options::parse(Task::Scale, words)?;
    let chosen = Series::chosen(options.only.as_deref())?;
    let has = |series| chosen.contains(&series);
    if has(Series::Births) {
        // Fails before anything is built.
        drop(CpuGroup::new(&format!("brood-scale-check-{}", std::process::id()), 1.0)?);
    }
    let environment = Environment::prepare(&options, &[])?;
    let seconds =
        options.seconds.as_ref().and_then(|given| given.first().copied()).unwrap_or(SECONDS);
    let lab = Lab::new(environment.brood_file(), seconds)?;
    let rounds = options.rounds;
    let mut missing = Vec::new();
    // A series that fails takes no other with it.
    let births = or_note(&mut missing, Series::Births, has(Series::Births), || {
        Births::measure(&lab, rounds)
    });
    let workers = or_note(&mut missing, Series::Workers, has(Series::Workers), || {
        Workers::measure(&lab, rounds)
    });
    let engines = or_note(&mut missing, Series::Engines, has(Series::Engines), || {
        Engines::measure(&lab, rounds)
    });
    let demands = or_note(&mut missing, Series::Demands, has(Series::Demands), || {
        Demands::measure(&lab, rounds)
    });
    let islands = or_note(&mut missing, Series::Islands, has(Series::Islands), || {
        Islands::measure(&lab, rounds)
    });
    let model = demands.as_ref().map(|own| Model::new(own, births.as_ref(), workers.as_ref()));
    let model = model.transpose()?;

    let mut machine = environment.machine();
    machine["commit"] = commit();
    machine["postgresql"] = lab.version()?.into();
    machine["durability"] = lab.durability()?.into();
    let mut goals = Vec::new();
    let mut text = heading(&machine, seconds, rounds);
    if let Some(births) = &births {
        goals.extend(births.goals()?);
        text += &births.markdown()?;
    }
    if let Some(workers) = &workers {
        goals.extend(workers.goals()?);
        text += &workers.markdown()?;
    }
    if let Some(engines) = &engines {
        goals.extend(engines.goals()?);
        text += &engines.markdown()?;
    }
    if let Some(demands) = &demands {
        text += &demands.markdown()?;
    }
    if let Some(model) = &model {
        text += &model.markdown()?;
    }
    if let Some(islands) = &islands {
        text += &islands.markdown()?;
    }
    if !goals.is_empty() {
        text += &goal::markdown(&goals)?;
    }
    text += &paragraphs(&missing);
    let report = json!({
        "machine": machine,
        "seconds": seconds,
        "rounds": rounds,
        "births": births.as_ref().map(Births::json),
        "workers": workers.as_ref().map(Workers::json),
        "engines": engines.as_ref().map(Engines::json),
        "demands": demands.as_ref().map(Demands::json),
        "islands": islands.as_ref().map(Islands::json),
        "extrapolation": model.as_ref().map(Model::json),
        "missing": missing,
    });
    write_report(&options.out, "scale", &report, &text)?;
    require_all(true, &missing)
}

/// Measures a chosen series; notes the reason if that fails.
fn or_note<T>(
    missing: &mut Vec<String>,
    series: Series,
    is_chosen: bool,
    measure: impl FnOnce() -> Result<T>,
) -> Option<T> {
    if !is_chosen {
        return None;
    }
    measure().map_err(|error| missing.push(format!("{}: {error:#}", series.name()))).ok()
}

/// Commit of the source tree; null if it is not known.
fn commit() -> Value {
    let commit = shell::output(shell::command("git").args(["rev-parse", "--short", "HEAD"]));
    commit.map_or(Value::Null, |commit| commit.trim().into())
}

fn heading(machine: &Value, seconds: u32, rounds: u32) -> String {
    let field = |key: &str| machine[key].as_str().unwrap_or("not known").to_owned();
    format!(
        "# Several servers\n\n{}, {} cores; {}, commit {}, profile {}, {}; PostgreSQL {} ({}). Servers, database, clients \
         and workers on one machine; each measurement on a new database, of broods for {seconds} s after 5 s of load; \
         rounds: {rounds}.\n",
        field("processor"),
        machine["cores"],
        field("brood_version"),
        field("commit"),
        field("brood_profile"),
        field("rustc"),
        field("postgresql"),
        field("durability"),
    )
}

#[cfg(test)]
mod tests {
    use super::Series;

    #[test]
    fn series_are_chosen_by_name() {
        assert_eq!(Series::chosen(None).unwrap(), Series::ALL);
        let chosen = Series::chosen(Some("engines,births,islands")).unwrap();
        assert_eq!(chosen, [Series::Engines, Series::Births, Series::Islands]);
        assert!(Series::chosen(Some("births,,")).is_err());
        let error = Series::chosen(Some("island")).unwrap_err().to_string();
        assert!(Series::ALL.iter().all(|series| error.contains(series.name())), "{error}");
    }
}
