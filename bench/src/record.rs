//! Output of the benchmarks: a table or JSON on standard output and, with `--out`, CSV, SVG and
//! JSON files in a folder.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};

use crate::chart::{Chart, ResultTable};
use crate::{logging, output};

/// Options of a benchmark that writes files.
#[derive(Debug, Args)]
pub struct CommonArgs {
    /// Seed of the random draws; inputs that a benchmark fixes do not depend on it
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Folder for the results: NAME.json and, if the benchmark has them, tables as CSV, charts as
    /// SVG and pictures
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// Options of a benchmark that draws its inputs anew for several seeds.
#[derive(Debug, Args)]
pub struct SeedsArgs {
    /// Number of seeds, from --seed on: figures are medians, with quartiles [default: 20; 2 of a
    /// short run]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    seeds: Option<u32>,
}

impl SeedsArgs {
    /// Returns the seeds from `first` on.
    pub fn list(&self, first: u64, is_short: bool) -> Vec<u64> {
        let count = self.seeds.unwrap_or(if is_short { 2 } else { 20 });
        (0..count).map(|index| first.wrapping_add(index.into())).collect()
    }

    /// Measures with each seed from `first` on and merges the findings.
    ///
    /// # Errors
    /// Returns the first error of a measurement.
    pub fn measure(
        &self,
        first: u64,
        is_short: bool,
        measure: impl Fn(u64) -> Result<Vec<Finding>>,
    ) -> Result<Vec<Finding>> {
        let seeds = self.list(first, is_short);
        let bar = output::bar(seeds.len() as u64, "seeds");
        let mut found: Vec<Vec<(u64, Finding)>> = Vec::new();
        for seed in seeds.iter().copied() {
            for (index, finding) in measure(seed)?.into_iter().enumerate() {
                match found.get_mut(index) {
                    Some(of) => of.push((seed, finding)),
                    None => found.push(vec![(seed, finding)]),
                }
            }
            bar.inc(1);
        }
        bar.finish_and_clear();
        if seeds.len() == 1 {
            return Ok(found.into_iter().flatten().map(|(_, finding)| finding).collect());
        }
        Ok(found.iter().map(|findings| Finding::quartiles(findings)).collect())
    }
}

impl CommonArgs {
    /// Starts the log and creates the folder if one is given.
    pub fn start(&self) -> Result<Folder> {
        logging::start_offline();
        self.out.as_deref().map(output::make_dir).transpose()?;
        Ok(Folder(self.out.clone()))
    }
}

/// One result: a table, its chart, and a note on the method and the error.
#[derive(Debug)]
pub struct Finding {
    /// Stem of its files, and its key in JSON.
    pub name: &'static str,
    /// Method of measurement and error bounds, for the reader of the table.
    pub note: String,
    /// Rows of the chart.
    pub table: ResultTable,
    /// Every single measurement behind the table, if there are more.
    pub raw: Option<ResultTable>,
    /// Chart of the table.
    pub chart: Chart,
}

/// Findings as a JSON object from name to note and rows.
#[derive(Debug)]
pub struct Findings<'a>(pub &'a [Finding]);

/// Folder given with `--out`, if any.
#[derive(Debug)]
pub struct Folder(Option<PathBuf>);

impl Finding {
    /// Merges the findings of several seeds: medians and quartiles of everything that differs, and
    /// all raw measurements.
    ///
    /// # Panics
    /// Panics if the findings have different rows, series or kinds of chart, or there is none.
    fn quartiles(findings: &[(u64, Self)]) -> Self {
        let first = &findings.first().expect("there is a finding").1;
        let seeds = findings.len();
        let tables: Vec<ResultTable> = findings.iter().map(|(_, one)| one.table.clone()).collect();
        let mut raw = ResultTable::default();
        for (seed, finding) in findings {
            if let Some(own) = &finding.raw {
                raw.append("seed", *seed, own);
            }
        }
        let about = format!("; median and quartiles of {seeds} seeds");
        let charts: Vec<&Chart> = findings.iter().map(|(_, finding)| &finding.chart).collect();
        Self {
            name: first.name,
            note: first.note.clone() + &about,
            table: ResultTable::quartiles(&tables),
            raw: first.raw.as_ref().map(|_| raw),
            chart: Chart::quartiles(&charts, &about),
        }
    }

    /// Text for a terminal.
    pub fn text(&self) -> String {
        format!("{}: {}\n{}\n", self.name, self.note, self.table.text())
    }
}

impl Serialize for Findings<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct Body<'a> {
            note: &'a str,
            rows: &'a ResultTable,
        }
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for finding in self.0 {
            map.serialize_entry(finding.name, &Body { note: &finding.note, rows: &finding.table })?;
        }
        map.end()
    }
}

impl Folder {
    /// Writes a file into the folder; does nothing without one.
    pub fn write(&self, name: &str, text: &str) -> Result<()> {
        match &self.0 {
            Some(folder) => output::write_file(&folder.join(name), text.as_bytes()),
            None => Ok(()),
        }
    }

    /// Writes NAME.csv, NAME.svg and, if there are raw measurements, NAME-raw.csv.
    pub fn add(&self, finding: &Finding) -> Result<()> {
        self.write(&format!("{}.csv", finding.name), &finding.table.csv())?;
        self.write(&format!("{}.svg", finding.name), &finding.chart.svg())?;
        match &finding.raw {
            Some(raw) => self.write(&format!("{}-raw.csv", finding.name), &raw.csv()),
            None => Ok(()),
        }
    }

    /// Writes the only finding of a benchmark and NAME.json, and prints it.
    pub fn finish(&self, finding: Finding, json: bool) -> Result<()> {
        self.add(&finding)?;
        let findings = [finding];
        self.add_json(findings[0].name, &Findings(&findings))?;
        match json {
            true => output::print_json(&Findings(&findings)),
            false => output::print(&findings[0].text()),
        }
    }

    /// Writes the only finding of a benchmark, and its rows as NAME.json. Prints the note and the
    /// table, or the rows as JSON.
    pub fn finish_table(&self, finding: &Finding, json: bool) -> Result<()> {
        let Finding { name, note, table, .. } = finding;
        self.add(finding)?;
        self.add_json(name, table)?;
        match json {
            true => output::print(&(serde_json::to_string_pretty(table)? + "\n")),
            false => output::print(&format!("{note}\n{}", table.text())),
        }
    }

    /// Writes NAME.json, and prints the rows as text or as one line of JSON.
    pub fn finish_rows<T: Serialize>(
        &self,
        name: &str,
        rows: &[T],
        (head, line): (&str, impl Fn(&T) -> String),
        json: bool,
    ) -> Result<()> {
        self.add_json(name, &rows)?;
        match json {
            true => output::print_json(&serde_json::to_value(rows)?),
            false => output::print(&(head.to_owned() + &rows.iter().map(line).collect::<String>())),
        }
    }

    /// Writes NAME.json, indented.
    pub fn add_json(&self, name: &str, value: &impl Serialize) -> Result<()> {
        self.write(&format!("{name}.json"), &(serde_json::to_string_pretty(value)? + "\n"))
    }
}
