//! Where a benchmark's findings go: a table on the terminal or JSON, and, where a folder is named, CSV and SVG files.

use std::path::{Path, PathBuf};

use anyhow::Result;
use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};

use crate::chart::Table;
use crate::output;

/// One measurement that stands for itself: a table, what bounds it, and its chart.
#[derive(Debug)]
pub struct Finding {
    /// Names its files and its key in JSON.
    pub name: &'static str,
    /// How it was measured and what bounds it, for the reader of the table.
    pub note: String,
    /// What the chart shows.
    pub table: Table,
    /// Every single measurement behind the table, where there are more.
    pub raw: Option<Table>,
    /// SVG.
    pub chart: String,
}

/// Findings as a JSON object: a name, then its note and its rows.
#[derive(Debug)]
pub struct Findings<'a>(pub &'a [Finding]);

/// The folder given with `--out`, or none.
#[derive(Debug)]
pub struct Folder(Option<PathBuf>);

impl Finding {
    /// For a terminal.
    pub fn text(&self) -> String {
        format!("{}: {}\n{}\n", self.name, self.note, self.table.text())
    }
}

impl Serialize for Findings<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct Body<'a> {
            note: &'a str,
            rows: &'a Table,
        }
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for finding in self.0 {
            map.serialize_entry(finding.name, &Body { note: &finding.note, rows: &finding.table })?;
        }
        map.end()
    }
}

impl Folder {
    /// Makes the folder where one is named.
    pub fn make(path: Option<&Path>) -> Result<Self> {
        path.map(output::make_dir).transpose()?;
        Ok(Self(path.map(Path::to_owned)))
    }

    /// Writes a file into it; nothing where there is no folder.
    pub fn write(&self, name: &str, text: &str) -> Result<()> {
        match &self.0 {
            Some(folder) => output::write_file(&folder.join(name), text.as_bytes()),
            None => Ok(()),
        }
    }

    /// NAME.csv, NAME.svg and, where there is more behind the table, NAME-raw.csv.
    pub fn add(&self, finding: &Finding) -> Result<()> {
        self.write(&format!("{}.csv", finding.name), &finding.table.csv())?;
        self.write(&format!("{}.svg", finding.name), &finding.chart)?;
        match &finding.raw {
            Some(raw) => self.write(&format!("{}-raw.csv", finding.name), &raw.csv()),
            None => Ok(()),
        }
    }

    /// NAME.json, indented.
    pub fn add_json(&self, name: &str, value: &impl Serialize) -> Result<()> {
        self.write(&format!("{name}.json"), &(serde_json::to_string_pretty(value)? + "\n"))
    }
}
