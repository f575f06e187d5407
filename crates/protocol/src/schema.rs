//! OpenAPI schemas of what cannot be derived from a type: words that are texts, fields of two forms, a scene with an id.

#![expect(dead_code, reason = "the types here are only described, never made")]

use brood_scene::Scene;
use utoipa::openapi::schema::Type;
use utoipa::openapi::{ObjectBuilder, OneOfBuilder, Ref, RefOr, Schema};
use utoipa::{PartialSchema, ToSchema};

use crate::{SceneAnswer, SceneId};

/// The word of searches.
#[derive(ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum FitKind {
    Fit,
}

/// The word of jobs that render.
#[derive(ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum RenderKind {
    Render,
}

/// A scene, or the id of a stored one.
#[derive(ToSchema)]
#[serde(untagged)]
pub enum SceneOrId {
    Scene(Box<Scene>),
    Id(SceneId),
}

/// How pixels of targets were sampled.
pub struct PixelSamples;

impl PartialSchema for PixelSamples {
    fn schema() -> RefOr<Schema> {
        let adaptive = ObjectBuilder::new().schema_type(Type::String);
        let fixed = ObjectBuilder::new().schema_type(Type::Integer);
        let items = OneOfBuilder::new()
            .description(Some("Samples in every pixel: as many as it takes, or a number."))
            .item(adaptive.enum_values(Some(["adaptive"])))
            .item(fixed.minimum(Some(1)).maximum(Some(64)));
        RefOr::T(Schema::OneOf(items.build()))
    }
}

impl ToSchema for PixelSamples {}

/// One object: a scene refuses other fields, so that nothing is a scene with an id beside it.
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
