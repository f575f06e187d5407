//! Report of the spread of materials that match pictures: expected error, map and next picture.

use std::path::Path;

use anyhow::{Context, Result};
use brood_bench::output;
use brood_eval::{Developed, encode_png};
use brood_search::{NextPicture, Spread};
use brood_target::{KnownView, MeasuredTarget};
use brood_worker::{darkest_and_brightest, map_picture};
use serde_json::{Value, json};

/// Spread of the materials that match pictures, as JSON and for a terminal.
pub struct SpreadReport {
    pub json: Value,
    pub text: String,
}

impl SpreadReport {
    /// Measures the spread, and writes known.png, darkest.png, brightest.png and next.json.
    pub fn write(
        spread: &Spread,
        (view, target): (&KnownView, &MeasuredTarget),
        folder: &Path,
    ) -> Result<Self> {
        let map = spread.map(&target.fitted).context("map what is known")?;
        let e_log = spread.e_log().context("measure what is open")?;
        let next = spread.next_pictures(view).context("choose the next picture")?;
        let [darkest, brightest] =
            darkest_and_brightest(spread, view, &next).context("draw what is open")?;
        let next = NextPicture::worth_taking(&next);
        let pictures =
            [("known", map_picture(&map)), ("darkest", darkest), ("brightest", brightest)];
        for (name, Developed { width, height, rgba, .. }) in pictures {
            let png = encode_png(width, height, &rgba);
            output::write_file(&folder.join(format!("{name}.png")), &png)?;
        }
        if let Some(next) = next {
            let text = serde_json::to_string_pretty(&next.scene).context("write JSON")?;
            output::write_file(&folder.join("next.json"), text.as_bytes())?;
        }
        let json = json!({
            "e_log": e_log,
            "seen": map.seen, "deviation": map.deviation,
            "next": next.map(|next| json!({
                "scene": next.scene, "light_deg": next.light_deg,
                "e_log_before": next.e_log[0], "e_log_after": next.e_log[1],
            })),
        });
        let text = format!(
            "expected E_log over all directions: {e_log:.4}, from materials that match the pictures about as well\n{}",
            next.map_or_else(String::new, in_words)
        );
        Ok(Self { json, text })
    }
}

fn in_words(next: &NextPicture) -> String {
    let where_to = match next.light_deg {
        Some([right, up]) => {
            let side = if right < 0.0 { "left" } else { "right" };
            let height = if up < 0.0 { "below" } else { "above" };
            format!(
                "with the lamp {:.0} degrees to the {side} of the camera and {:.0} degrees {height} it",
                right.abs(),
                up.abs()
            )
        }
        None => format!("with `light_deg` {}", next.scene.light_deg),
    };
    format!("expected after a next picture {where_to} (next.json): {:.4}\n", next.e_log[1])
}
