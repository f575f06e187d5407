//! HTTP client of the benchmarks, over kept-alive connections like those of the page.

use std::time::Duration;

use anyhow::{Context, Result, bail, ensure};
use brood_protocol::{Generation, ServerUrl};
use futures::future::try_join_all;
use reqwest::header::{CONTENT_TYPE, HeaderMap};
use reqwest::{Client, RequestBuilder, StatusCode};
use serde::de::DeserializeOwned;
use serde_json::Value;

/// Connection to one server.
pub struct Api {
    http: Client,
    url: String,
    token: Option<String>,
}

impl Api {
    /// Sends no request yet.
    pub fn new(url: &str, token: Option<String>) -> Result<Self> {
        let url = ServerUrl::parse(url)?;
        let http = url.client().timeout(Duration::from_secs(60)).build().context("set up HTTP")?;
        Ok(Self { http, url: url.as_str().to_owned(), token })
    }

    /// Sends a POST of JSON; returns the parsed answer and the response headers.
    pub async fn post<T: DeserializeOwned>(
        &self,
        path: &str,
        body: &Value,
    ) -> Result<(T, HeaderMap)> {
        let request = self.http.post(format!("{}{path}", self.url)).json(body);
        let (body, headers) = self.send(request).await?;
        Ok((serde_json::from_slice(&body).with_context(|| path.to_owned())?, headers))
    }

    /// Sends a GET; returns the parsed answer.
    pub async fn get<T: DeserializeOwned>(&self, path: &str) -> Result<T> {
        let request = self.http.get(format!("{}{path}", self.url));
        serde_json::from_slice(&self.send(request).await?.0).with_context(|| path.to_owned())
    }

    /// Sends a GET and reads the answer.
    pub async fn read(&self, path: &str) -> Result<()> {
        self.send(self.http.get(format!("{}{path}", self.url))).await?;
        Ok(())
    }

    /// Sends a GET and reads the answer. Returns false if the server is busy.
    pub async fn read_unless_busy(&self, path: &str) -> Result<bool> {
        let request = self.http.get(format!("{}{path}", self.url));
        Ok(self.send_unless_busy(request).await?.is_some())
    }

    /// Sends a GET; returns the answer as text. `None` if the server is busy.
    pub async fn text_unless_busy(&self, path: &str) -> Result<Option<String>> {
        let request = self.http.get(format!("{}{path}", self.url));
        let answer = self.send_unless_busy(request).await?;
        answer.map(|body| String::from_utf8(body).with_context(|| path.to_owned())).transpose()
    }

    /// Sends a POST of JSON that the server executes once for each key; returns the parsed answer.
    /// `None` if the server is busy.
    pub async fn post_once<T: DeserializeOwned>(
        &self,
        path: &str,
        key: &str,
        body: &Value,
    ) -> Result<Option<T>> {
        let request = self.http.post(format!("{}{path}", self.url)).json(body);
        let answer = self.send_unless_busy(request.header("idempotency-key", key)).await?;
        let parse = |body: Vec<u8>| serde_json::from_slice(&body).with_context(|| path.to_owned());
        answer.map(parse).transpose()
    }

    /// Sends a multipart POST; returns the parsed answer.
    pub async fn post_parts<T: DeserializeOwned>(
        &self,
        path: &str,
        parts: [(&str, &str); 2],
    ) -> Result<T> {
        const BOUNDARY: &str = "brood-bench-7d1c";
        let part = |(name, text): (&str, &str)| {
            format!(
                "--{BOUNDARY}\r\nContent-Disposition: form-data; name=\"{name}\"\r\n\r\n{text}\r\n"
            )
        };
        let body = parts.map(part).concat() + &format!("--{BOUNDARY}--\r\n");
        let request = self.http.post(format!("{}{path}", self.url)).body(body);
        let kind = format!("multipart/form-data; boundary={BOUNDARY}");
        let (answer, _) = self.send(request.header(CONTENT_TYPE, kind)).await?;
        serde_json::from_slice(&answer).with_context(|| path.to_owned())
    }

    /// Fetches the pictures of all children and of the centre concurrently; returns their number.
    pub async fn pictures(&self, generation: &Generation) -> Result<usize> {
        let individuals = generation.individuals.iter().chain(&generation.centre);
        let fetch = individuals.map(|individual| async {
            let request = self.http.get(format!("{}{}", self.url, individual.thumbnail));
            let (bytes, _) = self.send(request).await?;
            ensure!(bytes.starts_with(b"\x89PNG"), "a thumbnail is not a PNG");
            Ok(())
        });
        Ok(try_join_all(fetch).await?.len())
    }

    async fn send(&self, request: RequestBuilder) -> Result<(Vec<u8>, HeaderMap)> {
        let (status, headers, body) = self.answer(request).await?;
        check(status, &body)?;
        Ok((body, headers))
    }

    /// `None` also if the connection was closed, as a server with many connections does.
    async fn send_unless_busy(&self, request: RequestBuilder) -> Result<Option<Vec<u8>>> {
        let (status, _, body) = match self.answer(request).await {
            Err(error) if error.is::<reqwest::Error>() => return Ok(None),
            answer => answer?,
        };
        if matches!(status, StatusCode::SERVICE_UNAVAILABLE | StatusCode::TOO_MANY_REQUESTS) {
            return Ok(None);
        }
        check(status, &body)?;
        Ok(Some(body))
    }

    async fn answer(
        &self,
        mut request: RequestBuilder,
    ) -> Result<(StatusCode, HeaderMap, Vec<u8>)> {
        if let Some(token) = &self.token {
            request = request.bearer_auth(token);
        }
        let response = request.send().await.context("reach the server")?;
        let (status, headers) = (response.status(), response.headers().clone());
        let body = response.bytes().await.context("read the response")?;
        Ok((status, headers, body.into()))
    }
}

/// Error if an answer has a status of errors.
fn check(status: StatusCode, body: &[u8]) -> Result<()> {
    if !status.is_success() {
        let text = String::from_utf8_lossy(body);
        bail!("the server returned {status}: {}", text.chars().take(300).collect::<String>());
    }
    Ok(())
}
