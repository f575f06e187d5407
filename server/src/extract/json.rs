//! Strict JSON bodies: content type, size, duplicate keys, depth, and a pointer to each error.

use axum::body::Body;
use axum::extract::FromRequest;
use bytes::Bytes;
use http::Request;
use serde::de::DeserializeOwned;

use super::objects::Objects;
use super::read_upload;
use super::strict::{check, located, pointer, pointer_step};
use crate::limit;
use crate::problem::{ApiError, quote};

/// JSON body and its bytes.
#[derive(Debug)]
pub struct Json<T> {
    /// Parsed value.
    pub value: T,
    /// Bytes as received; idempotency compares these.
    pub bytes: Bytes,
}

impl<T: DeserializeOwned, S: Send + Sync> FromRequest<S> for Json<T> {
    type Rejection = ApiError;

    async fn from_request(request: Request<Body>, _: &S) -> Result<Self, ApiError> {
        let (_, bytes) = read_upload(request, &["application/json"], limit::JSON_BYTES).await?;
        let value = parse_json(&bytes)?;
        Ok(Self { value, bytes })
    }
}

/// Parses a JSON object.
///
/// # Errors
/// 400 with a pointer to the error.
pub fn parse_json<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, ApiError> {
    check(bytes)?;
    if bytes.trim_ascii_start().first() != Some(&b'{') {
        return Err(ApiError::bad_json("the body must be a JSON object").at(""));
    }
    let mut deserializer = serde_json::Deserializer::from_slice(bytes);
    serde_path_to_error::deserialize(Objects(&mut deserializer)).map_err(|error| pointed(&error))
}

/// Parses a part of a JSON body, which must be an object; pointers are relative to it.
///
/// # Errors
/// 400 with a pointer to the error.
pub fn parse_value<T: DeserializeOwned>(value: &serde_json::Value) -> Result<T, ApiError> {
    if !value.is_object() {
        return Err(ApiError::bad_json("the value must be a JSON object").at(""));
    }
    serde_path_to_error::deserialize(Objects(value)).map_err(|error| pointed(&error))
}

fn pointed(error: &serde_path_to_error::Error<serde_json::Error>) -> ApiError {
    let mut pointer = pointer(error.path());
    let message = error.inner().to_string();
    // The fields of a light are parsed when its kind is known. Their errors begin with a pointer.
    let split = message.split_once(": ").filter(|(field, _)| field.starts_with('/'));
    if let Some((field, words)) = split {
        pointer.extend(field.split('/').skip(1).map(|step| format!("/{}", quote(step))));
        return located(words, error.inner()).at(pointer);
    }
    if let Some(name) = unknown_field(&message) {
        let name = format!("/{}", pointer_step(name));
        if !pointer.ends_with(&name) {
            pointer.push_str(&name);
        }
    }
    located(&message, error.inner()).at(pointer)
}

fn unknown_field(message: &str) -> Option<&str> {
    let name = message.strip_prefix("unknown field `")?;
    let end = ["`, expected ", "`, there are "].iter().find_map(|tail| name.rfind(tail));
    Some(&name[..end?])
}

#[cfg(test)]
mod tests {
    use brood_protocol::Breed;
    use brood_scene::Scene;

    use super::*;

    fn pointer(text: &str) -> String {
        let error = parse_json::<Breed>(text.as_bytes()).unwrap_err();
        assert_eq!(error.status(), 400, "{text}");
        error.problem().pointer.clone().unwrap()
    }

    #[test]
    fn parse_points_at_the_invalid_value() {
        assert_eq!(pointer(r#"{"count": -1}"#), "/count");
        assert_eq!(pointer(r#"{"count": 4294967296}"#), "/count");
        assert_eq!(pointer(r#"{"colour": 1}"#), "/colour");
        assert_eq!(pointer(r#"{"constraints": {"shiny": true}}"#), "/constraints/shiny");
        assert_eq!(pointer(r#"{"parents": ["x"]}"#), "/parents/0");
        assert_eq!(pointer(r#"{"curation": "best"}"#), "/curation");
        assert_eq!(pointer(r#"{"constraints": [true, false]}"#), "/constraints");
        assert_eq!(pointer(r#"{"count": 1, "count": 1}"#), "/count");
        assert_eq!(pointer("[]"), "");
    }

    #[test]
    fn parse_points_at_the_field_of_a_light() {
        let refused = |light: &str| {
            let scene = format!(r#"{{"lights": [{{}}, {light}]}}"#);
            let error = parse_json::<Scene>(scene.as_bytes()).unwrap_err();
            let problem = error.problem();
            (problem.pointer.clone().unwrap(), problem.detail.clone())
        };
        let (pointer, words) = refused(r#"{"position": [0, "x", 0]}"#);
        assert_eq!(pointer, "/lights/1/position/1");
        assert!(words.contains("expected f64") && !words.contains("/position"), "{words}");
        assert_eq!(refused(r#"{"kind": "laser"}"#).0, "/lights/1/kind");
        assert_eq!(refused(r#"{"flux_w": [1], "kind": "spot"}"#).0, "/lights/1/flux_w");
        let (pointer, words) = refused(r#"{"hotspot_deg": 5}"#);
        assert_eq!(pointer, "/lights/1/hotspot_deg");
        assert!(words.contains("a light of kind point has no field"), "{words}");
        assert_eq!(refused("7").0, "/lights/1");
    }

    #[test]
    fn parse_value_points_relative_to_the_part() {
        let part = |text: &str| parse_value::<Breed>(&serde_json::from_str(text).unwrap());
        assert_eq!(part(r#"{"count": 3}"#).unwrap().count, 3);
        let refused = |text: &str| part(text).unwrap_err().problem().pointer.clone().unwrap();
        assert_eq!(refused(r#"{"parents": ["x"]}"#), "/parents/0");
        assert_eq!(refused(r#"{"colour": 1}"#), "/colour");
        assert_eq!(refused("[]"), "");
    }

    #[test]
    fn parse_accepts_valid_json() {
        let breed: Breed = parse_json(br#"{"count": 3, "seed": "18446744073709551615"}"#).unwrap();
        assert_eq!((breed.count, breed.seed.unwrap().0), (3, u64::MAX));
    }
}
