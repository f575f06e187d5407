//! Conversions of library errors to problems.

use std::sync::Arc;

use brood_genome::{JsonError, TextError};
use brood_light::FieldError;
use brood_mesh::ObjError;
use brood_protocol::PaintedError;
use brood_storage::StorageError;

use super::{ApiError, quote, shortened};

impl From<StorageError> for ApiError {
    fn from(error: StorageError) -> Self {
        match error {
            StorageError::NotFound => Self::not_found("there is nothing with this id or hash"),
            StorageError::Conflict { .. } => Self::conflict(error.to_string()),
            StorageError::StaleVersion { current } => {
                Self::stale_version(format!("the current version is \"{current}\""))
            }
            StorageError::Full => Self::disk_full("nothing can be written until space is freed"),
            StorageError::Busy | StorageError::QueueFull => {
                Self::busy("too many requests are waiting").with_inner(error.to_string())
            }
            StorageError::Unreachable(_) => {
                Self::outage("the database cannot be reached", error.to_string())
            }
            StorageError::BlobsUnreachable(_) => {
                Self::outage("the object store cannot be used", error.to_string())
            }
            other => Self::internal(other.to_string()),
        }
    }
}

/// Error of a cache entry, shared by all requests that waited for it.
impl From<PaintedError> for ApiError {
    fn from(error: PaintedError) -> Self {
        Self::refused(error.to_string()).at(error.pointer())
    }
}

impl From<Arc<ApiError>> for ApiError {
    fn from(error: Arc<ApiError>) -> Self {
        Self::clone(&error)
    }
}

impl From<TextError> for ApiError {
    fn from(error: TextError) -> Self {
        Self::bad_genome(error.reason).at_line(error.line, Some(error.column))
    }
}

impl From<JsonError> for ApiError {
    fn from(error: JsonError) -> Self {
        Self::bad_genome(error.reason).at(error.pointer)
    }
}

impl From<FieldError> for ApiError {
    fn from(error: FieldError) -> Self {
        Self::refused(error.reason).at(error.pointer)
    }
}

impl From<ObjError> for ApiError {
    fn from(error: ObjError) -> Self {
        Self::bad_mesh(error.to_string()).at_line(error.line, None)
    }
}

/// Largest length of a message that may contain input at any place.
const MESSAGE_BYTES: usize = 160;

/// Returns serde's message without its position, with quoted input shortened. Names of structs are
/// replaced by "an object".
pub fn serde_words(message: &str) -> String {
    let message = match message.rfind(" at line ") {
        Some(end) => &message[..end],
        None => message,
    };
    match message.rfind(", expected ") {
        Some(split) => {
            let expected = match &message[split..] {
                name if name.starts_with(", expected struct ") => ", expected an object",
                other => other,
            };
            format!("{}{expected}", quote(&message[..split]))
        }
        None => shortened(message, MESSAGE_BYTES),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn serde_words_keep_what_is_expected_and_cut_the_input() {
        let long = "x".repeat(500);
        let message = format!("unknown field `{long}`, expected `a` or `b` at line 1 column 9");
        let words = serde_words(&message);
        assert!(words.len() < 100, "{words}");
        assert!(words.ends_with(", expected `a` or `b`"), "{words}");
        assert_eq!(serde_words("missing field `name` at line 1 column 2"), "missing field `name`");
        let message =
            "invalid type: sequence, expected struct Fields with 3 elements at line 1 column 2";
        assert_eq!(serde_words(message), "invalid type: sequence, expected an object");
        let own = "a light's strength is given once, not by both intensity_cd and flux_lm";
        assert_eq!(serde_words(&format!("{own} at line 1 column 9")), own);
        assert!(serde_words(&long).len() <= MESSAGE_BYTES);
    }
}
