//! Rows of the comparison, and their tables.

use std::fmt::Write;

use anyhow::Result;
use serde_json::{Value, json};

use super::super::paragraphs;
use super::peer::{Found, Model};
use super::score::Scores;
use super::stage::{Grade, Object};
use super::{SIZE_PX, THREADS};

/// A fit by brood.
pub struct OwnFit {
    /// Time that it was given.
    pub limit_s: u32,
    /// Time that it took.
    pub seconds: f64,
    pub scores: Scores,
    /// Largest errors over the pictures, in degrees, if scenes were corrected: of lights as the
    /// camera sees them, and of cameras.
    pub scene_deg: Option<(f64, Option<f64>)>,
}

/// Fits of one material on one object, photographed in one way.
pub struct Row {
    pub material: &'static str,
    pub object: &'static str,
    pub grade: Grade,
    /// Number of photographs.
    pub pictures: u32,
    /// brood's fits, in ascending order of time; at least one.
    pub fits: Vec<OwnFit>,
    /// Results of Adam's fits.
    pub peers: Vec<(Model, Found, Scores)>,
}

/// Settings of the run.
pub struct Heading<'a> {
    pub strategy: &'a str,
    /// Seconds of brood's fits, in ascending order.
    pub seconds: &'a [u32],
    /// Numbers of photographs, in ascending order.
    pub pictures: &'a [u32],
}

impl OwnFit {
    /// Errors and time.
    fn scored(&self) -> (&Scores, f64) {
        (&self.scores, self.seconds)
    }
}

impl Row {
    /// The longest of brood's fits.
    fn longest(&self) -> &OwnFit {
        self.fits.last().expect("a row has a fit")
    }

    pub fn peer(&self, model: Model) -> Option<(&Found, &Scores)> {
        let found = self.peers.iter().find(|(each, ..)| *each == model)?;
        Some((&found.1, &found.2))
    }

    pub fn line(&self) -> String {
        let Self { material, object, grade, pictures, .. } = self;
        let errors: Vec<String> =
            self.fits.iter().map(|fit| format!("{:.3}", fit.scores.error())).collect();
        let errors = errors.join(", ");
        let mut line = format!("{material}, {object}, {}, {pictures}: {errors}", grade.name());
        for (model, _, scores) in &self.peers {
            line += &format!(", {} with Adam {:.3}", model.name(), scores.error());
        }
        line
    }

    pub fn json(&self) -> Value {
        let fit = |fit: &OwnFit| {
            let mut value = fit.scores.json();
            value["limit_s"] = json!(fit.limit_s);
            value["seconds"] = json!(fit.seconds);
            value["light_deg"] = json!(fit.scene_deg.map(|(light, _)| light));
            value["camera_deg"] = json!(fit.scene_deg.and_then(|(_, camera)| camera));
            value
        };
        let mut value = json!({
            "material": self.material, "object": self.object, "grade": self.grade.name(),
            "pictures": self.pictures, "fits": self.fits.iter().map(fit).collect::<Vec<_>>(),
        });
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
        let OwnFit { scores, scene_deg, .. } = self.longest();
        let lights: Vec<String> =
            scores.lights.iter().map(|score| format!("{:.3}", score.relative_rmse)).collect();
        let scene = scene_deg.map(|(light, camera)| {
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
            "| {} | {} | {} | {} | {:.3} | {} | {} | {} | {} |",
            self.material,
            self.object,
            self.grade.name(),
            self.pictures,
            scores.error(),
            lights.join(", "),
            cell(scores.mesh_error()),
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
pub fn median(mut errors: Vec<f64>) -> f64 {
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
    let words = |numbers: &[u32]| numbers.iter().map(u32::to_string).collect::<Vec<_>>().join(", ");
    let (strategy, pictures, seconds) =
        (heading.strategy, words(heading.pictures), words(heading.seconds));
    let mut text = format!(
        "# Materials from photographs, under other lights\n\n\
         Pictures of {SIZE_PX} x {SIZE_PX} pixels by Mitsuba, {pictures} of each material, one point light in each, or an \
         environment. `brood fit`, strategy {strategy}, {seconds} s on {THREADS} threads. Errors are RMSE / mean of Mitsuba's own \
         pictures under three other lights (root of the mean square of the three), and of a picture of a teapot, which no photograph \
         shows. The scene of misaligned pictures is stated with its uncertainties; errors of the corrected scene are those of the \
         light as the camera sees it and of the camera.\n\n\
         Of several times, tables show the longest unless they say the time. \
         Adam has Mitsuba's derivatives, the same pictures and stated scenes, which it does not correct, the longest time, the same threads, \
         and ten starts that share the time. `principled` knows nothing of the material; `generating` knows its plugin and fits its \
         numbers. Tracing and loading of kernels count as time; their compiler ran before, in a fit of the same kind.\n\n\
         | material | object | grade | pictures | error | by light | teapot | principled | teapot | generating | teapot | light, camera off by degrees |\n\
         |---|---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for row in rows {
        writeln!(text, "{}", row.markdown())?;
    }
    text.push_str(
        "\nMedians over materials. FLIP (HDR) and Delta E_ITP are means over the three lights. `generating` has no measured materials, \
         so a line of brood's has its materials alone. Seconds are those of brood's fit, and those until Adam's loss was within 5 % \
         of its least.\n\n\
         | grade | object | pictures | by | materials | error | worst | teapot | FLIP | Delta E_ITP | seconds | light, camera off by degrees |\n\
         |---|---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    let groups = groups(rows, heading.pictures);
    for group in &groups {
        text += &medians(group);
    }
    if heading.seconds.len() > 1 {
        text.push_str(
            "\nMedians over materials by the time of brood's fits, and the number of materials whose error is no larger than that of \
             `principled` after the longest time.\n\n\
             | grade | object | pictures | seconds | error | FLIP | Delta E_ITP | no farther than principled |\n\
             |---|---|---|---|---|---|---|---|\n",
        );
        for group in &groups {
            for time in 0..heading.seconds.len() {
                writeln!(text, "{}", by_time(group, time))?;
            }
        }
    }
    Ok(text + &paragraphs(missing))
}

/// Rows of the same object, photographed in the same way; at least one.
fn groups<'a>(rows: &'a [Row], pictures: &[u32]) -> Vec<Vec<&'a Row>> {
    let mut groups = Vec::new();
    for grade in Grade::ALL {
        for object in Object::ALL {
            for &count in pictures {
                let is_in = |row: &&Row| {
                    row.grade == grade && row.object == object.name() && row.pictures == count
                };
                let group: Vec<&Row> = rows.iter().filter(is_in).collect();
                if !group.is_empty() {
                    groups.push(group);
                }
            }
        }
    }
    groups
}

/// Cells that name a group.
fn name(group: &[&Row]) -> String {
    let Row { grade, object, pictures, .. } = group[0];
    format!("| {} | {object} | {pictures} |", grade.name())
}

/// Line of a group's fits of one time, by its place among the times.
fn by_time(group: &[&Row], time: usize) -> String {
    let fits: Vec<&OwnFit> = group.iter().map(|row| &row.fits[time]).collect();
    let of = |value: fn(&Scores) -> f64| {
        cell(Some(median(fits.iter().map(|fit| value(&fit.scores)).collect())))
    };
    let peers: Vec<(f64, f64)> = group
        .iter()
        .filter_map(|row| {
            let (_, peer) = row.peer(Model::Principled)?;
            Some((row.fits[time].scores.error(), peer.error()))
        })
        .collect();
    let as_near = peers.iter().filter(|(own, peer)| own <= peer).count();
    let as_near = match peers.len() {
        0 => String::new(),
        all => format!("{as_near} of {all}"),
    };
    let (error, flip, itp) = (of(Scores::error), of(Scores::flip), of(Scores::itp));
    format!("{} {} | {error} | {flip} | {itp} | {as_near} |", name(group), fits[0].limit_s)
}

/// Lines of a group.
fn medians(rows: &[&Row]) -> String {
    let line = |by: &str, each: &[(&Scores, f64)], scene: &str| {
        let of = |value: fn(&Scores) -> Option<f64>| {
            cell(Some(median(each.iter().filter_map(|(scores, _)| value(scores)).collect())))
        };
        let worst = each.iter().map(|(scores, _)| scores.error()).fold(0.0, f64::max);
        let seconds = median(each.iter().map(|(_, seconds)| *seconds).collect());
        format!(
            "{} {by} | {} | {} | {worst:.3} | {} | {} | {} | {seconds:.1} | {scene} |\n",
            name(rows),
            each.len(),
            of(|scores| Some(scores.error())),
            of(Scores::mesh_error),
            of(|scores| Some(scores.flip())),
            of(|scores| Some(scores.itp())),
        )
    };
    let own = |row: &&Row| -> bool { row.peer(Model::Generating).is_some() };
    let scenes: Vec<(f64, Option<f64>)> =
        rows.iter().filter_map(|row| row.longest().scene_deg).collect();
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
    let all: Vec<_> = rows.iter().map(|row| row.longest().scored()).collect();
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
                rows.iter().filter(|row| own(row)).map(|row| row.longest().scored()).collect();
            text += &line("brood", &same, "");
        }
        text += &line(&format!("{} with Adam", model.name()), &each, "");
    }
    text
}
