//! Rows of the comparison, and their tables.

use std::fmt::Write;

use anyhow::Result;
use serde_json::{Value, json};

use super::super::paragraphs;
use super::peer::{Found, Model};
use super::score::Scores;
use super::stage::{Grade, Object};
use super::{SIZE_PX, THREADS};

/// Errors of the fits of one material on one object, photographed in one way.
pub struct Row {
    pub material: &'static str,
    pub object: &'static str,
    pub grade: Grade,
    /// Errors of brood's fit.
    pub own: Scores,
    /// Largest errors over the pictures, in degrees, if scenes were corrected: of lights as the
    /// camera sees them, and of cameras.
    pub scene_deg: Option<(f64, Option<f64>)>,
    pub seconds: f64,
    /// Results of Adam's fits.
    pub peers: Vec<(Model, Found, Scores)>,
}

/// Settings of the run.
pub struct Heading<'a> {
    pub strategy: &'a str,
    pub seconds: u32,
    pub pictures: u32,
}

impl Row {
    fn peer(&self, model: Model) -> Option<(&Found, &Scores)> {
        let found = self.peers.iter().find(|(each, ..)| *each == model)?;
        Some((&found.1, &found.2))
    }

    pub fn line(&self) -> String {
        let Self { material, object, grade, .. } = self;
        let mut line = format!("{material}, {object}, {}: {:.3}", grade.name(), self.own.error());
        for (model, _, scores) in &self.peers {
            line += &format!(", {} with Adam {:.3}", model.name(), scores.error());
        }
        line
    }

    pub fn json(&self) -> Value {
        let mut value = self.own.json();
        value["material"] = json!(self.material);
        value["object"] = json!(self.object);
        value["grade"] = json!(self.grade.name());
        value["seconds"] = json!(self.seconds);
        value["light_deg"] = json!(self.scene_deg.map(|(light, _)| light));
        value["camera_deg"] = json!(self.scene_deg.and_then(|(_, camera)| camera));
        for (model, found, scores) in &self.peers {
            let mut peer = scores.json();
            peer["seconds"] = json!(found.seconds);
            peer["seconds_to_best"] = json!(found.seconds_to_best);
            peer["steps"] = json!(found.steps);
            value["adam"][model.name()] = peer;
        }
        value
    }

    fn markdown(&self) -> String {
        let lights: Vec<String> =
            self.own.lights.iter().map(|score| format!("{:.3}", score.relative_rmse)).collect();
        let scene = self.scene_deg.map(|(light, camera)| {
            format!("{light:.2}, {}", camera.map_or_else(String::new, |deg| format!("{deg:.2}")))
        });
        let peers = Model::ALL.map(|model| {
            let scores = self.peer(model).map(|(_, scores)| scores);
            format!(
                "{} | {}",
                cell(scores.map(Scores::error)),
                cell(scores.and_then(Scores::mesh_error))
            )
        });
        format!(
            "| {} | {} | {} | {:.3} | {} | {} | {} | {} |",
            self.material,
            self.object,
            self.grade.name(),
            self.own.error(),
            lights.join(", "),
            cell(self.own.mesh_error()),
            peers.join(" | "),
            scene.unwrap_or_default()
        )
    }
}

/// Number of a table; empty if there is none.
fn cell(value: Option<f64>) -> String {
    value.filter(|value| !value.is_nan()).map_or_else(String::new, |value| format!("{value:.3}"))
}

/// Median of errors; NaN if there are none.
fn median(mut errors: Vec<f64>) -> f64 {
    errors.sort_by(f64::total_cmp);
    let middle = errors.len() / 2;
    match errors.len() {
        0 => f64::NAN,
        odd if odd % 2 == 1 => errors[middle],
        _ => 0.5 * (errors[middle - 1] + errors[middle]),
    }
}

/// The report as Markdown.
pub fn markdown(rows: &[Row], heading: &Heading<'_>, missing: &[String]) -> Result<String> {
    let Heading { strategy, seconds, pictures } = heading;
    let mut text = format!(
        "# Materials from photographs, under other lights\n\n\
         Pictures of {SIZE_PX} x {SIZE_PX} pixels by Mitsuba, {pictures} of each material, one point light in each, or an \
         environment. `brood fit`, strategy {strategy}, {seconds} s on {THREADS} threads. Errors are RMSE / mean of Mitsuba's own \
         pictures under three other lights (root of the mean square of the three), and of a picture of a teapot, which no photograph \
         shows. The scene of misaligned pictures is stated with its uncertainties; errors of the corrected scene are those of the \
         light as the camera sees it and of the camera.\n\n\
         Adam has Mitsuba's derivatives, the same pictures and stated scenes, which it does not correct, the same time and threads, \
         and ten starts that share the time. `principled` knows nothing of the material; `generating` knows its plugin and fits its \
         numbers. Tracing and loading of kernels count as time; their compiler ran before, in a fit of the same kind.\n\n\
         | material | object | grade | error | by light | teapot | principled | teapot | generating | teapot | light, camera off by degrees |\n\
         |---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for row in rows {
        writeln!(text, "{}", row.markdown())?;
    }
    text.push_str(
        "\nMedians over materials. FLIP (HDR) and Delta E_ITP are means over the three lights. `generating` has no measured materials, \
         so a line of brood's has its materials alone. Seconds are those of brood's fit, and those until Adam's loss was within 5 % \
         of its least.\n\n\
         | grade | object | by | materials | error | worst | teapot | FLIP | Delta E_ITP | seconds | light, camera off by degrees |\n\
         |---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for grade in Grade::ALL {
        for object in Object::ALL {
            let of: Vec<&Row> = rows
                .iter()
                .filter(|row| row.grade == grade && row.object == object.name())
                .collect();
            if !of.is_empty() {
                write!(text, "{}", medians(grade, object, &of))?;
            }
        }
    }
    Ok(text + &paragraphs(missing))
}

/// Lines of one grade and object.
fn medians(grade: Grade, object: Object, rows: &[&Row]) -> String {
    let line = |by: &str, each: &[(&Scores, f64)], scene: &str| {
        let of = |value: fn(&Scores) -> Option<f64>| {
            cell(Some(median(each.iter().filter_map(|(scores, _)| value(scores)).collect())))
        };
        let worst = each.iter().map(|(scores, _)| scores.error()).fold(0.0, f64::max);
        let seconds = median(each.iter().map(|(_, seconds)| *seconds).collect());
        format!(
            "| {} | {} | {by} | {} | {} | {worst:.3} | {} | {} | {} | {seconds:.1} | {scene} |\n",
            grade.name(),
            object.name(),
            each.len(),
            of(|scores| Some(scores.error())),
            of(Scores::mesh_error),
            of(|scores| Some(scores.flip())),
            of(|scores| Some(scores.itp())),
        )
    };
    let own = |row: &&Row| -> bool { row.peer(Model::Generating).is_some() };
    let scenes: Vec<(f64, Option<f64>)> = rows.iter().filter_map(|row| row.scene_deg).collect();
    let off = |values: Vec<f64>| match median(values) {
        value if value.is_nan() => String::new(),
        value => format!("{value:.2}"),
    };
    let scene = if scenes.is_empty() {
        String::new()
    } else {
        let lights = off(scenes.iter().map(|(light, _)| *light).collect());
        format!("{lights}, {}", off(scenes.iter().filter_map(|(_, camera)| *camera).collect()))
    };
    let all: Vec<_> = rows.iter().map(|row| (&row.own, row.seconds)).collect();
    let mut text = line("brood", &all, &scene);
    for model in Model::ALL {
        let each: Vec<_> = rows
            .iter()
            .filter_map(|row| row.peer(model))
            .map(|(found, scores)| (scores, found.seconds_to_best))
            .collect();
        if each.is_empty() {
            continue;
        }
        if each.len() < rows.len() && model == Model::Generating {
            let same: Vec<_> =
                rows.iter().filter(|row| own(row)).map(|row| (&row.own, row.seconds)).collect();
            text += &line("brood", &same, "");
        }
        text += &line(&format!("{} with Adam", model.name()), &each, "");
    }
    text
}
