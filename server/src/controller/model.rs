//! Reflectance models with the names, kinds and ranges of their parameters.

use axum::Json;
use brood_genome::{ModelKind, Parameter, ParameterKind, ParameterScale};

/// A reflectance model.
#[derive(Debug, Clone, serde::Serialize, utoipa::ToSchema)]
pub struct ModelAnswer {
    /// Name in genomes.
    name: &'static str,
    /// Short description.
    about: &'static str,
    /// Author, year and title of the publication.
    source: &'static str,
    /// Parameters, in the order of a genome's text.
    parameters: Vec<ParameterAnswer>,
}

/// A parameter of a model.
#[derive(Debug, Clone, serde::Serialize, utoipa::ToSchema)]
pub struct ParameterAnswer {
    /// Name in genomes.
    name: &'static str,
    /// Short description with its symbol in the source.
    about: &'static str,
    /// Unit; empty if it has none.
    unit: &'static str,
    /// `scalar`: one value. `color`: linear red, green and blue. `choice`: one of `words`.
    kind: ParameterKindName,
    /// Least and largest value, for each component; of a choice, the index of a word.
    range: [f64; 2],
    /// Spacing of values over the range.
    scale: ParameterScaleName,
    /// Default values: one, or three of a colour; of a choice, the index of the word.
    default: Vec<f64>,
    /// Words of a choice; empty for others.
    words: Vec<&'static str>,
}

/// Kind of a parameter's values.
#[derive(Debug, Clone, Copy, serde::Serialize, utoipa::ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum ParameterKindName {
    /// One value.
    Scalar,
    /// Linear red, green and blue.
    Color,
    /// One word of a list.
    Choice,
}

/// Spacing of a parameter's values: equal steps look about equally large.
#[derive(Debug, Clone, Copy, serde::Serialize, utoipa::ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum ParameterScaleName {
    /// Equal differences.
    Linear,
    /// Equal ratios; the range excludes 0.
    Logarithmic,
}

impl From<&Parameter> for ParameterAnswer {
    fn from(of: &Parameter) -> Self {
        Self {
            name: of.name,
            about: of.about,
            unit: of.unit,
            kind: match of.kind {
                ParameterKind::Scalar { .. } => ParameterKindName::Scalar,
                ParameterKind::Color { .. } | ParameterKind::DisplayColor { .. } => {
                    ParameterKindName::Color
                }
                ParameterKind::Choice { .. } => ParameterKindName::Choice,
            },
            range: of.range.into(),
            scale: match of.scale {
                ParameterScale::Linear => ParameterScaleName::Linear,
                ParameterScale::Logarithmic => ParameterScaleName::Logarithmic,
            },
            default: of.default(),
            words: of.words().unwrap_or_default().to_vec(),
        }
    }
}

/// Lists the reflectance models with their parameters.
#[utoipa::path(get, path = "/v1/models", operation_id = "list_models", tag = "genomes",
    responses((status = 200, description = "reflectance models", body = Vec<ModelAnswer>)))]
pub async fn list() -> Json<Vec<ModelAnswer>> {
    let answer = ModelKind::ALL.map(|kind| ModelAnswer {
        name: kind.name(),
        about: kind.about(),
        source: kind.source(),
        parameters: kind.parameters().iter().map(ParameterAnswer::from).collect(),
    });
    Json(answer.into())
}
