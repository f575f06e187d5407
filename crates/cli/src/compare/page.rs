//! HTML page of a comparison: pictures in rows, curves, numbers. It refers only to files in the
//! same folder.

use brood_bench::chart::escape;

use super::{ComparedMaterial, ReferenceDifference};

const STYLE: &str = "\
:root { color-scheme: dark; }
body { background: #1e1e1e; color: #ddd; font: 15px/1.5 system-ui, sans-serif; margin: 2rem; }
table { border-collapse: collapse; }
th, td { padding: .3rem .7rem; text-align: left; vertical-align: top; }
td.number { text-align: right; font-variant-numeric: tabular-nums; }
td img { display: block; width: 15rem; }
img.chart { display: block; width: 48rem; max-width: 100%; background: #fff; margin-bottom: 1rem; }
.patch { display: inline-block; width: 2.2rem; height: 1.1rem; border: 1px solid #555; vertical-align: middle; }
tr + tr.numbers td { border-top: 1px solid #333; }
";

/// Renders the page.
pub fn html(all: &[ComparedMaterial], exposure_ev: f64) -> String {
    let mut text = String::from("<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n");
    text += "<meta name=\"viewport\" content=\"width=device-width\">\n";
    let names: Vec<String> = all.iter().map(|found| escape(&found.name)).collect();
    text += &format!("<title>{}</title>\n<style>\n{STYLE}</style>\n", names.join(" · "));
    text += &format!(
        "<h1>{}</h1>\n<p>One scene, one exposure ({exposure_ev:.3} EV). Differences are absolute, from the first material, of linear values after exposure.</p>\n<table>\n",
        names.join(" · ")
    );
    row(&mut text, "", all, |found| format!("<th scope=\"col\">{}</th>", escape(&found.name)));
    let picture = |file: &str, what: &str, found: &ComparedMaterial| {
        format!("<td><img src=\"{file}\" alt=\"{}, {what}\"></td>", escape(&found.name))
    };
    row(&mut text, "picture", all, |found| picture(&found.picture, "picture", found));
    row(&mut text, "under another light", all, |found| {
        picture(&found.other_light, "under another light", found)
    });
    row(&mut text, "difference", all, |found| match &found.difference {
        Some(difference) => picture(&difference.picture, "difference from the reference", found),
        None => "<td>reference</td>".to_owned(),
    });
    numbers(&mut text, all);
    text += "</table>\n";
    for (file, what) in [("albedo.svg", "Directional albedo"), ("fresnel.svg", "Fresnel rise")] {
        text += &format!("<img class=\"chart\" src=\"{file}\" alt=\"{what}\">\n");
    }
    text + "<p><a href=\"curves.csv\">curves.csv</a>, <a href=\"report.json\">report.json</a></p>\n</html>\n"
}

/// Adds the rows of the differences and of the phenomena.
fn numbers(text: &mut String, all: &[ComparedMaterial]) {
    let number = |value: Option<f64>| match value {
        Some(value) => format!("<td class=\"number\">{value:.4}</td>"),
        None => "<td class=\"number\">-</td>".to_owned(),
    };
    let of = |found: &ComparedMaterial, pick: fn(&ReferenceDifference) -> f64| {
        found.difference.as_ref().map(pick)
    };
    row(text, "RMSE", all, |found| number(of(found, |difference| difference.rmse)));
    row(text, "mean FLIP", all, |found| number(of(found, |difference| difference.flip)));
    row(text, "largest albedo; above 1 is not energy-conserving", all, |found| {
        number(Some(found.phenomena.largest_albedo))
    });
    row(text, "Fresnel rise: mirror direction at 80° over the normal", all, |found| {
        number(Some(found.phenomena.fresnel_rise))
    });
    row(text, "energy kept over roughness, 1 is all of it", all, |found| {
        number(found.phenomena.energy_kept)
    });
    row(text, "colour of the highlight", all, |found| patch(found.phenomena.highlight));
    row(text, "colour of the body", all, |found| patch(found.phenomena.body));
    row(text, "exposure range as the light circles", all, |found| {
        let [low, high] = found.phenomena.exposures_ev;
        format!("<td class=\"number\">{low:.2} to {high:.2} EV</td>")
    });
}

/// Adds a row with a cell for each material.
fn row(
    text: &mut String,
    name: &str,
    all: &[ComparedMaterial],
    cell: impl Fn(&ComparedMaterial) -> String,
) {
    let cells: String = all.iter().map(cell).collect();
    *text += &format!("<tr><th scope=\"row\">{name}</th>{cells}</tr>\n");
}

/// Cell with a colour patch and its linear values.
fn patch(rgb: [f64; 3]) -> String {
    let [r, g, b] = rgb.map(|channel| brood_eval::encode_srgb(channel as f32));
    let [x, y, z] = rgb;
    format!(
        "<td><span class=\"patch\" style=\"background: rgb({r} {g} {b})\"></span> {x:.2} {y:.2} {z:.2}</td>"
    )
}
