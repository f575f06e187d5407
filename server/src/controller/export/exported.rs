//! Response of exports in the OpenAPI document.

use std::collections::BTreeMap;

use brood_export::Format;
use utoipa::openapi::{Content, HeaderBuilder, RefOr, Response, ResponseBuilder};
use utoipa::{IntoResponses, PartialSchema};

/// Exported material: one body for each media type of the formats.
pub struct ExportedMaterial;

impl IntoResponses for ExportedMaterial {
    fn responses() -> BTreeMap<String, RefOr<Response>> {
        let mut response = ResponseBuilder::new().description("exported material");
        for format in Format::ALL {
            let media_type = format.media_type().split(';').next().unwrap_or_default();
            let schema = media_type.ends_with("json").then(serde_json::Value::schema);
            response = response.content(media_type, Content::new(schema));
        }
        let note = HeaderBuilder::new().description(Some(
            "of tables: resolution, and error of the made table as read again by brood; ASCII",
        ));
        let response = response.header("Brood-Note", note.build());
        BTreeMap::from([("200".to_owned(), RefOr::T(response.build()))])
    }
}
