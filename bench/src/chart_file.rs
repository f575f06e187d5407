//! `brood bench chart`: draws series of points that another program measured.
//!
//! Owns the format of the file; `chart` draws.

use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use clap::Args;
use serde::Deserialize;
use serde_json::json;

use crate::chart::{Axis, Plot, Point, Series};
use crate::output;

const FILE_BYTES: u64 = 16 << 20;

/// Options of `brood bench chart`.
#[derive(Debug, Args)]
pub struct BenchChartArgs {
    /// JSON file: {"title", "subtitle", "x": {"title", "is_log"}, "y": {…}, "series": [{"name",
    /// "points": [[x, y], …]}, …]}; "-" is stdin
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// The chart, an SVG
    #[arg(long, short, value_name = "FILE")]
    output: PathBuf,
}

/// The file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ChartFile {
    title: String,
    subtitle: String,
    x: FileAxis,
    y: FileAxis,
    series: Vec<FileSeries>,
}

/// An axis of the file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct FileAxis {
    /// Quantity, with its unit.
    title: String,
    /// True if equal ratios have equal lengths.
    #[serde(default)]
    is_log: bool,
}

/// A series of the file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct FileSeries {
    name: String,
    /// Pairs of x and y.
    points: Vec<[f64; 2]>,
}

impl FileAxis {
    fn axis(self) -> Axis {
        if self.is_log { Axis::log(self.title) } else { Axis::linear(self.title) }
    }
}

impl ChartFile {
    fn plot(self) -> Plot {
        let series = |each: FileSeries| {
            let points = each.points.into_iter().map(|[x, y]| Point { x, y, ..Point::default() });
            Series::dotted(&each.name, points)
        };
        Plot {
            title: self.title,
            subtitle: self.subtitle,
            x: self.x.axis(),
            y: self.y.axis(),
            series: self.series.into_iter().map(series).collect(),
        }
    }
}

/// Runs `brood bench chart`.
pub fn run(args: &BenchChartArgs, json: bool) -> Result<()> {
    let bytes = output::read_input(&args.file, FILE_BYTES)?;
    let name = args.file.display();
    let file: ChartFile =
        serde_json::from_slice(&bytes).with_context(|| format!("{name} must be a chart"))?;
    let plot = file.plot();
    let shown = plot.series.iter().flat_map(|series| &series.points).filter(|point| {
        let [x, y] =
            [(&plot.x, point.x), (&plot.y, point.y)].map(|(axis, value)| axis.scale.shows(value));
        x && y
    });
    let points = shown.count();
    ensure!(points > 0, "{name}: there is no point that the axes can show");
    output::write_file(&args.output, plot.svg().as_bytes())?;
    if json {
        return output::print_json(&json!({"file": args.output, "points": points}));
    }
    output::print(&format!("{}: {points} points", args.output.display()))
}

#[cfg(test)]
mod tests {
    use super::ChartFile;

    fn read(text: &str) -> Result<ChartFile, serde_json::Error> {
        serde_json::from_str(text)
    }

    #[test]
    fn a_file_becomes_a_chart_when_it_has_all_parts() {
        let text = r#"{"title": "Error", "subtitle": "one sphere", "x": {"title": "time, s", "is_log": true},
            "y": {"title": "RMSE"},
            "series": [{"name": "brood", "points": [[1, 0.1], [10, 0.05]]}, {"name": "Adam", "points": [[10, 0.2]]}]}"#;
        let svg = read(text).unwrap().plot().svg();
        assert!(["time, s", "brood", "Adam"].iter().all(|text| svg.contains(text)), "{svg}");
        assert!(read(&text.replace("is_log", "log")).is_err());
        assert!(read(&text.replace("\"subtitle\": \"one sphere\", ", "")).is_err());
    }
}
