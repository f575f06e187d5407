//! `If-Match` preconditions: a versioned resource changes only for clients that saw its current
//! version.

use axum::extract::FromRequestParts;
use http::{HeaderValue, header, request::Parts};

use crate::problem::ApiError;

/// Version that the client saw; `None` for `*`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct IfMatch(Option<u64>);

impl IfMatch {
    /// Returns the version that the client saw, or else the `current` one.
    ///
    /// # Errors
    /// The error of `current`.
    pub async fn or(
        self,
        current: impl Future<Output = Result<u64, ApiError>>,
    ) -> Result<u64, ApiError> {
        match self.0 {
            Some(version) => Ok(version),
            None => current.await,
        }
    }
}

impl<S: Send + Sync> FromRequestParts<S> for IfMatch {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, ApiError> {
        let missing =
            || ApiError::no_if_match("send the ETag of the resource as last read in If-Match");
        let value = parts.headers.get(header::IF_MATCH).ok_or_else(missing)?;
        parse(value)
    }
}

fn parse(value: &HeaderValue) -> Result<IfMatch, ApiError> {
    let malformed = || ApiError::bad_request("If-Match must be an ETag in double quotes, or *");
    let text = value.to_str().map_err(|_| malformed())?.trim();
    if text == "*" {
        return Ok(IfMatch(None));
    }
    let bare = text.strip_prefix("W/").unwrap_or(text);
    let tag = bare.strip_prefix('"').and_then(|rest| rest.strip_suffix('"'));
    let version = tag.ok_or_else(malformed)?.parse();
    // A well-formed tag that is no version never belonged to this resource: it is stale, not
    // malformed.
    version
        .map(|version| IfMatch(Some(version)))
        .map_err(|_| ApiError::stale_version("unknown ETag for this resource"))
}

/// Returns the ETag of a version.
pub fn etag(version: u64) -> HeaderValue {
    HeaderValue::from_str(&format!("\"{version}\"")).expect("digits in quotes")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn if_match_reads_versions() {
        let parse = |text| parse(&HeaderValue::from_static(text)).map_err(|e| e.status());
        assert_eq!(parse("\"3\""), Ok(IfMatch(Some(3))));
        assert_eq!(parse("*"), Ok(IfMatch(None)));
        assert_eq!(parse("\"abc\""), Err(412));
        assert_eq!(parse("3"), Err(400));
    }
}
