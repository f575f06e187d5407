//! Routes and their OpenAPI document.

mod document;

use axum::Router;
use utoipa::openapi::{InfoBuilder, OpenApi, OpenApiBuilder};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use utoipa_swagger_ui::SwaggerUi;

use self::document::{describe_deferring, finish};
use crate::controller::{
    angles, archive, circle, comparison, develop, event, export, generation, genome, geometry,
    individual, inspection, job, lease, light_asset, lineage, lineage_file, mesh, model, operation,
    page, palette, preset, ray_ends, render, scene, search, session, sheet, spheres, system,
    target, target_picture, thumbnail,
};
use crate::layer;
use crate::problem::ApiError;
use crate::state::App;

/// Returns all routes inside their layers.
pub fn router(app: App) -> Router {
    let (router, mut openapi) = documented().split_for_parts();
    let (long, long_openapi) = deferrable().split_for_parts();
    let router = router.merge(layer::defer_answers(long, &app));
    openapi.merge(long_openapi);
    let router = layer::check_queries(router, &openapi);
    let docs = SwaggerUi::new("/docs").url("/openapi.json", finish(openapi));
    let router = router
        .route("/", axum::routing::get(page::index))
        .route("/web/{*path}", axum::routing::get(page::asset))
        .with_state(app.clone())
        .merge(docs)
        .fallback(missing)
        .method_not_allowed_fallback(wrong_method);
    layer::wrap(router, &app)
}

/// Returns the OpenAPI document of the routes, as committed in `openapi.json`.
#[must_use]
pub fn openapi() -> OpenApi {
    let mut openapi = documented().into_openapi();
    openapi.merge(deferrable().into_openapi());
    finish(openapi)
}

async fn missing() -> ApiError {
    ApiError::no_route("see /docs for all routes")
}

async fn wrong_method() -> ApiError {
    ApiError::method("see the Allow header for the methods of this address")
}

fn documented() -> OpenApiRouter<App> {
    OpenApiRouter::with_openapi(OpenApiBuilder::new().info(info()).build())
        .routes(routes!(operation::health))
        .routes(routes!(operation::ready))
        .routes(routes!(operation::metrics))
        .routes(routes!(system::get))
        .routes(routes!(session::sign_in, session::sign_out))
        .routes(routes!(lineage::create, lineage::list))
        .routes(routes!(lineage::get, lineage::patch, lineage::delete))
        .routes(routes!(lineage_file::export))
        .routes(routes!(lineage_file::import))
        .routes(routes!(generation::list))
        .routes(routes!(generation::outlines))
        .routes(routes!(preset::list))
        .routes(routes!(event::stream_events))
        .routes(routes!(generation::get))
        .routes(routes!(palette::read))
        .routes(routes!(individual::list))
        .routes(routes!(individual::get, individual::patch))
        .routes(routes!(individual::ancestry))
        .routes(routes!(individual::descendants))
        .routes(routes!(spheres::get))
        .routes(routes!(spheres::post))
        .routes(routes!(inspection::get))
        .routes(routes!(inspection::slice))
        .routes(routes!(thumbnail::get))
        .routes(routes!(genome::create))
        .routes(routes!(genome::get))
        .routes(routes!(export::formats, archive::job::create))
        .routes(routes!(export::print, export::of_material))
        .routes(routes!(export::get))
        .routes(routes!(archive::get))
        .routes(routes!(archive::job::archive))
        .routes(routes!(model::list))
        .routes(routes!(mesh::create))
        .routes(routes!(mesh::get))
        .routes(routes!(geometry::get))
        .routes(routes!(geometry::glb))
        .routes(routes!(light_asset::create_profile))
        .routes(routes!(light_asset::create_environment))
        .routes(routes!(light_asset::environment_mean))
        .routes(routes!(light_asset::create_image))
        .routes(routes!(light_asset::image))
        .routes(routes!(scene::create))
        .routes(routes!(scene::default))
        .routes(routes!(scene::get))
        .routes(routes!(angles::get))
        .routes(routes!(ray_ends::get))
        .routes(routes!(target::create, target::list))
        .routes(routes!(target::get, target::delete))
        .routes(routes!(target_picture::picture))
        .routes(routes!(target_picture::scene))
        .routes(routes!(target_picture::pixels))
        .routes(routes!(target_picture::mask))
        .routes(routes!(develop::png))
        .routes(routes!(search::create, search::list))
        .routes(routes!(job::get))
        .routes(routes!(job::answer))
        .routes(routes!(search::pause))
        .routes(routes!(search::resume))
        .routes(routes!(search::cancel))
        .routes(routes!(search::front))
        .routes(routes!(search::darkest))
        .routes(routes!(search::brightest))
        .routes(routes!(search::log))
        .routes(routes!(event::stream_job_events))
        .routes(routes!(lease::search::claim))
        .routes(routes!(lease::search::heartbeat))
        .routes(routes!(lease::search::report))
        .routes(routes!(lease::search::release))
        .routes(routes!(lease::download::target))
        .routes(routes!(lease::export::claim))
        .routes(routes!(lease::export::heartbeat))
        .routes(routes!(lease::export::report))
        .routes(routes!(lease::export::release))
        .routes(routes!(lease::render::claim))
        .routes(routes!(lease::render::heartbeat))
        .routes(routes!(lease::render::results))
        .routes(routes!(lease::render::release))
        .routes(routes!(lease::download::mesh))
        .routes(routes!(lease::download::light_asset))
}

/// Routes that may take long: their answers can be deferred.
fn deferrable() -> OpenApiRouter<App> {
    let mut router = OpenApiRouter::new()
        .routes(routes!(generation::breed))
        .routes(routes!(generation::adopt))
        .routes(routes!(sheet::generation))
        .routes(routes!(sheet::individuals))
        .routes(routes!(render::png))
        .routes(routes!(render::exr))
        .routes(routes!(render::posted::png))
        .routes(routes!(circle::animation))
        .routes(routes!(circle::strip))
        .routes(routes!(circle::sheet))
        .routes(routes!(comparison::get))
        .routes(routes!(comparison::difference))
        .routes(routes!(target_picture::render));
    describe_deferring(router.get_openapi_mut());
    router
}

fn info() -> utoipa::openapi::Info {
    let words = "Breeds materials. A genome is a small program that computes a BRDF; a brood is a set of \
                 variations of one or two parents. Every error is an application/problem+json document.";
    InfoBuilder::new()
        .title("brood")
        .version(env!("CARGO_PKG_VERSION"))
        .description(Some(words))
        .build()
}

#[cfg(test)]
mod tests {
    use serde_json::Value;

    use super::*;

    const COMMITTED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../openapi.json");

    #[test]
    fn openapi_document_is_the_committed_one() {
        let present = openapi().to_pretty_json().unwrap() + "\n";
        if std::env::var_os("BROOD_UPDATE").is_some() {
            std::fs::write(COMMITTED, &present).unwrap();
        }
        let committed = std::fs::read_to_string(COMMITTED).unwrap_or_default();
        assert!(committed == present, "run this test with BROOD_UPDATE=1 and commit openapi.json");
    }

    fn document() -> Value {
        serde_json::to_value(openapi()).unwrap()
    }

    /// Returns all values of the document that have this field.
    fn with<'a>(value: &'a Value, field: &str) -> Vec<&'a Value> {
        let parts: Vec<&Value> = match value {
            Value::Object(fields) => fields.values().collect(),
            Value::Array(items) => items.iter().collect(),
            _ => Vec::new(),
        };
        let own = value.get(field).map(|_| value);
        own.into_iter().chain(parts.into_iter().flat_map(|part| with(part, field))).collect()
    }

    fn referred<'a>(document: &'a Value, schema: &'a Value) -> &'a Value {
        match schema["$ref"].as_str() {
            Some(name) => document.pointer(&name[1..]).unwrap_or(&Value::Null),
            None => schema,
        }
    }

    #[test]
    fn openapi_references_resolve() {
        let document = document();
        let references = with(&document, "$ref");
        assert!(references.len() > 100, "{}", references.len());
        for reference in references {
            assert!(referred(&document, reference).is_object(), "{reference}");
        }
    }

    /// Returns all operations, each with its address.
    fn operations(document: &Value) -> Vec<(&str, &Value)> {
        let paths = document["paths"].as_object().unwrap().iter();
        paths
            .flat_map(|(address, path)| {
                path.as_object().unwrap().values().map(move |it| (address.as_str(), it))
            })
            .collect()
    }

    #[test]
    fn openapi_operations_have_different_ids() {
        let document = document();
        let operations = operations(&document);
        let ids: std::collections::HashSet<&str> =
            operations.iter().filter_map(|(_, it)| it["operationId"].as_str()).collect();
        assert!(operations.len() > 80 && ids.len() == operations.len(), "{ids:?}");
    }

    #[test]
    fn openapi_responses_have_a_description_and_bodies_a_schema() {
        let document = document();
        for (address, operation) in operations(&document) {
            for (status, response) in operation["responses"].as_object().unwrap() {
                assert!(response["description"].is_string(), "{address} {status}");
                let is_error = status.starts_with(['4', '5']);
                let problem = &response["content"]["application/problem+json"];
                assert_eq!(problem.is_object(), is_error, "{address} {status}");
            }
            for content in with(operation, "content") {
                for (media_type, body) in content["content"].as_object().unwrap() {
                    let schema = referred(&document, &body["schema"]);
                    let is_json = media_type.ends_with("json");
                    assert!(schema.is_object(), "{address} {media_type}");
                    assert!(is_json || schema["type"] != "array", "{address} {media_type}");
                }
            }
        }
    }

    #[test]
    fn openapi_describes_files_as_bytes_and_sources_as_text() {
        let document = document();
        let paths = &document["paths"];
        let file = serde_json::json!({"type": "string", "format": "binary"});
        let glb = &paths["/v1/meshes/{id}/mesh.glb"]["get"]["responses"]["200"];
        assert_eq!(glb["content"]["model/gltf-binary"]["schema"], file);
        let upload = &paths["/v1/images"]["post"]["requestBody"];
        assert_eq!(upload["content"]["image/png"]["schema"], file);
        let events = &paths["/v1/jobs/{id}/events"]["get"]["responses"]["200"];
        let schema = &events["content"]["text/event-stream"]["schema"];
        assert_eq!(*schema, serde_json::json!({"type": "string"}));
    }

    #[test]
    fn openapi_objects_of_several_parts_allow_the_fields_of_each() {
        let document = document();
        for whole in with(&document, "allOf") {
            for part in whole["allOf"].as_array().unwrap() {
                let part = referred(&document, part);
                assert_ne!(part["additionalProperties"], false, "{whole}");
                assert!(part["type"] == "object" || part["allOf"].is_array(), "{whole}");
            }
        }
        let scene = &document["components"]["schemas"]["SceneAnswer"];
        assert!(scene["properties"]["id"].is_object() && scene["properties"]["mesh"].is_object());
    }

    #[test]
    fn openapi_has_a_discriminator_for_kinds_of_jobs() {
        let document = document();
        let schemas = &document["components"]["schemas"];
        let kind = |name: &str| {
            let all = with(&schemas[name], "kind");
            let [properties] = all.as_slice() else { panic!("{name} has one kind: {all:?}") };
            referred(&document, &properties["kind"])["enum"].clone()
        };
        assert_eq!(kind("SearchAnswer"), serde_json::json!(["fit"]));
        assert_eq!(kind("JobAnswer"), serde_json::json!(["render"]));
        assert_eq!(kind("ExportAnswer"), serde_json::json!(["export"]));
        assert_eq!(kind("DeferredAnswer"), serde_json::json!(["answer"]));
    }

    #[test]
    fn openapi_lists_both_forms_of_fields_with_two_forms() {
        let document = document();
        let schemas = &document["components"]["schemas"];
        for (name, field) in [
            ("TargetSpec", "samples"),
            ("TargetSpec", "scene"),
            ("ViewSpec", "samples"),
            ("ViewSpec", "scene"),
            ("TargetView", "samples"),
        ] {
            let field = &schemas[name]["properties"][field];
            let forms = field["oneOf"].as_array().into_iter().flatten().chain([field]);
            let types = forms.flat_map(|form| {
                let forms = referred(&document, form)["oneOf"].as_array().cloned();
                forms.into_iter().flatten().map(|form| referred(&document, &form)["type"].clone())
            });
            let types: Vec<Value> = types.filter(Value::is_string).collect();
            assert!(types.contains(&Value::from("string")), "{name}: {field}");
            assert!(types.len() >= 2, "{name}: {field}");
        }
        let pictures = &document["paths"]["/v1/environments"]["post"]["requestBody"]["content"];
        assert!(pictures["image/vnd.radiance"].is_object() && pictures["image/x-exr"].is_object());
    }
}
