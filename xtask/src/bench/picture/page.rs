//! The comparison as a page of markdown.

use std::fmt::Write as _;

use serde_json::Value;

use super::row::{GOAL, Row};
use crate::bench::table::heading;

const NOTES: &str = "\
Linear RGB, RMSE over all pixels and channels of the whole picture. Mitsuba's noise is the RMSE between two of its pictures of \
different seed over sqrt 2; points and directions as lights leave nothing to chance but where in a pixel samples fall. *Beyond* is what \
remains of brood's RMSE without the noise of what it is held against.
- Fresh: 256 samples a pixel in both programs, in Mitsuba independent ones and a box filter; held against the mean of four of \
its pictures, which has half of the noise.
- Recorded: held against pictures made earlier of 64 samples a pixel, spread evenly (multijitter), which have all of the noise, here measured \
by four made anew; *anew* is how far the recorded picture is from their mean, 1.12 times the noise where nothing else differs. brood takes 1024 samples, in ambient light 64, each \
with 64 of the light.
- Sphere: 128 x 128, orthographic. Exact in Mitsuba, triangles with smooth normals in brood: its own 96 rows, for recorded pictures \
280.
- Spot: 192 x 192, perspective, with shadows. The file has no normals and renderers make different ones, so both are given \
the same: those of its triangles (*in facets*), round ones on a surface that Loop's rule has subdivided twice (*refined*), round \
ones on its own 5856 triangles (*spot*), and for recorded pictures those that Mitsuba makes, with creases along the texture's seams.
- Round normals on flat triangles are taken as Mitsuba takes them (`\"normals\": \"plain\"`): rays to the light leave the triangle, and \
where a normal turns away from the eye it is black.
- The direction along the surface, which anisotropic materials show, is one for each triangle in Mitsuba and interpolated between \
vertices in brood. Mitsuba's meshes are given brood's, so that the material is what is compared.
- Phong, Blinn-Phong and Ward are BSDFs in Python (`xtask/peer/mitsuba_models.py`), the others Mitsuba's own plugins.
";

/// The page.
pub fn markdown(rows: &[Row], missing: &[String], machine: &Value) -> String {
    let mut page = String::from("# brood's models and Mitsuba's\n\n");
    page.push_str(&heading(machine));
    let held = rows.iter().filter(|row| row.holds()).count();
    let _ = writeln!(
        page,
        "Off by less than {GOAL} times the peer's noise: {held} of {} pictures.",
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
    if !missing.is_empty() {
        page.push_str("\nNot compared:\n");
        for missing in missing {
            let _ = writeln!(page, "- {missing}");
        }
    }
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
    fn page_tells_how_many_hold_and_marks_the_others() {
        let rows = [row(1e-3, 1e-3), row(2.5e-3, 1e-3)];
        let page = markdown(&rows, &["all else".to_owned()], &json!({}));
        assert!(page.contains("1 of 2 pictures"), "{page}");
        let line = "| sphere | point | gold | 1.00e-3 | 2.50e-3 | **2.50** | 2.4e-3 | 2.00 |\n";
        assert!(page.contains(line), "{page}");
        assert!(page.contains("\n- all else\n") && !page.contains("## Recorded"), "{page}");
    }
}
