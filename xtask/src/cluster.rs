//! `cargo xtask faults --cluster`: faults of a cluster under load (`tests/faults/cluster.rs`), as
//! root.
//!
//! The test runs in network and mount namespaces of its own, so its bridges, addresses and names of
//! hosts end with it. It starts and kills PostgreSQL itself, with the command that it gets. Logs of
//! servers and workers are kept in `target/cluster`.

use std::io::Write;
use std::path::PathBuf;
use std::sync::Mutex;

use anyhow::{Context, Result, bail};

use crate::postgres::Cluster;
use crate::{faults, prerequisite, shell, suite};

/// Program of namespaces.
const UNSHARE: &str = "unshare";
/// Programs of the test.
const PROGRAMS: [prerequisite::Program; 5] = [
    ("ip", &["iproute2"]),
    (UNSHARE, &["util-linux"]),
    ("nsenter", &["util-linux"]),
    ("mount", &["mount"]),
    ("kill", &["procps"]),
];
/// Options of PostgreSQL. It listens in the namespace of the test.
const OPTIONS: &str =
    "-c listen_addresses=* -c max_connections=200 -c recovery_init_sync_method=syncfs";
/// Lets servers in networks of the test connect.
const CONNECT: &str = "host all all samenet trust";
/// The test.
const TEST: &str = "cluster::campaign_loses_nothing_and_leaves_nothing_behind";

/// Size of a campaign.
#[derive(Debug, PartialEq, Eq)]
struct Options {
    rounds: u32,
    /// Minutes over which the rounds are spread.
    minutes: u32,
    seed: u32,
    /// Program of an earlier build, between which and this one rounds upgrade and downgrade.
    older: Option<PathBuf>,
}

impl Options {
    fn read(mut words: &[&str]) -> Result<Self> {
        let (mut rounds, mut minutes, mut seed, mut older) = (None, None, 1, None);
        while let [name, value, rest @ ..] = words {
            let number = || value.parse().with_context(|| format!("{name} takes a whole number"));
            match *name {
                "--rounds" if *value != "0" => rounds = Some(number()?),
                "--minutes" => minutes = Some(number()?),
                "--seed" => seed = number()?,
                "--older" => {
                    let path = std::fs::canonicalize(value);
                    older = Some(path.with_context(|| format!("find {value}"))?);
                }
                _ => bail!("unknown option of faults --cluster: {name} {value}"),
            }
            words = rest;
        }
        if let [word] = words {
            bail!("unknown option of faults --cluster, or no value: {word}");
        }
        // With `--rounds` alone, rounds follow each other without pauses. Without both options, a
        // campaign has 100 rounds in 30 minutes.
        let usual = if rounds.is_some() { 0 } else { 30 };
        let (rounds, minutes) = (rounds.unwrap_or(100), minutes.unwrap_or(usual));
        Ok(Self { rounds, minutes, seed, older })
    }
}

/// Runs a campaign and prints its figures.
pub fn run(options: &[&str]) -> Result<()> {
    let options = Options::read(options)?;
    if !cfg!(target_os = "linux") || !shell::is_root()? {
        bail!("faults --cluster makes network namespaces: run it as root on Linux");
    }
    prerequisite::install_programs(&PROGRAMS)?;
    shell::run(shell::cargo().args(["build", "--locked", "--package", "brood"]))?;
    let test = ["test", "--locked", "--package", "brood-tests", "--test", "faults"];
    shell::run(shell::cargo().args(test).arg("--no-run"))?;
    let database = Cluster::make()?;
    let access = database.data().join("pg_hba.conf");
    let mut access = std::fs::File::options().append(true).open(access)?;
    writeln!(access, "{CONNECT}")?;

    let target = suite::target_directory()?;
    let logs = target.join("cluster");
    if logs.exists() {
        std::fs::remove_dir_all(&logs)?;
    }
    std::fs::create_dir_all(&logs)?;
    let mut command = shell::command(UNSHARE);
    command.args(["--net", "--mount", "--propagation", "private", "--"]);
    command.arg(shell::cargo().get_program()).args(test).arg("--offline");
    command.args(["--", "--exact", TEST, "--nocapture"]);
    let control = database.control_with(OPTIONS);
    let control = [control.get_program()].into_iter().chain(control.get_args());
    let control: Vec<_> = control.map(|word| word.to_string_lossy()).collect();
    command
        .env("BROOD_BIN", target.join("debug/brood"))
        .env("BROOD_CLUSTER_LOGS", &logs)
        .env("BROOD_CLUSTER_CONTROL", control.join("\n"))
        .env("BROOD_CLUSTER_DATA", database.data())
        .env("BROOD_CLUSTER_ROUNDS", options.rounds.to_string())
        .env("BROOD_CLUSTER_MINUTES", options.minutes.to_string())
        .env("BROOD_CLUSTER_SEED", options.seed.to_string());
    if let Some(older) = &options.older {
        command.env("BROOD_CLUSTER_OLDER", older);
    }
    let figures = Mutex::new(Vec::new());
    let outcome = shell::run_watched(&mut command, |line| {
        if let Some((_, line)) = line.split_once(faults::PREFIX) {
            figures.lock().expect("no reader of the output panics").push(line.to_owned());
        }
    });
    println!("\nfaults --cluster, seed {}:", options.seed);
    let figures = figures.into_inner().expect("no reader of the output panics");
    figures.iter().for_each(|line| println!("  {line}"));
    outcome.context("a fault was not survived")?;
    if figures.is_empty() {
        bail!("the test {TEST} did not run");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::Options;

    #[test]
    fn options_without_minutes_are_short_only_if_rounds_are_given() {
        let read = |words: &[&str]| Options::read(words).map_err(|error| error.to_string());
        let expected = |rounds, minutes, seed| Ok(Options { rounds, minutes, seed, older: None });
        assert_eq!(read(&[]), expected(100, 30, 1));
        assert_eq!(read(&["--rounds", "9"]), expected(9, 0, 1));
        let all = ["--seed", "7", "--minutes", "5", "--rounds", "20"];
        assert_eq!(read(&all), expected(20, 5, 7));
        for invalid in [&["--rounds"][..], &["--rounds", "0"], &["--older", "/no/such/file"]] {
            assert!(read(invalid).is_err(), "{invalid:?}");
        }
    }
}
