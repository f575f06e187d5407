//! An HTTP answer read to its end, with checks that quote it when they fail.
//!
//! Owns how an unexpected answer is shown. Refuses to know routes.

use reqwest::header::HeaderMap;
use serde_json::Value;

/// Status, headers and the whole body.
#[derive(Debug, Clone)]
pub struct Answer {
    /// What was asked, for messages.
    pub request: String,
    /// Status code.
    pub status: u16,
    /// Headers.
    pub headers: HeaderMap,
    /// Body.
    pub body: Vec<u8>,
}

impl Answer {
    /// Reads a response to its end.
    ///
    /// # Panics
    /// Where the connection breaks.
    pub async fn read(request: String, response: reqwest::Response) -> Self {
        let (status, headers) = (response.status().as_u16(), response.headers().clone());
        let body = match response.bytes().await {
            Ok(body) => body.to_vec(),
            Err(error) => panic!("{request}: the body broke off: {error}"),
        };
        Self { request, status, headers, body }
    }

    /// Insists on a status.
    ///
    /// # Panics
    /// Where it is another, quoting the body.
    #[track_caller]
    pub fn expect(self, status: u16) -> Self {
        assert_eq!(self.status, status, "{}: {}", self.request, self.excerpt());
        self
    }

    /// Insists on a problem of that status in the form of RFC 9457, and hands it over.
    ///
    /// # Panics
    /// Where it is anything else.
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

    /// The body as JSON.
    ///
    /// # Panics
    /// Where it is none.
    #[track_caller]
    pub fn json(&self) -> Value {
        match serde_json::from_slice(&self.body) {
            Ok(value) => value,
            Err(error) => panic!("{}: no JSON ({error}): {}", self.request, self.excerpt()),
        }
    }

    /// The body as text, whatever is no UTF-8 replaced.
    #[must_use]
    pub fn text(&self) -> String {
        String::from_utf8_lossy(&self.body).into_owned()
    }

    /// The body as a picture.
    ///
    /// # Panics
    /// Where it is no PNG.
    #[track_caller]
    pub fn picture(&self) -> image::RgbaImage {
        match image::load_from_memory_with_format(&self.body, image::ImageFormat::Png) {
            Ok(picture) => picture.to_rgba8(),
            Err(error) => panic!("{}: no PNG ({error}): {}", self.request, self.excerpt()),
        }
    }

    /// A header as text, empty where it is absent.
    #[must_use]
    pub fn header(&self, name: &str) -> String {
        let value = self.headers.get(name).and_then(|value| value.to_str().ok());
        value.unwrap_or_default().to_owned()
    }

    fn excerpt(&self) -> String {
        self.text().chars().take(600).collect()
    }
}
