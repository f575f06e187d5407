//! Materials in the formats of both programs.

use serde_json::{Value, json};

/// One material for both programs.
pub struct Pair {
    /// Name in tables.
    pub name: &'static str,
    /// brood's model and its parameters.
    pub model: &'static str,
    /// The peer's plugin and its properties; lists are linear colours.
    pub bsdf: Value,
}

fn pair(name: &'static str, model: &'static str, bsdf: Value) -> Pair {
    Pair { name, model, bsdf }
}

/// All materials. `xtask/peer/mitsuba_models.py` implements models that the peer has no plugin for.
pub fn all() -> Vec<Pair> {
    let mut pairs = vec![lambert()];
    pairs.extend(metals());
    pairs.extend([gold(), rough_plastic(), principled()]);
    pairs.extend(phong());
    pairs.extend(ward());
    pairs
}

pub fn lambert() -> Pair {
    let bsdf = json!({"type": "diffuse", "reflectance": [0.5, 0.3, 0.2]});
    pair("Lambert", "lambert\nalbedo 0.5 0.3 0.2", bsdf)
}

/// Approximate aluminium, with either microfacet distribution.
fn metals() -> [Pair; 2] {
    let bsdf = |distribution: &str| {
        json!({
            "type": "roughconductor", "distribution": distribution, "alpha": 0.3,
            "eta": [1.66, 0.88, 0.52], "k": [9.22, 6.27, 4.84],
        })
    };
    [
        pair(
            "Beckmann conductor",
            "conductor\neta 1.66 0.88 0.52\nk 9.22 6.27 4.84\nroughness 0.3\ndistribution beckmann",
            bsdf("beckmann"),
        ),
        pair(
            "GGX conductor",
            "conductor\neta 1.66 0.88 0.52\nk 9.22 6.27 4.84\nroughness 0.3\ndistribution ggx",
            bsdf("ggx"),
        ),
    ]
}

/// Gold by each program's own optical constants.
pub fn gold() -> Pair {
    let bsdf =
        json!({"type": "roughconductor", "material": "Au", "distribution": "ggx", "alpha": 0.2});
    pair("gold", "conductor\nroughness 0.2", bsdf)
}

/// The peer takes the indices inside and outside, brood their quotient.
pub fn rough_plastic() -> Pair {
    let model =
        "rough-plastic\nalbedo 0.1 0.27 0.36\nior 1.489587\nroughness 0.1\ninternal mitsuba";
    let bsdf = json!({
        "type": "roughplastic", "distribution": "ggx", "alpha": 0.1, "int_ior": 1.49,
        "diffuse_reflectance": [0.1, 0.27, 0.36], "nonlinear": false,
    });
    pair("rough plastic", model, bsdf)
}

pub fn principled() -> Pair {
    let model = "principled\nbase_color 0.6 0.2 0.1\nroughness 0.35\nsheen 0.3\nclearcoat 0.6\n\
                 clearcoat_gloss 0.8\ncoat_form mitsuba";
    let bsdf = json!({
        "type": "principled", "base_color": [0.6, 0.2, 0.1], "roughness": 0.35, "metallic": 0.0,
        "specular": 0.5, "sheen": 0.3, "clearcoat": 0.6, "clearcoat_gloss": 0.8,
    });
    pair("principled", model, bsdf)
}

fn phong() -> [Pair; 3] {
    let bsdf = |plugin: &str, exponent: f64| {
        json!({
            "type": plugin, "exponent": exponent,
            "diffuse": [0.4, 0.2, 0.1], "specular": [0.3, 0.3, 0.3],
        })
    };
    [
        pair(
            "Phong, as published",
            "phong\ndiffuse 0.4 0.2 0.1\nspecular 0.3 0.3 0.3\nexponent 30",
            bsdf("phong_published", 30.0),
        ),
        pair(
            "Blinn-Phong, as published",
            "blinn-phong\ndiffuse 0.4 0.2 0.1\nspecular 0.3 0.3 0.3\nexponent 60",
            bsdf("blinn_phong_published", 60.0),
        ),
        pair(
            "Blinn-Phong, normalised",
            "normalised-blinn-phong\ndiffuse 0.4 0.2 0.1\nspecular 0.3 0.3 0.3\nexponent 60",
            bsdf("blinn_phong_normalised", 60.0),
        ),
    ]
}

fn ward() -> [Pair; 2] {
    let bsdf = |alpha: [f64; 2]| {
        json!({
            "type": "ward_published", "alpha_x": alpha[0], "alpha_y": alpha[1],
            "diffuse": [0.3, 0.2, 0.1], "specular": [0.2, 0.2, 0.2],
        })
    };
    [
        pair(
            "Ward",
            "ward\ndiffuse 0.3 0.2 0.1\nspecular 0.2 0.2 0.2\nalpha_x 0.15\nalpha_y 0.15\nform ward",
            bsdf([0.15, 0.15]),
        ),
        pair(
            "Ward, anisotropic",
            "ward\ndiffuse 0.3 0.2 0.1\nspecular 0.2 0.2 0.2\nalpha_x 0.1\nalpha_y 0.3\nform ward",
            bsdf([0.1, 0.3]),
        ),
    ]
}
