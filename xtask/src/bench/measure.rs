//! Runs the peers and brood alternately and stores their output.
//!
//! Owns the list of commands. Independent of the meaning of the figures: the JSON of each round is
//! stored as it is, for the comparison.

use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

use anyhow::Result;
use serde_json::{Value, json};

use super::environment::{Environment, Peer, json_of};

/// A measurement of one program; its name is the key of the raw results.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Measurement {
    /// Scalar operations per second of the peer.
    OperonOperations,
    /// Scalar operations per second of brood.
    BroodOperations,
    /// Non-finite values.
    BroodStress,
    /// Lambert sphere by brood.
    BroodSphere,
    /// Lambert sphere by the peer.
    MitsubaSphere,
    /// Materials with compiled kernels.
    MitsubaKnown,
    /// Materials with a new structure.
    MitsubaNew,
    /// New programs in memory.
    BroodFrame,
    /// New programs over HTTP.
    BroodBreed,
}

impl Measurement {
    /// In the order of a round: compared measurements follow each other.
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

    /// Key in the raw results.
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

    /// Peer that runs it; `None` for brood.
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

/// Collected results, and reasons for missing ones.
pub struct Findings {
    results: BTreeMap<Measurement, Vec<Value>>,
    failed: BTreeSet<Measurement>,
    rounds: u32,
    /// Reasons for missing results, each once.
    pub missing: Vec<String>,
}

impl Findings {
    /// No results yet; starts with the peers missing from the environment.
    pub fn new(environment: &Environment) -> Self {
        Self::with_missing(environment.missing.clone())
    }

    /// No results yet; starts with the given reasons.
    pub fn with_missing(missing: Vec<String>) -> Self {
        Self { results: BTreeMap::new(), failed: BTreeSet::new(), rounds: 0, missing }
    }

    /// Runs every measurement once. A failed one is not tried again.
    pub fn round(&mut self, environment: &Environment) {
        self.rounds += 1;
        for work in Measurement::ALL {
            let is_available = work.peer().is_none_or(|peer| environment.has(peer));
            if !is_available || self.failed.contains(&work) {
                continue;
            }
            println!("{}", work.name());
            match self.measure(work, environment) {
                Ok(value) => self.add(work, value),
                Err(error) => {
                    eprintln!("skipping {}: {error:#}", work.name());
                    self.missing.push(format!("{}: {error:#}", work.name()));
                    self.failed.insert(work);
                }
            }
        }
    }

    /// Stores one result.
    pub fn add(&mut self, work: Measurement, value: Value) {
        self.results.entry(work).or_default().push(value);
    }

    /// Results of one measurement, one per round.
    pub fn of(&self, work: Measurement) -> &[Value] {
        self.results.get(&work).map_or(&[], Vec::as_slice)
    }

    /// All results as printed.
    pub fn raw(&self) -> Value {
        let named =
            self.results.iter().map(|(work, values)| (work.name().to_owned(), json!(values)));
        Value::Object(named.collect())
    }

    fn measure(&self, work: Measurement, environment: &Environment) -> Result<Value> {
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
        // Another seed each round, so that no kernel of an earlier round fits.
        let seed = self.rounds.to_string();
        let mut command = match work {
            Measurement::OperonOperations => script("operon.py", &[]),
            Measurement::BroodOperations => {
                bench(&["ops", "--passes", "15", "--programs", "200", "--seeds", "1"])
            }
            Measurement::BroodStress => bench(&["stress", "--evaluations", "2000000"]),
            Measurement::BroodSphere => bench(&["pareto", "--scene", "lambert-sphere"]),
            Measurement::MitsubaSphere => {
                // The albedo of brood's picture, because errors grow with it.
                let albedo =
                    self.of(Measurement::BroodSphere).first().and_then(|it| it["albedo"].as_f64());
                let albedo = albedo.unwrap_or(1.0).to_string();
                script("mitsuba_pictures.py", &["sphere", "--albedo", &albedo])
            }
            Measurement::MitsubaKnown => script("mitsuba_pictures.py", &["known", "--seed", &seed]),
            Measurement::MitsubaNew => {
                environment.clear_kernel_cache()?;
                script("mitsuba_pictures.py", &["new", "--seed", &seed])
            }
            Measurement::BroodFrame => bench(&["frame", "--size", "128", "--samples", "adaptive"]),
            Measurement::BroodBreed => bench(&["breed", "--size", "128", "--count", "50"]),
        };
        json_of(&mut command)
    }
}
