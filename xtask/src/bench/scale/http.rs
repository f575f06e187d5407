//! Requests to a server, over HTTP/1.0: each has a connection of its own, which ends with the
//! answer. No process is started for them, so they take little time from what is measured.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::Duration;

use anyhow::{Context, Result, ensure};
use serde_json::Value;

/// Boundary between the parts of an upload.
const BOUNDARY: &str = "----between-the-parts";
/// Longest time for which an answer may pause.
const PAUSE: Duration = Duration::from_secs(60);

/// Client of one server.
pub struct Client {
    host: String,
    token: String,
}

impl Client {
    /// Client of the server at a URL, with a token.
    pub fn new(url: &str, token: String) -> Result<Self> {
        let host = url.strip_prefix("http://").with_context(|| format!("find a host in {url}"))?;
        Ok(Self { host: host.to_owned(), token })
    }

    /// Reads JSON.
    pub fn get(&self, path: &str) -> Result<Value> {
        self.send("GET", path, "application/json", "")
    }

    /// Sends JSON.
    pub fn post(&self, path: &str, body: &Value) -> Result<Value> {
        self.send("POST", path, "application/json", &body.to_string())
    }

    /// Uploads a file of text with its description.
    pub fn upload(&self, path: &str, spec: &Value, file: &str) -> Result<Value> {
        let (kind, body) = upload(&spec.to_string(), file);
        self.send("POST", path, &kind, &body)
    }

    fn send(&self, method: &str, path: &str, kind: &str, body: &str) -> Result<Value> {
        let answer = self.exchange(method, path, kind, body);
        answer.and_then(|answer| read(&answer)).with_context(|| format!("{method} {path}"))
    }

    fn exchange(&self, method: &str, path: &str, kind: &str, body: &str) -> Result<String> {
        let Self { host, token } = self;
        let mut stream = TcpStream::connect(host).context("connect to the server")?;
        stream.set_read_timeout(Some(PAUSE)).context("limit the time of an answer")?;
        let request = format!(
            "{method} {path} HTTP/1.0\r\nHost: {host}\r\nAuthorization: Bearer {token}\r\n\
             Content-Type: {kind}\r\nContent-Length: {}\r\n\r\n{body}",
            body.len()
        );
        stream.write_all(request.as_bytes()).context("send the request")?;
        let mut answer = String::new();
        stream.read_to_string(&mut answer).context("read the answer")?;
        Ok(answer)
    }
}

/// Content type and body of an upload.
fn upload(spec: &str, file: &str) -> (String, String) {
    let mut body = String::new();
    for (name, text) in [("spec", spec), ("file", file)] {
        body += &format!("--{BOUNDARY}\r\nContent-Disposition: form-data; name=\"{name}\"\r\n\r\n");
        body += text;
        body += "\r\n";
    }
    body += &format!("--{BOUNDARY}--\r\n");
    (format!("multipart/form-data; boundary={BOUNDARY}"), body)
}

/// JSON of an answer; error if its status is not 2xx.
fn read(answer: &str) -> Result<Value> {
    let (head, body) = answer.split_once("\r\n\r\n").context("find the body of the answer")?;
    let status = head.split(' ').nth(1).unwrap_or_default();
    ensure!(status.starts_with('2'), "the server answers {status}: {}", body.trim());
    serde_json::from_str(body).with_context(|| format!("parse {body} as JSON"))
}

#[cfg(test)]
mod tests {
    use super::{read, upload};

    #[test]
    fn answers_are_json_or_errors() {
        let of = |status: &str, body: &str| {
            read(&format!("HTTP/1.0 {status}\r\ncontent-length: 9\r\n\r\n{body}"))
        };
        assert_eq!(of("202 Accepted", "{\"id\": 7}").unwrap()["id"], 7);
        let refused = of("422 Unprocessable Content", "{\"detail\": 7}").unwrap_err();
        assert_eq!(refused.to_string(), "the server answers 422: {\"detail\": 7}");
        assert!(of("200 OK", "no JSON").is_err());
        assert!(read("").is_err());
    }

    #[test]
    fn uploads_have_two_parts() {
        let (kind, body) = upload("{}", "a,b\n");
        let boundary = kind.strip_prefix("multipart/form-data; boundary=").unwrap();
        let parts: Vec<&str> = body.split(&format!("--{boundary}")).collect();
        assert_eq!(parts[0], "");
        assert!(parts[1].contains("name=\"spec\"\r\n\r\n{}\r\n"), "{body}");
        assert!(parts[2].ends_with("name=\"file\"\r\n\r\na,b\n\r\n"), "{body}");
        assert_eq!(parts[3..], ["--\r\n"]);
    }
}
