//! Request handlers, one file per resource: they parse the request, call the services and build the
//! answer.

pub mod angles;
pub mod archive;
pub mod circle;
pub mod comparison;
pub mod develop;
pub mod event;
pub mod export;
mod file;
mod file_name;
pub mod generation;
pub mod genome;
pub mod geometry;
pub mod individual;
pub mod inspection;
pub mod job;
pub mod lease;
pub mod light_asset;
pub mod lineage;
pub mod lineage_file;
pub mod mesh;
pub mod model;
pub mod operation;
pub mod page;
pub mod palette;
mod picture_query;
pub mod preset;
pub mod ray_ends;
pub mod render;
pub mod scene;
pub mod search;
pub mod session;
pub mod sheet;
pub mod spheres;
pub mod system;
pub mod target;
pub mod target_picture;
pub mod thumbnail;

use axum::Json;
use axum::response::{IntoResponse, Response};
use bytes::Bytes;
use http::{HeaderValue, StatusCode, header};
use serde::{Deserialize, Serialize};

use crate::extract::etag;
use crate::idempotency::{Attempt, BodyHash, IdempotencyKey};
use crate::problem::ApiError;
use crate::state::App;

/// Fields of an answer that its headers repeat.
#[derive(Deserialize)]
struct Head {
    id: Option<String>,
    hash: Option<String>,
    version: Option<u64>,
}

/// Answers a request that creates something below `collection`: as before if its key and `body`
/// were received before, else by `create`, which must store the record of the attempt.
async fn create_once<T: Serialize, Create: Future<Output = Result<T, ApiError>>>(
    app: &App,
    key: IdempotencyKey,
    collection: &str,
    body: Bytes,
    create: impl FnOnce(Attempt) -> Create,
) -> Result<Response, ApiError> {
    let hash = BodyHash::of(&body);
    // Frees the memory of a large body as soon as `create` has read it.
    drop(body);
    let make = async |attempt| Ok(created(collection, &create(attempt).await?));
    let replay = async |answer| Ok(created(collection, &answer));
    app.ledger.once(&app.store, (key, hash), make, replay).await
}

/// Returns 201 with a `Location` below `collection`, and an ETag if the answer has a version.
fn created<T: Serialize>(collection: &str, answer: &T) -> Response {
    // Serialised directly: through a JSON value, f32 numbers would gain digits.
    let body = serde_json::to_vec(answer).expect("answers are plain data");
    let Head { id, hash, version } = serde_json::from_slice(&body).expect("answers are objects");
    let location = format!("{collection}/{}", id.or(hash).unwrap_or_default());
    let content_type = (header::CONTENT_TYPE, "application/json");
    let mut response = (StatusCode::CREATED, [content_type], body).into_response();
    if let Ok(location) = HeaderValue::from_str(&location) {
        response.headers_mut().insert(header::LOCATION, location);
    }
    if let Some(version) = version {
        response.headers_mut().insert(header::ETAG, etag(version));
    }
    response
}

/// Returns 202 with the location of a new job.
fn accepted<T: Serialize>(answer: &T) -> Response {
    let mut response = created("/v1/jobs", answer);
    *response.status_mut() = StatusCode::ACCEPTED;
    response
}

/// Returns 200 with the ETag of a version.
fn versioned<T: Serialize>(version: u64, answer: &T) -> Response {
    ([(header::ETAG, etag(version))], Json(answer)).into_response()
}

/// True if text can be seen, and has no control characters and none that change the order of the
/// text around it: in a list, names with such characters pass for others.
fn is_plain(text: &str) -> bool {
    let hides = |c: char| {
        matches!(c,
            '\u{ad}' | '\u{61c}' | '\u{180e}' | '\u{200b}' | '\u{200e}' | '\u{200f}'
            | '\u{202a}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}' | '\u{fff9}'..='\u{fffb}'
            | '\u{115f}' | '\u{1160}' | '\u{3164}' | '\u{ffa0}' | '\u{e0000}'..='\u{e007f}')
    };
    // These join letters and emoji, and cannot be seen alone.
    let joins = |c: char| matches!(c, '\u{200c}' | '\u{200d}' | '\u{fe00}'..='\u{fe0f}');
    !text.chars().any(|c| c.is_control() || hides(c))
        && text.chars().any(|c| !c.is_whitespace() && !joins(c))
}

/// Checks the length of a text.
fn check_length(text: &str, max_chars: usize, pointer: &str) -> Result<(), ApiError> {
    let chars = text.chars().count();
    if chars > max_chars {
        let words = format!("must have at most {max_chars} characters, got {chars}");
        return Err(ApiError::refused(words).at(pointer));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_that_cannot_be_seen_or_changes_its_order_is_not_plain() {
        let plain =
            ["Ruby", "a b", "\u{1f469}\u{200d}\u{1f52c}", "\u{5e9}\u{5dc}\u{5d5}", "m\u{a0}n"];
        for text in plain {
            assert!(is_plain(text), "{text:?}");
        }
        let others =
            ["", " ", "\u{a0}", "a\nb", "\u{200d}", "a\u{202e}gnp.exe", "a\u{200b}b", "\u{3164}"];
        for text in others {
            assert!(!is_plain(text), "{text:?}");
        }
    }

    #[test]
    fn created_has_a_location_and_an_etag() {
        let response = created("/v1/lineages", &serde_json::json!({"id": "x", "version": 1}));
        assert_eq!(response.headers()[header::LOCATION], "/v1/lineages/x");
        assert_eq!(response.headers()[header::ETAG], "\"1\"");
    }
}
