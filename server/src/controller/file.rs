//! File answers with an ETag: answers 304 if the client already has the file.

use axum::response::{IntoResponse, Response};
use brood_protocol::PictureKey;
use bytes::Bytes;
use http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header};

use crate::problem::ApiError;

/// `Cache-Control` of files that never change.
pub const IMMUTABLE: &str = "private, max-age=31536000, immutable";
/// `Cache-Control` of files that may change, for example with the scene of a lineage.
pub const REVALIDATED: &str = "private, no-cache";

/// Headers of a file answer.
#[derive(Debug)]
pub struct FileHead<'a> {
    /// ETag, with its quotes.
    pub etag: String,
    /// Value of `Content-Type`.
    pub content_type: &'a str,
    /// Value of `Cache-Control`.
    pub cache: &'static str,
}

impl<'a> FileHead<'a> {
    /// Returns the headers of a picture. Its key is its ETag.
    pub fn of_picture(key: PictureKey, content_type: &'a str, cache: &'static str) -> Self {
        Self { etag: format!("\"{key}\""), content_type, cache }
    }

    /// Returns the file, or 304 if the client already has it.
    pub fn answer(&self, headers: &HeaderMap, bytes: impl Into<Bytes>) -> Response {
        match has_already(headers, &self.etag) {
            true => self.unchanged(),
            false => self.full(bytes.into()),
        }
    }

    /// Returns the file, or 304 without making it if the client already has it.
    ///
    /// # Errors
    /// Returns the error of `make`.
    pub async fn made<B: Into<Bytes>>(
        &self,
        headers: &HeaderMap,
        make: impl Future<Output = Result<B, ApiError>>,
    ) -> Result<Response, ApiError> {
        if has_already(headers, &self.etag) {
            return Ok(self.unchanged());
        }
        Ok(self.full(make.await?.into()))
    }

    fn unchanged(&self) -> Response {
        self.on(StatusCode::NOT_MODIFIED.into_response())
    }

    fn full(&self, bytes: Bytes) -> Response {
        self.on(axum::body::Body::from(bytes).into_response())
    }

    fn on(&self, mut response: Response) -> Response {
        let fixed = |name: HeaderName, text: &str| (name, HeaderValue::from_str(text).ok());
        let common = [
            fixed(header::ETAG, &self.etag),
            fixed(header::CACHE_CONTROL, self.cache),
            fixed(header::CONTENT_TYPE, self.content_type),
        ];
        for (name, value) in common {
            if let Some(value) = value {
                response.headers_mut().insert(name, value);
            }
        }
        response
    }
}

/// Returns true if `If-None-Match` has this ETag.
pub fn has_already(headers: &HeaderMap, etag: &str) -> bool {
    let values = headers.get_all(header::IF_NONE_MATCH).iter();
    let mut tags = values.filter_map(|value| value.to_str().ok()).flat_map(|text| text.split(','));
    tags.any(|tag| {
        let tag = tag.trim();
        tag == "*" || tag.strip_prefix("W/").unwrap_or(tag) == etag
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn file_is_neither_sent_nor_made_again_when_the_client_has_it() {
        let etag = "\"a\"".to_owned();
        let head = FileHead { etag, content_type: "image/png", cache: "no-cache" };
        for (asked, status) in [(None, 200), (Some("\"b\", W/\"a\""), 304), (Some("\"b\""), 200)] {
            let mut headers = HeaderMap::new();
            if let Some(asked) = asked {
                headers.insert(header::IF_NONE_MATCH, asked.parse().unwrap());
            }
            assert_eq!(head.answer(&headers, "x").status(), status);
            let mut is_made = false;
            let make = async {
                is_made = true;
                Ok("x")
            };
            let made = head.made(&headers, make).await.unwrap();
            assert_eq!((made.status().as_u16(), is_made), (status, status == 200));
            assert_eq!(made.headers()[header::ETAG], "\"a\"");
        }
    }
}
