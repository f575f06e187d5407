//! HTTP answer, read completely, with assertions that quote it when they fail. Independent of
//! routes.

use reqwest::header::HeaderMap;
use serde_json::Value;

/// Status, headers and body of an answer.
#[derive(Debug, Clone)]
pub struct Answer {
    /// Request, for messages.
    pub request: String,
    /// Status code.
    pub status: u16,
    /// Headers.
    pub headers: HeaderMap,
    /// Body.
    pub body: Vec<u8>,
}

impl Answer {
    /// Reads a whole response.
    ///
    /// # Panics
    /// If the connection breaks.
    pub async fn read(request: String, response: reqwest::Response) -> Self {
        let (status, headers) = (response.status().as_u16(), response.headers().clone());
        let body = match response.bytes().await {
            Ok(body) => body.to_vec(),
            Err(error) => panic!("{request}: the body is incomplete: {error}"),
        };
        Self { request, status, headers, body }
    }

    /// Asserts a status.
    ///
    /// # Panics
    /// If the status differs; quotes the body.
    #[track_caller]
    pub fn expect(self, status: u16) -> Self {
        assert_eq!(self.status, status, "{}: {}", self.request, self.excerpt());
        self
    }

    /// Asserts a problem of this status in the form of RFC 9457, and returns it.
    ///
    /// # Panics
    /// If the answer is anything else.
    #[track_caller]
    pub fn problem(&self, status: u16) -> Value {
        assert_eq!(self.status, status, "{}: {}", self.request, self.excerpt());
        let kind = self.header("content-type");
        assert_eq!(kind, "application/problem+json", "{}: {}", self.request, self.excerpt());
        let problem = self.json();
        for field in ["type", "title", "detail"] {
            let text = problem[field].as_str().unwrap_or_default();
            assert!(!text.is_empty(), "{}: no {field} in {problem}", self.request);
        }
        assert_eq!(problem["status"], status, "{}: {problem}", self.request);
        problem
    }

    /// Returns the body as JSON.
    ///
    /// # Panics
    /// If it is not JSON.
    #[track_caller]
    pub fn json(&self) -> Value {
        match serde_json::from_slice(&self.body) {
            Ok(value) => value,
            Err(error) => panic!("{}: no JSON ({error}): {}", self.request, self.excerpt()),
        }
    }

    /// Returns the body as text, with invalid UTF-8 replaced.
    #[must_use]
    pub fn text(&self) -> String {
        String::from_utf8_lossy(&self.body).into_owned()
    }

    /// Returns the body as a picture.
    ///
    /// # Panics
    /// If it is not a PNG.
    #[track_caller]
    pub fn picture(&self) -> image::RgbaImage {
        match image::load_from_memory_with_format(&self.body, image::ImageFormat::Png) {
            Ok(picture) => picture.to_rgba8(),
            Err(error) => panic!("{}: no PNG ({error}): {}", self.request, self.excerpt()),
        }
    }

    /// Returns a header as text, empty if absent.
    #[must_use]
    pub fn header(&self, name: &str) -> String {
        let value = self.headers.get(name).and_then(|value| value.to_str().ok());
        value.unwrap_or_default().to_owned()
    }

    fn excerpt(&self) -> String {
        self.text().chars().take(600).collect()
    }
}
