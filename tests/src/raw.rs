//! Requests that HTTP clients cannot send, over a bare TCP connection.

use std::time::Duration;

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

/// Sends bytes; returns the status code and everything received until the server closed the
/// connection.
///
/// # Panics
/// If the server cannot be reached, or neither answers nor closes within 40 s, which is longer than
/// its limits.
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
