//! Charts of error against the number of photographs and against time, which `brood bench chart`
//! draws.

use std::path::Path;

use anyhow::{Context, Result};
use serde_json::{Value, json};

use super::super::environment::{Environment, json_of};
use super::peer::Model;
use super::stage::Grade;
use super::table::{Heading, Row, median};

/// Draws the charts of all that was varied, beside the report.
pub fn draw(
    environment: &Environment,
    rows: &[Row],
    heading: &Heading<'_>,
    folder: &Path,
) -> Result<()> {
    if heading.pictures.len() > 1 {
        let chart = by_pictures(rows, heading);
        draw_one(environment, &folder.join("photographs-by-pictures"), &chart)?;
    }
    if heading.seconds.len() > 1 {
        let chart = by_seconds(rows, heading);
        draw_one(environment, &folder.join("photographs-by-seconds"), &chart)?;
    }
    Ok(())
}

fn draw_one(environment: &Environment, path: &Path, chart: &Value) -> Result<()> {
    let file = path.with_extension("json");
    std::fs::write(&file, format!("{chart:#}\n")).context("write the points of a chart")?;
    let mut draw = environment.brood();
    draw.args(["bench", "chart", "--json"]).arg(file);
    json_of(draw.arg("--output").arg(path.with_extension("svg")))?;
    Ok(())
}

/// Error of the longest fits against the number of photographs.
fn by_pictures(rows: &[Row], heading: &Heading<'_>) -> Value {
    let points = |grade: Grade, model: Option<Model>| {
        let each = heading.pictures.iter();
        let time = heading.seconds.len() - 1;
        each.map(|&count| (f64::from(count), error(rows, (grade, count), time, model))).collect()
    };
    chart("Error by the number of photographs", "photographs", series(rows, points))
}

/// Error of fits to the fewest photographs against time.
fn by_seconds(rows: &[Row], heading: &Heading<'_>) -> Value {
    let count = heading.pictures[0];
    let points = |grade: Grade, model: Option<Model>| {
        let times = heading.seconds.iter().enumerate();
        let each = times.map(|(time, &seconds)| {
            // The peers have the longest time alone.
            let is_known = model.is_none() || time + 1 == heading.seconds.len();
            let error = if is_known { error(rows, (grade, count), time, model) } else { f64::NAN };
            (f64::from(seconds), error)
        });
        each.collect()
    };
    chart("Error by the time of the fit", "time of the fit, s", series(rows, points))
}

/// Points of each grade and program: brood, and those models that were fitted.
fn series(rows: &[Row], points: impl Fn(Grade, Option<Model>) -> Vec<(f64, f64)>) -> Vec<Value> {
    let mut series = Vec::new();
    for grade in Grade::ALL {
        for model in [None, Some(Model::Principled), Some(Model::Generating)] {
            let known: Vec<(f64, f64)> =
                points(grade, model).into_iter().filter(|(_, error)| error.is_finite()).collect();
            if rows.iter().any(|row| row.grade == grade) && !known.is_empty() {
                let by = model.map_or("brood", Model::name);
                series.push(json!({"name": format!("{}, {by}", grade.name()), "points": known}));
            }
        }
    }
    series
}

/// Median error under unseen lights, over the materials on all objects; NaN if there is none.
fn error(rows: &[Row], (grade, pictures): (Grade, u32), time: usize, model: Option<Model>) -> f64 {
    let rows = rows.iter().filter(|row| row.grade == grade && row.pictures == pictures);
    let of = |row: &Row| match model {
        None => Some(row.fits[time].scores.error()),
        Some(model) => row.peer(model).map(|(_, scores)| scores.error()),
    };
    median(rows.filter_map(of).collect())
}

fn chart(title: &str, x: &str, series: Vec<Value>) -> Value {
    json!({
        "title": title, "subtitle": "medians over materials on all objects, under lights that no photograph shows",
        "x": {"title": x, "is_log": true}, "y": {"title": "RMSE / mean", "is_log": true},
        "series": series,
    })
}
