//! Runs the peers and brood in turn and keeps what they print.
//!
//! Owns which commands are run. Refuses to know what the figures mean: each is kept as the JSON it came in, one for
//! each round, and read by the comparison.

use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

use anyhow::Result;
use serde_json::{Value, json};

use super::environment::{Environment, Peer, json_of};

/// A piece of work by one program; the name is the key of the raw results.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Work {
    /// Scalar operations a second.
    OperonOperations,
    /// The same of brood.
    BroodOperations,
    /// Values that are not finite.
    BroodStress,
    /// The Lambert sphere.
    BroodSphere,
    /// The same of the peer.
    MitsubaSphere,
    /// Materials whose kernels are warm.
    MitsubaKnown,
    /// Materials of new structure.
    MitsubaNew,
    /// New programs in memory.
    BroodFrame,
    /// New programs over HTTP.
    BroodBreed,
}

impl Work {
    /// In the order in which a round does them: what is held against each other runs one after the other.
    const ALL: [Self; 9] = [
        Self::OperonOperations,
        Self::BroodOperations,
        Self::BroodStress,
        Self::BroodSphere,
        Self::MitsubaSphere,
        Self::MitsubaKnown,
        Self::MitsubaNew,
        Self::BroodFrame,
        Self::BroodBreed,
    ];

    /// The key in the raw results.
    pub fn name(self) -> &'static str {
        match self {
            Self::OperonOperations => "pyoperon operations",
            Self::BroodOperations => "brood bench ops",
            Self::BroodStress => "brood bench stress",
            Self::BroodSphere => "brood bench pareto",
            Self::MitsubaSphere => "mitsuba sphere",
            Self::MitsubaKnown => "mitsuba known materials",
            Self::MitsubaNew => "mitsuba new materials",
            Self::BroodFrame => "brood bench frame",
            Self::BroodBreed => "brood bench breed",
        }
    }

    /// The peer that does it; none is brood.
    fn peer(self) -> Option<Peer> {
        match self {
            Self::OperonOperations => Some(Peer::Operon),
            Self::MitsubaSphere | Self::MitsubaKnown | Self::MitsubaNew => Some(Peer::Mitsuba),
            Self::BroodOperations
            | Self::BroodStress
            | Self::BroodSphere
            | Self::BroodFrame
            | Self::BroodBreed => None,
        }
    }
}

/// What was printed, and what could not be had.
pub struct Findings {
    results: BTreeMap<Work, Vec<Value>>,
    failed: BTreeSet<Work>,
    rounds: u32,
    /// In words, each once.
    pub missing: Vec<String>,
}

impl Findings {
    /// Nothing yet, but for the peers that are not there.
    pub fn new(environment: &Environment) -> Self {
        Self::with_missing(environment.missing.clone())
    }

    /// Nothing yet but a list of what is not there.
    pub fn with_missing(missing: Vec<String>) -> Self {
        Self { results: BTreeMap::new(), failed: BTreeSet::new(), rounds: 0, missing }
    }

    /// Does every piece of work once. One that failed is not tried again.
    pub fn round(&mut self, environment: &Environment) {
        self.rounds += 1;
        for work in Work::ALL {
            let there = work.peer().is_none_or(|peer| environment.has(peer));
            if !there || self.failed.contains(&work) {
                continue;
            }
            println!("{}", work.name());
            match self.measure(work, environment) {
                Ok(value) => self.add(work, value),
                Err(error) => {
                    eprintln!("{} is left out: {error:#}", work.name());
                    self.missing.push(format!("{}: {error:#}", work.name()));
                    self.failed.insert(work);
                }
            }
        }
    }

    /// Keeps one result.
    pub fn add(&mut self, work: Work, value: Value) {
        self.results.entry(work).or_default().push(value);
    }

    /// All results of one kind, one for each round.
    pub fn of(&self, work: Work) -> &[Value] {
        self.results.get(&work).map_or(&[], Vec::as_slice)
    }

    /// Everything as it was printed.
    pub fn raw(&self) -> Value {
        let named =
            self.results.iter().map(|(work, values)| (work.name().to_owned(), json!(values)));
        Value::Object(named.collect())
    }

    fn measure(&self, work: Work, environment: &Environment) -> Result<Value> {
        let script = |name: &str, words: &[&str]| {
            let mut command = environment.script(name);
            command.args(words);
            command
        };
        let bench = |words: &[&str]| -> Command {
            let mut command = environment.brood();
            command.arg("bench").args(words).arg("--json");
            command
        };
        // Another seed each round, so that no structure is one that was compiled before.
        let seed = self.rounds.to_string();
        let mut command = match work {
            Work::OperonOperations => script("operon.py", &[]),
            Work::BroodOperations => bench(&["ops", "--passes", "15"]),
            Work::BroodStress => bench(&["stress", "--evaluations", "2000000"]),
            Work::BroodSphere => bench(&["pareto", "--scene", "lambert-sphere"]),
            Work::MitsubaSphere => {
                // The same picture: errors grow with the albedo.
                let albedo =
                    self.of(Work::BroodSphere).first().and_then(|it| it["albedo"].as_f64());
                let albedo = albedo.unwrap_or(1.0).to_string();
                script("mitsuba_pictures.py", &["sphere", "--albedo", &albedo])
            }
            Work::MitsubaKnown => script("mitsuba_pictures.py", &["known", "--seed", &seed]),
            Work::MitsubaNew => {
                environment.forget_kernels()?;
                script("mitsuba_pictures.py", &["new", "--seed", &seed])
            }
            Work::BroodFrame => bench(&["frame", "--size", "128", "--samples", "adaptive"]),
            Work::BroodBreed => bench(&["breed", "--size", "128", "--count", "50"]),
        };
        json_of(&mut command)
    }
}
