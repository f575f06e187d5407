//! Named materials as parameters of models: reflectance of known substances at normal incidence.

use super::kind::ModelKind;
use super::value::Model;

/// A model with parameter values for a named material.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelPreset {
    /// Name in texts.
    pub name: &'static str,
    /// The substance.
    pub about: &'static str,
    /// The model.
    pub model: Model,
}

/// Name, description, linear reflectance at normal incidence and diffuse albedo. Metals and gems
/// have no diffuse part; water, plastic and glass are coats whose diffuse part is the material
/// below.
///
/// # Source
/// The lecture "Appearance: Local Shading", tables of normal-incidence Fresnel for metals and for
/// insulators.
const F0: [(&str, &str, [f64; 3], f64); 11] = [
    ("gold", "gold", [1.00, 0.71, 0.29], 0.0),
    ("silver", "silver", [0.95, 0.93, 0.88], 0.0),
    ("copper", "copper", [0.95, 0.64, 0.54], 0.0),
    ("iron", "iron", [0.56, 0.57, 0.58], 0.0),
    ("aluminium", "aluminium", [0.91, 0.92, 0.92], 0.0),
    ("water", "water", [0.02; 3], 0.0),
    ("plastic-low", "plastic or glass, low", [0.03; 3], 0.4),
    ("plastic-high", "plastic, high", [0.05; 3], 0.4),
    ("glass-high", "glass, high", [0.08; 3], 0.0),
    ("ruby", "ruby", [0.08; 3], 0.0),
    ("diamond", "diamond", [0.17; 3], 0.0),
];

/// Returns all presets.
#[must_use]
pub fn model_presets() -> Vec<ModelPreset> {
    let preset = |(name, about, f0, diffuse): (_, _, [f64; 3], f64)| {
        let model = Model::new(ModelKind::CookTorrance)
            .with("f0", &f0)
            .and_then(|model| model.with("diffuse", &[diffuse; 3]))
            .expect("the table is within the ranges");
        ModelPreset { name, about, model }
    };
    F0.into_iter().map(preset).collect()
}
