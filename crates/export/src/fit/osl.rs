//! OSL shader for Cycles: the same sum of closures as Blender's nodes.

use std::fmt::Write;

use super::lobe::{Facets, Lean, Lobe, widths};
use super::sum::{Fit, PLACE_POWER, STOPS};

/// Returns the shader. `stem` names it, `words` describe it.
pub(super) fn shader(fit: &Fit, stem: &str, words: &str) -> String {
    let (mut arrays, mut sum) = (String::new(), String::new());
    for (k, weighted) in fit.lobes.iter().enumerate() {
        let closure = match weighted.lobe {
            Lobe::Diffuse => "diffuse(Normal)".to_owned(),
            Lobe::Velvet { sigma } => format!("ashikhmin_velvet(Normal, {sigma})"),
            Lobe::Glossy { facets, alpha, anisotropy, lean } => {
                let facets = match facets {
                    Facets::Ggx => "ggx",
                    Facets::Beckmann => "beckmann",
                };
                let normal = match lean {
                    Lean::Upright => "Normal",
                    Lean::Half => "normalize(I + Normal)",
                    Lean::Eye => "I",
                };
                let [x, y] = widths(alpha, anisotropy);
                format!("microfacet(\"{facets}\", {normal}, along, {x}, {y}, 0.0, 0)")
            }
        };
        let colours: Vec<String> = weighted
            .weights
            .iter()
            .map(|weight| {
                let [red, green, blue] = weight.to_array().map(|value| value as f32);
                format!("color({red:e}, {green:e}, {blue:e})")
            })
            .collect();
        let rows: Vec<String> = colours.chunks(2).map(|row| row.join(", ")).collect();
        let rows = rows.join(",\n    ");
        write!(arrays, "  color w{k}[{STOPS}] = {{\n    {rows}\n  }};\n").expect("a string grows");
        let weight = format!("mix(w{k}[stop], w{k}[stop + 1], part)");
        writeln!(sum, "  BSDF += {weight} * {closure};").expect("a string grows");
    }
    let words = words.replace("; ", ";\n// ");
    let last = STOPS - 1;
    format!(
        r#"// A material bred by brood, as a shader for the Script node of Blender's Cycles, with Open Shading
// Language turned on. Connect BSDF to the material's surface. If the material is anisotropic,
// connect a Tangent node by UV map to Tangent.
//
// The material is a sum of lobes with weights by the angle of view, fitted:
// {words}.

shader {name}(
  normal Normal = N,
  vector Tangent = vector(0.0),
  output closure color BSDF = 0)
{{
{arrays}
  // In Cycles, I points to the eye.
  float cosine = clamp(dot(I, N), 0.0, 1.0);
  float place = {last} * pow(acos(cosine) / M_PI_2, {PLACE_POWER});
  int stop = min(int(place), {before});
  float part = place - stop;
  vector along = dot(Tangent, Tangent) > 0.0 ? Tangent : dPdu;
{sum}}}
"#,
        name = stem.replace([' ', '-'], "_"),
        before = STOPS - 2,
    )
}
