//! OpenAPI schemas of the parts of a scene with a hand-written JSON form.

#![expect(dead_code, reason = "the types here are only described, never made")]

use std::borrow::Cow;

use utoipa::openapi::schema::{Object, Schema, SchemaType, Type};
use utoipa::openapi::{ObjectBuilder, OneOfBuilder, RefOr};
use utoipa::{PartialSchema, ToSchema};

use super::{Camera, EV_MAX, Exposure, MeshRef};

/// Position on a sphere about the centre of the mesh, looking at the centre.
#[derive(ToSchema)]
#[serde(deny_unknown_fields)]
struct OrbitCamera {
    /// Azimuth (0 is +z, 90 is +x) and elevation, degrees.
    #[schema(default = json!([30, 20]))]
    orbit_deg: Option<[f64; 2]>,
    /// Distance from the centre; null frames the mesh.
    distance: Option<f64>,
    /// Vertical field of view, degrees.
    #[schema(default = 30)]
    fov_y_deg: Option<f64>,
}

/// Position and target.
#[derive(ToSchema)]
#[serde(deny_unknown_fields)]
struct LookAtCamera {
    /// Position of the eye.
    eye: [f64; 3],
    /// Point in the middle of the picture.
    #[schema(default = json!([0, 0, 0]))]
    target: Option<[f64; 3]>,
    /// Up direction of the picture.
    #[schema(default = json!([0, 1, 0]))]
    up: Option<[f64; 3]>,
    /// Vertical field of view, degrees.
    #[schema(default = 30)]
    fov_y_deg: Option<f64>,
}

/// Parallel rays along -z with the world's origin in the middle.
#[derive(ToSchema)]
#[serde(deny_unknown_fields)]
struct OrthographicCamera {
    /// Half the height of the view.
    orthographic: f64,
}

impl PartialSchema for Camera {
    fn schema() -> RefOr<Schema> {
        let items = OneOfBuilder::new()
            .description(Some("Where the scene is seen from; the fields tell the form."))
            .item(OrbitCamera::schema())
            .item(LookAtCamera::schema())
            .item(OrthographicCamera::schema());
        RefOr::T(Schema::OneOf(items.build()))
    }
}

impl ToSchema for Camera {
    fn name() -> Cow<'static, str> {
        Cow::Borrowed("Camera")
    }
}

impl PartialSchema for MeshRef {
    fn schema() -> RefOr<Schema> {
        let text = "\"sphere\", \"torus\", \"cube\", \"knob\" or the id of an uploaded mesh";
        let object: Object = ObjectBuilder::new()
            .schema_type(SchemaType::new(Type::String))
            .min_length(Some(1))
            .max_length(Some(128))
            .description(Some(text))
            .build();
        RefOr::T(Schema::Object(object))
    }
}

impl ToSchema for MeshRef {
    fn name() -> Cow<'static, str> {
        Cow::Borrowed("MeshRef")
    }
}

impl PartialSchema for Exposure {
    fn schema() -> RefOr<Schema> {
        let auto = ObjectBuilder::new()
            .schema_type(SchemaType::new(Type::String))
            .enum_values(Some(["auto"]));
        let ev = ObjectBuilder::new()
            .schema_type(SchemaType::new(Type::Number))
            .minimum(Some(-EV_MAX))
            .maximum(Some(EV_MAX));
        let items = OneOfBuilder::new()
            .description(Some("Measured from the picture, or a fixed number of EV."))
            .item(auto)
            .item(ev);
        RefOr::T(Schema::OneOf(items.build()))
    }
}

impl ToSchema for Exposure {
    fn name() -> Cow<'static, str> {
        Cow::Borrowed("Exposure")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scene;

    #[test]
    fn schema_names_every_field_and_rejects_others() {
        let camera = serde_json::to_value(Camera::schema()).unwrap();
        let forms = camera["oneOf"].as_array().unwrap();
        assert_eq!(forms.len(), 3);
        for form in forms {
            assert_eq!(form["additionalProperties"], false, "{form}");
        }
        assert_eq!(forms[1]["required"], serde_json::json!(["eye"]));
        let scene = serde_json::to_value(Scene::schema()).unwrap();
        let written = serde_json::to_value(Scene::default()).unwrap();
        for field in written.as_object().unwrap().keys() {
            assert!(scene["properties"][field].is_object(), "{field}: {scene}");
        }
        assert!(scene["required"].is_null(), "every field has a default: {scene}");
    }
}
