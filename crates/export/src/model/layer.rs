//! A layer as a function `layer_N(p)` of a pair of directions.

use std::f64::consts::FRAC_1_PI;

use brood_brdf::{
    ClearCoatConstants, ModelConstants, PhongHighlight, PrincipledConstants, SgdChannel, WardForm,
};
use brood_genome::Model;
use glam::DVec3;

use super::facet::facets;
use super::term::{color, number, pair};
use crate::source::let_line;

/// Replacement for ln(0): finite, with an exponential of 0.
const LN_ZERO: f64 = -1e30;

/// Returns the function, preceded by its table if it has one.
pub(super) fn function(layer: usize, model: &Model, constants: &ModelConstants) -> String {
    let above = match constants {
        ModelConstants::RoughPlastic { transmittance, .. } => table(layer, transmittance),
        _ => String::new(),
    };
    let (caption, lines) = (caption(layer, model), lines(layer, constants));
    format!("{above}// {caption}\nfn layer_{layer}(p: BroodPair) -> vec3f {{\n{lines}}}\n\n")
}

/// Comment line with the model and its parameters.
fn caption(layer: usize, model: &Model) -> String {
    let text = model.to_string();
    let parameters: Vec<&str> = text.lines().skip(1).collect();
    format!("Layer {layer}, {}: {}.", model.kind(), parameters.join(", "))
}

/// Lines of the body. Calls functions of the library; see the `.wgsl` files beside this one.
fn lines(layer: usize, constants: &ModelConstants) -> String {
    match constants {
        ModelConstants::Lambert { f } => sum(&[color(*f)]),
        ModelConstants::OrenNayar { albedo, a, b } => {
            let (a, b) = (number(a * FRAC_1_PI), number(b * FRAC_1_PI));
            sum(&[format!("{} * brood_oren_nayar(p, {a}, {b})", color(*albedo))])
        }
        ModelConstants::Phong { highlight, diffuse, specular, exponent } => {
            let n = number(*exponent);
            let lobe = match highlight {
                PhongHighlight::Mirror => format!("brood_phong(p, {n})"),
                PhongHighlight::Half | PhongHighlight::NormalisedHalf => {
                    format!("(brood_blinn(p, {n}) / p.wi.z)")
                }
                PhongHighlight::Brdf => format!("brood_blinn(p, {n})"),
            };
            with_diffuse(*diffuse, &format!("{} * {lobe}", color(*specular)))
        }
        ModelConstants::CookTorrance { diffuse, f0, facets: of } => {
            let reflected = format!("brood_schlick({}, p.off_c) * facets", color(*f0));
            let_line("f32", "facets", &facets(of)) + &with_diffuse(*diffuse, &reflected)
        }
        ModelConstants::Conductor { metals, facets: of } => {
            let metal = metals.map(|metal| {
                let d = metal.difference;
                let literals = [d, d - 1.0, metal.product].map(number);
                format!("brood_metal(p, {})", literals.join(", "))
            });
            let_line("f32", "facets", &facets(of))
                + &sum(&[format!("vec3f({}) * facets", metal.join(",\n    "))])
        }
        ModelConstants::Coated { base, ior, facets: of } => {
            let e = number(ior * ior - 1.0);
            let transmittance = |w: &str| format!("brood_transmitted({e}, p.{w}.z)");
            plastic(*base, *ior, &facets(of), [&transmittance("wi"), &transmittance("wo")])
        }
        ModelConstants::RoughPlastic { base, ior, facets: of, .. } => {
            let transmittance = |w: &str| format!("passes_{layer}(p.{w}.z)");
            plastic(*base, *ior, &facets(of), [&transmittance("wi"), &transmittance("wo")])
        }
        ModelConstants::Principled(constants) => principled(constants),
        ModelConstants::Ward { form, diffuse, specular, inverse } => {
            let function = match form {
                WardForm::Bounded => "brood_ward_bounded",
                WardForm::Ward => "brood_ward",
                WardForm::Duer => "brood_ward_duer",
            };
            let lobe = format!("{function}(p, {})", pair(*inverse));
            with_diffuse(*diffuse, &format!("{} * {lobe}", color(*specular)))
        }
        ModelConstants::AshikhminShirley { base, specular, exponents, height } => {
            let exponents = pair(*exponents);
            let lobe = format!("({} * brood_ashikhmin_shirley(p, {exponents}))", number(*height));
            let reflected = format!("brood_schlick({}, p.off_c) * {lobe}", color(*specular));
            let fades = "brood_product(brood_fades(p.wi.z), brood_fades(p.wo.z))";
            sum(&[format!("{} * {fades}", color(*base)), reflected])
        }
        ModelConstants::Abc { diffuse, a, b, c, ior } => {
            let (b, c, e) = (number(*b), number(*c), number(ior * ior - 1.0));
            with_diffuse(*diffuse, &format!("{} * brood_abc(p, {b}, {c}, {e})", color(*a)))
        }
        ModelConstants::Sgd { channels } => {
            let channels = channels.map(|channel| sgd(&channel));
            sum(&[format!("vec3f({})", channels.join(",\n    "))])
        }
    }
}

/// Sum of a colour and a reflected part; leaves out a black colour, which many models have.
fn with_diffuse(diffuse: DVec3, reflected: &str) -> String {
    match diffuse == DVec3::ZERO {
        true => sum(&[reflected.to_owned()]),
        false => sum(&[color(diffuse), reflected.to_owned()]),
    }
}

/// Diffuse base below a coat, with the transmittance of the coat for each of the directions.
fn plastic(base: DVec3, ior: f64, facets: &str, transmittance: [&str; 2]) -> String {
    let coat = format!("brood_dielectric({}, p.c) * ({facets})", number(ior * ior - 1.0));
    let [i, o] = transmittance;
    let below = format!("{} * brood_product({i}, {o})", color(base));
    let_line("f32", "coat", &coat) + &sum(&[below, "vec3f(coat)".to_owned()])
}

fn principled(of: &PrincipledConstants) -> String {
    let dielectric = 1.0 - of.metallic;
    let mut text = let_line("f32", "facets", &facets(&of.facets));
    let mut parts = Vec::new();
    if dielectric > 0.0 {
        let base = color(of.base * (FRAC_1_PI * dielectric));
        parts.push(format!("{base} * brood_body(p, {})", number(of.roughness)));
    }
    let sheen = of.sheen * dielectric;
    if sheen != DVec3::ZERO {
        parts.push(format!("{} * brood_fifth(p.off_c)", color(sheen)));
    }
    let mut reflected = Vec::new();
    let mut reflects = |share: f64, what: String| {
        if share > 0.0 {
            reflected.push(format!("{what} * {}", number(share)));
        }
    };
    let untinted = format!("vec3f(brood_dielectric({}, p.c))", number(of.ior * of.ior - 1.0));
    reflects(of.metallic, format!("brood_schlick({}, p.off_c)", color(of.base)));
    reflects(dielectric * of.spec_tint, format!("brood_schlick({}, p.off_c)", color(of.tinted_f0)));
    reflects(dielectric * (1.0 - of.spec_tint), untinted);
    text += &let_line("vec3f", "reflected", &reflected.join(" + "));
    parts.push("reflected * facets".to_owned());
    if let Some(coat) = &of.coat {
        parts.push(format!("vec3f({})", clear_coat(coat)));
    }
    text + &sum(&parts)
}

fn clear_coat(coat: &ClearCoatConstants) -> String {
    let (height, over) = match coat.published {
        true => (0.25 * coat.height, ""),
        false => (coat.height, "brood_product(p.wi.z, p.wo.z) * "),
    };
    let literals = [height, coat.narrow + 1.0, coat.f0, coat.shadowing * coat.shadowing];
    let literals = literals.map(number);
    format!("{over}brood_clear_coat(p, {})", literals.join(", "))
}

fn sgd(of: &SgdChannel) -> String {
    let ln = |value: f64| if value > 0.0 { libm::log(value) } else { LN_ZERO };
    // K = 0, a black highlight, has no logarithm: the weight becomes 0 instead.
    let weight = if of.normal > 0.0 { of.rho_s * FRAC_1_PI * FRAC_1_PI } else { 0.0 };
    let (ln_k, ln_c) = (ln(of.normal).max(-1e3), ln(of.c));
    let literals = [
        of.rho_d * FRAC_1_PI,
        weight,
        of.alpha,
        of.p,
        of.f0,
        of.f1,
        ln_k,
        of.lambda,
        ln_c,
        of.k,
        of.theta0,
    ];
    let literals = literals.map(number);
    format!("brood_sgd(p, BroodSgd({}))", literals.join(", "))
}

/// Transmittance table of a rough plastic and the function that reads it.
fn table(layer: usize, transmittance: &[f64]) -> String {
    let (_, text) =
        include_str!("plastic.wgsl").split_once("// @table\n").expect("the file has the mark");
    let literals: Vec<String> = transmittance.iter().map(|value| number(*value)).collect();
    let rows: Vec<String> = literals.chunks(8).map(|row| format!("  {}", row.join(", "))).collect();
    text.replace("LAYER", &layer.to_string()).replace("TABLE", &rows.join(",\n"))
}

/// Return statement with the sum of the parts, one per line.
fn sum(parts: &[String]) -> String {
    format!("  return {};\n", parts.join("\n    + "))
}
