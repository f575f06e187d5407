//! Script for Blender that makes a material of plain nodes, as an asset of Blender's library.

use super::lobe::{Facets, Lean, Lobe};
use super::sum::{Fit, PLACE_POWER, Weighted};

/// Returns the script. `stem` names the material, `words` describe it.
pub(super) fn script(fit: &Fit, stem: &str, words: &str) -> String {
    let lobes: Vec<String> = fit.lobes.iter().map(lobe).collect();
    let values = [
        ("@NAME@", stem),
        ("@DESCRIPTION@", words),
        ("@POWER@", &PLACE_POWER.to_string()),
        ("@LOBES@", &lobes.join("\n")),
    ];
    let text = values.iter().fold(include_str!("blender.py").to_owned(), |text, (mark, value)| {
        text.replace(mark, value)
    });
    head(words) + &text
}

/// Docstring of the script.
fn head(words: &str) -> String {
    format!(
        r#""""A material bred by brood, as a script for Blender 4.2 or later, with Cycles.

    blender --background --python THIS_FILE.py -- material.blend
    blender --background --python THIS_FILE.py -- picture.png

make a file with the material as an asset, and a picture. Without Blender:

    pip install bpy
    python THIS_FILE.py material.blend

In Blender's text editor, the script makes the material in the open file. A .blend in a folder of
asset libraries (Preferences, File Paths) shows the material in the asset browser.

The material is a sum of lobes with weights by the angle of view, fitted:
{}.
"""

"#,
        words.replace("; ", ";\n")
    )
}

/// A line of the table of lobes.
fn lobe(weighted: &Weighted) -> String {
    let (kind, width, anisotropy, lean) = match weighted.lobe {
        Lobe::Diffuse => ("DIFFUSE", 0.0, 0.0, Lean::Upright),
        Lobe::Velvet { sigma } => ("VELVET", sigma, 0.0, Lean::Upright),
        Lobe::Glossy { facets: Facets::Ggx, alpha, anisotropy, lean } => {
            ("GGX", alpha, anisotropy, lean)
        }
        Lobe::Glossy { facets: Facets::Beckmann, alpha, anisotropy, lean } => {
            ("BECKMANN", alpha, anisotropy, lean)
        }
    };
    let lean = match lean {
        Lean::Upright => "UPRIGHT",
        Lean::Half => "HALF",
        Lean::Eye => "EYE",
    };
    let weights: Vec<String> = weighted
        .weights
        .iter()
        .map(|weight| {
            let [red, green, blue] = weight.to_array().map(|value| value as f32);
            format!("({red:e}, {green:e}, {blue:e})")
        })
        .collect();
    let rows: Vec<String> =
        weights.chunks(3).map(|row| format!("        {},\n", row.join(", "))).collect();
    format!("    (\"{kind}\", {width}, {anisotropy}, \"{lean}\", (\n{}    )),", rows.concat())
}
