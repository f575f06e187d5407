//! Materials that are photographed, as Mitsuba's plugins.

use std::path::Path;

use serde_json::{Value, json};

/// A material.
#[derive(Debug, Clone)]
pub struct Material {
    /// Name in tables.
    pub name: &'static str,
    /// The plugin and its properties; lists are linear colours.
    pub bsdf: Value,
}

/// Eight materials by formulas and, if there is a folder of data, four measured ones.
pub fn all(data: Option<&Path>) -> Vec<Material> {
    let formulas = [
        ("gold", conductor([0.143, 0.375, 1.442], [3.983, 2.386, 1.603], 0.2, "ggx")),
        ("chrome", conductor([3.2, 3.18, 2.33], [3.3, 3.33, 3.15], 0.08, "beckmann")),
        ("iron", conductor([1.1, 1.1, 1.1], [6.0, 6.0, 6.0], 0.35, "ggx")),
        ("blue plastic", plastic([0.1, 0.27, 0.36], 0.1, false)),
        ("white plastic", plastic([0.7, 0.68, 0.6], 0.25, true)),
        ("paint", principled([0.55, 0.08, 0.05], 0.5, 0.0, 0.0, 0.8)),
        ("satin", principled([0.35, 0.2, 0.5], 0.6, 0.0, 0.8, 0.0)),
        ("metallic paint", principled([0.1, 0.2, 0.45], 0.35, 0.7, 0.0, 1.0)),
    ];
    let mut all: Vec<Material> =
        formulas.into_iter().map(|(name, bsdf)| Material { name, bsdf }).collect();
    let measured = [
        ("white paper", "paper_white_rgb"),
        ("sunset film", "cc_ibiza_sunset_rgb"),
        ("sunflower film", "cg_sunflower_rgb"),
        ("napoli", "colodur_napoli_4f_rgb"),
    ];
    if let Some(data) = data {
        all.extend(measured.map(|(name, file)| {
            let file = data.join("rgl").join(format!("{file}.bsdf"));
            Material { name, bsdf: json!({"type": "measured", "filename": file}) }
        }));
    }
    all
}

fn conductor(eta: [f64; 3], k: [f64; 3], alpha: f64, distribution: &str) -> Value {
    json!({
        "type": "roughconductor", "distribution": distribution, "alpha": alpha, "eta": eta, "k": k,
    })
}

fn plastic(diffuse: [f64; 3], alpha: f64, nonlinear: bool) -> Value {
    json!({
        "type": "roughplastic", "distribution": "ggx", "alpha": alpha, "int_ior": 1.49,
        "diffuse_reflectance": diffuse, "nonlinear": nonlinear,
    })
}

fn principled(colour: [f64; 3], roughness: f64, metallic: f64, sheen: f64, coat: f64) -> Value {
    json!({
        "type": "principled", "base_color": colour, "roughness": roughness, "metallic": metallic,
        "specular": 0.5, "sheen": sheen, "clearcoat": coat, "clearcoat_gloss": 0.8,
    })
}
