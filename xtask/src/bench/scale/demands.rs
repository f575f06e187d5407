//! Demands of a brood: CPU time and bytes for a fixed part and for each child, by least squares
//! over broods of several sizes.

use std::fmt::Write;

use anyhow::{Context, Result};
use serde_json::{Value, json};

use super::sample::{Lab, Load, Sample, json_of_series, spread};
use super::statistics::Line;

const CHILDREN: [u32; 4] = [1, 4, 20, 64];
/// Few clients, so that requests seldom wait.
const CLIENTS: u32 = 4;

/// Kind of demand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// CPU time of the server.
    Server,
    /// CPU time of PostgreSQL.
    Database,
    /// CPU time of the client.
    Client,
    /// Growth of the database, indices included.
    Stored,
    /// Growth of the indices.
    Indices,
    /// Growth of the write-ahead log, for a few seconds after a checkpoint.
    Log,
}

impl Part {
    const ALL: [Self; 6] =
        [Self::Server, Self::Database, Self::Client, Self::Stored, Self::Indices, Self::Log];

    /// Description and unit.
    fn name(self) -> (&'static str, &'static str) {
        match self {
            Self::Server => ("server", "ms of a core"),
            Self::Database => ("PostgreSQL", "ms of a core"),
            Self::Client => ("client", "ms of a core"),
            Self::Stored => ("database, with indices", "bytes"),
            Self::Indices => ("indices", "bytes"),
            Self::Log => ("write-ahead log", "bytes"),
        }
    }

    /// Demand of a brood.
    fn of(self, sample: &Sample) -> Result<f64> {
        let ([server, database, client], [stored, indices, log]) =
            (sample.cpu_ms()?, sample.bytes()?);
        Ok(match self {
            Self::Server => server,
            Self::Database => database,
            Self::Client => client,
            Self::Stored => stored,
            Self::Indices => indices,
            Self::Log => log,
        })
    }
}

/// Measured and fitted demands.
pub struct Demands {
    cells: Vec<(u32, Vec<Sample>)>,
    lines: Vec<(Part, Line)>,
}

impl Demands {
    /// Measures all sizes of broods in turn, and fits a line to each demand.
    pub fn measure(lab: &Lab, rounds: u32) -> Result<Self> {
        let cells = lab.rounds(rounds, &CHILDREN, load)?;
        let fit = |part: Part| {
            let point = |(children, samples): &(u32, Vec<Sample>)| {
                Ok((f64::from(*children), spread(samples, |one| part.of(one))?[1]))
            };
            let points: Vec<(f64, f64)> = cells.iter().map(point).collect::<Result<_>>()?;
            Ok((part, Line::fit(&points)))
        };
        let lines = Part::ALL.into_iter().map(fit).collect::<Result<_>>()?;
        Ok(Self { cells, lines })
    }

    /// All samples and lines for the report.
    pub fn json(&self) -> Value {
        let lines = self.lines.iter().map(|(part, line)| {
            let (name, unit) = part.name();
            json!({ "of": name, "unit": unit, "fixed": line.fixed, "each": line.each, "error": line.error })
        });
        json!({ "lines": lines.collect::<Vec<_>>(), "series": json_of_series(&self.cells, load) })
    }

    /// Demand of a brood of this many children.
    pub fn at(&self, part: Part, children: u32) -> Result<f64> {
        let found = self.lines.iter().find(|(own, _)| *own == part);
        Ok(found.context("find a fitted demand")?.1.at(children.into()))
    }

    /// The table.
    pub fn markdown(&self) -> Result<String> {
        let mut text = format!(
            "\n## Demands of a brood\n\nOne server without quota, {CLIENTS} clients. Medians (rounds in turn: {}), warm-up \
             included, and the line of least squares of relative differences. Error: the largest difference of a \
             measured value from the line.\n\n| demand | unit |",
            self.cells.first().map_or(0, |(_, samples)| samples.len()),
        );
        for children in CHILDREN {
            write!(text, " brood of {children} |")?;
        }
        text += " fixed | each child | error |\n|---|---|---:|---:|---:|---:|---:|---:|---:|\n";
        for (part, line) in &self.lines {
            let (name, unit) = part.name();
            write!(text, "| {name} | {unit} |")?;
            for (_, samples) in &self.cells {
                write!(text, " {} |", figure(spread(samples, |one| part.of(one))?[1]))?;
            }
            let (fixed, each) = (figure(line.fixed), figure(line.each));
            writeln!(text, " {fixed} | {each} | {:.0} % |", 100.0 * line.error)?;
        }
        Ok(text)
    }
}

/// Number with about three digits.
fn figure(value: f64) -> String {
    match value.abs() {
        size if size < 1.0 => format!("{value:.3}"),
        size if size < 100.0 => format!("{value:.2}"),
        _ => format!("{value:.0}"),
    }
}

fn load(children: u32) -> Load {
    Load::new(CLIENTS, children)
}

#[cfg(test)]
mod tests {
    use super::figure;

    #[test]
    fn figures_have_about_three_digits() {
        assert_eq!([0.1234, 1.234, 123.4, -5.0].map(figure), ["0.123", "1.23", "123", "-5.00"]);
    }
}
