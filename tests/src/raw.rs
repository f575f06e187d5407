//! Requests that no HTTP client would send.
//!
//! Owns a bare TCP connection. Refuses to interpret more than the status line.

use std::time::Duration;

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

/// Sends these bytes and gives the status code with everything that came back until the server closed.
///
/// # Panics
/// Where the server cannot be reached, or answers nothing within 40 s (longer than any of its own limits).
pub async fn raw_request(address: &str, bytes: &[u8]) -> (u16, String) {
    let mut stream = TcpStream::connect(address).await.expect("the server accepts connections");
    stream.write_all(bytes).await.expect("the server reads the request");
    let mut answer = Vec::new();
    let read = tokio::time::timeout(Duration::from_secs(40), stream.read_to_end(&mut answer)).await;
    assert!(read.is_ok(), "the server neither answered nor closed the connection");
    let text = String::from_utf8_lossy(&answer).into_owned();
    let status = text.split_whitespace().nth(1).and_then(|code| code.parse().ok()).unwrap_or(0);
    (status, text)
}
