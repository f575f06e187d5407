//! Comparison of pictures as a Markdown page.

use std::fmt::Write as _;

use serde_json::Value;

use super::row::{GOAL, Row};
use crate::bench::not_compared;
use crate::bench::table::heading;

const NOTES: &str = "\
Linear RGB, RMSE over all pixels and channels of the whole picture. Mitsuba's noise is the RMSE between two of its pictures of \
different seeds over sqrt 2; with point and directional lights only the positions of samples within a pixel are random. *Beyond* is \
brood's RMSE without the noise of the picture it is compared with.
- Fresh: 256 samples per pixel in both programs, in Mitsuba independent ones and a box filter; compared with the mean of four of \
its pictures, which has half of the noise.
- Recorded: compared with earlier pictures of 64 stratified samples per pixel (multijitter), which have the full noise, measured here \
from four new ones; *anew* is the RMSE between the recorded picture and their mean, 1.12 times the noise if nothing else differs. brood takes 1024 samples, in ambient light 64, each \
with 64 samples of the light.
- Sphere: 128 x 128, orthographic. Analytic in Mitsuba, triangles with smooth normals in brood: 96 rows, for recorded pictures \
280.
- Spot: 192 x 192, perspective, with shadows. The file has no normals and renderers compute different ones, so both are given \
the same: those of its triangles (*in facets*), smooth ones on a surface subdivided twice by Loop's rule (*refined*), smooth \
ones on its own 5856 triangles (*spot*), and for recorded pictures those of Mitsuba, with creases along the texture's seams.
- Smooth normals on flat triangles are treated as in Mitsuba (`\"normals\": \"plain\"`): shadow rays start at the triangle, and \
pixels whose normal faces away from the eye are black.
- The tangent, visible with anisotropic materials, is constant per triangle in Mitsuba and interpolated between \
vertices in brood. Mitsuba's meshes are given brood's tangents, so that only the materials are compared.
- Phong, Blinn-Phong and Ward are BSDFs in Python (`xtask/peer/mitsuba_models.py`), the others Mitsuba's own plugins.
";

/// Renders the page.
pub fn markdown(rows: &[Row], missing: &[String], machine: &Value) -> String {
    let mut page = String::from("# brood's models and Mitsuba's\n\n");
    page.push_str(&heading(machine));
    let passed = rows.iter().filter(|row| row.holds()).count();
    let _ = writeln!(
        page,
        "RMSE below {GOAL} times the peer's noise: {passed} of {} pictures.",
        rows.len()
    );
    for recorded in [false, true] {
        let rows: Vec<&Row> = rows.iter().filter(|row| row.recorded == recorded).collect();
        if rows.is_empty() {
            continue;
        }
        let _ = writeln!(page, "\n## {}\n", if recorded { "Recorded" } else { "Fresh" });
        page.push_str(&table(&rows, recorded));
    }
    page.push_str(&not_compared(missing));
    let _ = write!(page, "\n{NOTES}");
    page
}

fn table(rows: &[&Row], recorded: bool) -> String {
    let (anew, rule) = if recorded { (" anew |", "---:|") } else { ("", "") };
    let mut text = format!(
        "| object | light | material | noise | brood's RMSE | times | beyond | brightest |{anew}\n\
         |---|---|---|---:|---:|---:|---:|---:|{rule}\n"
    );
    for row in rows {
        let times = format!("{:.2}", row.times());
        let times = if row.holds() { times } else { format!("**{times}**") };
        let anew =
            row.recorded_rmse.map_or_else(String::new, |recorded| format!(" {recorded:.2e} |"));
        let _ = writeln!(
            text,
            "| {} | {} | {} | {:.2e} | {:.2e} | {times} | {:.1e} | {:.2} |{anew}",
            row.object,
            row.light,
            row.material,
            row.noise,
            row.rmse,
            row.beyond_noise(),
            row.brightest,
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::markdown;
    use crate::bench::picture::row::tests::row;
    use serde_json::json;

    #[test]
    fn page_counts_passing_rows_and_marks_the_others() {
        let rows = [row(1e-3, 1e-3), row(2.5e-3, 1e-3)];
        let page = markdown(&rows, &["all else".to_owned()], &json!({}));
        assert!(page.contains("1 of 2 pictures"), "{page}");
        let line = "| sphere | point | gold | 1.00e-3 | 2.50e-3 | **2.50** | 2.4e-3 | 2.00 |\n";
        assert!(page.contains(line), "{page}");
        assert!(page.contains("\n- all else\n") && !page.contains("## Recorded"), "{page}");
    }
}
