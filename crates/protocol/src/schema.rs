//! OpenAPI schemas that cannot be derived: constant strings, fields of two forms, a scene with an
//! id.

#![expect(dead_code, reason = "the types are used as descriptions only and are never constructed")]

use brood_scene::Scene;
use utoipa::openapi::schema::Type;
use utoipa::openapi::{ObjectBuilder, OneOfBuilder, Ref, RefOr, Schema};
use utoipa::{PartialSchema, ToSchema};

use crate::{SceneAnswer, SceneId};

/// `kind` of a search.
#[derive(ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum FitKind {
    Fit,
}

/// `kind` of a render job.
#[derive(ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum RenderKind {
    Render,
}

/// `kind` of an export.
#[derive(ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum ExportKind {
    Export,
}

/// `kind` of a deferred answer.
#[derive(ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum AnswerKind {
    Answer,
}

/// Scene, or the id of a stored scene.
#[derive(ToSchema)]
#[serde(untagged)]
pub enum SceneOrId {
    Scene(Box<Scene>),
    Id(SceneId),
}

/// Sampling of an image's pixels.
pub struct PixelSamples;

impl PartialSchema for PixelSamples {
    fn schema() -> RefOr<Schema> {
        let adaptive = ObjectBuilder::new().schema_type(Type::String);
        let fixed = ObjectBuilder::new().schema_type(Type::Integer);
        let items = OneOfBuilder::new()
            .description(Some("Samples per pixel: `adaptive`, or the same number in every pixel, rounded up to a power of two."))
            .item(adaptive.enum_values(Some(["adaptive"])))
            .item(fixed.minimum(Some(1)).maximum(Some(64)));
        RefOr::T(Schema::OneOf(items.build()))
    }
}

impl ToSchema for PixelSamples {}

/// Code from which a channel counts as clipped.
pub struct ClipCode;

impl PartialSchema for ClipCode {
    fn schema() -> RefOr<Schema> {
        let word = ObjectBuilder::new().schema_type(Type::String);
        let code = ObjectBuilder::new().schema_type(Type::Integer);
        let items = OneOfBuilder::new()
            .description(Some(
                "Code of 8 bits from which a channel counts as clipped; `auto` finds it, `off` (or 256) uses all pixels.",
            ))
            .item(word.enum_values(Some(["auto", "off"])))
            .item(code.minimum(Some(1)).maximum(Some(256)));
        RefOr::T(Schema::OneOf(items.build()))
    }
}

impl ToSchema for ClipCode {}

// A single flat object, because `Scene` denies unknown fields and so cannot be one part of an
// `allOf`.
impl PartialSchema for SceneAnswer {
    fn schema() -> RefOr<Schema> {
        let RefOr::T(Schema::Object(mut object)) = Scene::schema() else {
            unreachable!("a derived struct's own schema is an object");
        };
        object.description = Some("A stored scene, every field present.".to_owned());
        object.properties.insert("id".to_owned(), Ref::from_schema_name(SceneId::name()).into());
        object.required.push("id".to_owned());
        RefOr::T(Schema::Object(object))
    }
}

impl ToSchema for SceneAnswer {
    fn schemas(schemas: &mut Vec<(String, RefOr<Schema>)>) {
        schemas.push((SceneId::name().into_owned(), SceneId::schema()));
        Scene::schemas(schemas);
    }
}
