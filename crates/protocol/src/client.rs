//! HTTP client of the lease protocol, for workers.

use std::collections::BTreeSet;
use std::net::{IpAddr, SocketAddr};
use std::time::Duration;

use brood_mesh::Mesh;
use reqwest::{Method, StatusCode, header};
use serde::{Serialize, de::DeserializeOwned};

use crate::http::{ServerUrl, ServerUrlError};
use crate::lease::{
    CONTENT_TYPE, LeaseRenewal, LeaseResults, LeaseTicket, WORKER_HEADER, WireError, decode,
    decode_stored, encode, worker_version,
};
use crate::{
    ClaimRequest, Directive, ExportReport, ExportTicket, LightAssetFile, SearchReport,
    SearchTicket, TargetBytes, Ticket,
};

/// Environment variable with the token of a worker or a client.
pub const TOKEN_VARIABLE: &str = "BROOD_TOKEN";

/// Client of one server, with one token.
#[derive(Debug, Clone)]
pub struct WorkerClient {
    http: reqwest::Client,
    server: ServerUrl,
    token: String,
}

/// Error of a [`WorkerClient`] call.
#[derive(Debug, thiserror::Error)]
pub enum ClientError {
    /// The server could not be reached, or the connection broke.
    #[error("no answer from the server: {}", causes(.0))]
    Transport(#[from] reqwest::Error),
    /// A proxy before the server has no answer from it.
    #[error("no answer from the server: its proxy answered {0}")]
    Gateway(StatusCode),
    /// The URL of the server is malformed, or TLS cannot be set up.
    #[error(transparent)]
    Url(#[from] ServerUrlError),
    /// The server is at another URL.
    #[error("the server redirects to {0}; use that URL")]
    Redirect(String),
    /// The lease has expired or was granted to another worker.
    #[error("the lease has expired or was granted to another worker")]
    Stale,
    /// The token is missing, unknown or of another scope.
    #[error("the server rejected the token ({0})")]
    Refused(StatusCode),
    /// The server is overloaded or shutting down.
    #[error("the server is busy or shutting down; try again later")]
    Busy,
    /// The server is of another version than the worker.
    #[error("{0}")]
    OtherVersion(String),
    /// Any other error status.
    #[error("the server answered {status}: {detail}")]
    Status {
        /// HTTP status.
        status: StatusCode,
        /// `detail` of the problem, if the response has one.
        detail: String,
    },
    /// The response could not be decoded.
    #[error(transparent)]
    Wire(WireError),
}

impl From<WireError> for ClientError {
    fn from(error: WireError) -> Self {
        match error {
            WireError::Version => Self::OtherVersion(error.to_string()),
            error @ WireError::Malformed(_) => Self::Wire(error),
        }
    }
}

impl ClientError {
    /// True if the server has not answered: it may be away, while others are not.
    #[must_use]
    pub fn is_unanswered(&self) -> bool {
        matches!(self, Self::Transport(_) | Self::Gateway(_))
    }
}

impl WorkerClient {
    /// Creates a client for the server at this URL.
    ///
    /// # Errors
    /// Returns [`ClientError::Url`] if the URL is malformed or TLS cannot be set up.
    pub fn new(server: &str, token: &str) -> Result<Self, ClientError> {
        Self::of(ServerUrl::parse(server)?, token)
    }

    /// Creates a client for the server at this URL.
    pub(crate) fn of(server: ServerUrl, token: &str) -> Result<Self, ClientError> {
        Ok(Self { http: with_limits(&server).build()?, server, token: token.to_owned() })
    }

    /// Returns the addresses of the servers behind the name in the URL, of both versions of IP,
    /// sorted. Empty if the URL has an address or `localhost`, and if the name cannot be resolved
    /// now.
    pub async fn addresses(&self) -> Vec<IpAddr> {
        let Some((name, port)) = self.name() else { return Vec::new() };
        let found = tokio::net::lookup_host((name, port)).await;
        let found: BTreeSet<_> = found.into_iter().flatten().map(|found| found.ip()).collect();
        found.into_iter().collect()
    }

    /// Returns a client of the server at one of [`addresses`](Self::addresses).
    ///
    /// # Errors
    /// Returns [`ClientError::Transport`] if the client cannot be set up.
    pub fn at(&self, address: IpAddr) -> Result<Self, ClientError> {
        let name = self.name().map_or("", |(name, _)| name);
        // The port is that of the URL.
        let http = with_limits(&self.server).resolve(name, SocketAddr::new(address, 0)).build()?;
        Ok(Self { http, ..self.clone() })
    }

    /// Returns name and port of the URL, unless it has an address.
    fn name(&self) -> Option<(&str, u16)> {
        let is_address = |name: &str| name.trim_matches(['[', ']']).parse::<IpAddr>().is_ok();
        self.server.host().filter(|(name, _)| !is_address(name) && *name != "localhost")
    }

    /// Returns the URL of the server.
    #[must_use]
    pub fn server(&self) -> &str {
        self.server.as_str()
    }

    /// Requests a job. Returns `None` if there was none within the requested time.
    ///
    /// # Errors
    /// Returns a [`ClientError`] if the call fails or the response cannot be decoded.
    pub async fn claim<R: ClaimRequest>(
        &self,
        request: &R,
    ) -> Result<Option<R::Grant>, ClientError> {
        let response = self.send(Method::POST, R::ROUTE, Some(request)).await?;
        if response.status() == StatusCode::NO_CONTENT {
            return Ok(None);
        }
        Ok(Some(read(response).await?))
    }

    /// Renews a lease.
    ///
    /// # Errors
    /// Returns [`ClientError::Stale`] if the lease is no longer valid; other variants if the call
    /// fails.
    pub async fn heartbeat<T: Ticket>(&self, ticket: &T) -> Result<(), ClientError> {
        let path = format!("{}/{}/heartbeat", T::ROUTE, ticket.key());
        self.send(Method::POST, &path, Some(ticket)).await.map(drop)
    }

    /// Renews the lease of a render job.
    ///
    /// # Errors
    /// As for [`WorkerClient::heartbeat`].
    pub async fn renew(&self, renewal: &LeaseRenewal) -> Result<(), ClientError> {
        let path = format!("{}/{}/heartbeat", LeaseTicket::ROUTE, renewal.ticket.lease);
        self.send(Method::POST, &path, Some(renewal)).await.map(drop)
    }

    /// Returns an unfinished job to its queue.
    ///
    /// # Errors
    /// Returns [`ClientError::Stale`] if the lease is no longer valid; other variants if the call
    /// fails.
    pub async fn release<T: Ticket>(&self, ticket: &T) -> Result<(), ClientError> {
        let path = format!("{}/{}", T::ROUTE, ticket.key());
        self.send(Method::DELETE, &path, Some(ticket)).await.map(drop)
    }

    /// Submits the results of a render job.
    ///
    /// # Errors
    /// Returns [`ClientError::Stale`] if the lease is no longer valid; other variants if the call
    /// fails.
    pub async fn results(&self, results: &LeaseResults) -> Result<(), ClientError> {
        let path = format!("{}/{}/results", LeaseTicket::ROUTE, results.ticket.lease);
        self.send(Method::POST, &path, Some(results)).await.map(drop)
    }

    /// Reports progress or the end of a search.
    ///
    /// # Errors
    /// Returns [`ClientError::Stale`] if the lease is no longer valid; other variants if the call
    /// fails.
    pub async fn report(&self, report: &SearchReport) -> Result<Directive, ClientError> {
        let path = format!("{}/{}/report", SearchTicket::ROUTE, report.ticket.job);
        read(self.send(Method::POST, &path, Some(report)).await?).await
    }

    /// Reports a file or the end of an export.
    ///
    /// # Errors
    /// Returns [`ClientError::Stale`] if the lease is no longer valid; other variants if the call
    /// fails.
    pub async fn report_export(&self, report: &ExportReport) -> Result<Directive, ClientError> {
        let path = format!("{}/{}/report", ExportTicket::ROUTE, report.ticket.job);
        read(self.send(Method::POST, &path, Some(report)).await?).await
    }

    /// Downloads an uploaded mesh by its content hash.
    ///
    /// # Errors
    /// Returns a [`ClientError`] if the call fails or the response cannot be decoded.
    pub async fn mesh(&self, hash: &[u8; 32]) -> Result<Mesh, ClientError> {
        let path = format!("/v1/leases/meshes/{}", blake3::Hash::from_bytes(*hash).to_hex());
        let response = self.send::<()>(Method::GET, &path, None).await?;
        Ok(decode_stored(&response.bytes().await?)?)
    }

    /// Downloads a light asset.
    ///
    /// # Errors
    /// Returns a [`ClientError`] if the call fails or the response cannot be decoded.
    pub async fn light_asset(&self, id: &str) -> Result<LightAssetFile, ClientError> {
        read(self.send::<()>(Method::GET, &format!("/v1/leases/light-assets/{id}"), None).await?)
            .await
    }

    /// Downloads a target's file by its content hash.
    ///
    /// # Errors
    /// Returns a [`ClientError`] if the call fails or the response cannot be decoded.
    pub async fn target(&self, hash: &[u8; 32]) -> Result<Vec<u8>, ClientError> {
        let path = format!("/v1/leases/targets/{}", blake3::Hash::from_bytes(*hash).to_hex());
        let file: TargetBytes = read(self.send::<()>(Method::GET, &path, None).await?).await?;
        Ok(file.bytes)
    }

    async fn send<T: Serialize>(
        &self,
        method: Method,
        path: &str,
        body: Option<&T>,
    ) -> Result<reqwest::Response, ClientError> {
        let mut request = self
            .http
            .request(method, format!("{}{path}", self.server()))
            .bearer_auth(&self.token)
            .header(WORKER_HEADER, worker_version())
            .header(header::ACCEPT, CONTENT_TYPE);
        if let Some(body) = body {
            request = request.header(header::CONTENT_TYPE, CONTENT_TYPE).body(encode(body));
        }
        let response = request.send().await?;
        match response.status() {
            status if status.is_success() => Ok(response),
            StatusCode::CONFLICT => Err(ClientError::Stale),
            status @ (StatusCode::UNAUTHORIZED | StatusCode::FORBIDDEN) => {
                Err(ClientError::Refused(status))
            }
            StatusCode::BAD_GATEWAY | StatusCode::GATEWAY_TIMEOUT => {
                Err(ClientError::Gateway(response.status()))
            }
            status @ StatusCode::SERVICE_UNAVAILABLE if !is_problem(&response) => {
                Err(ClientError::Gateway(status))
            }
            StatusCode::SERVICE_UNAVAILABLE | StatusCode::TOO_MANY_REQUESTS => {
                Err(ClientError::Busy)
            }
            status if status.is_redirection() => {
                let to = response.headers().get(header::LOCATION);
                let to = to.and_then(|to| to.to_str().ok()).unwrap_or("another URL");
                Err(ClientError::Redirect(to.to_owned()))
            }
            status => {
                let detail = response.json::<crate::Problem>().await.unwrap_or_default().detail;
                if status == StatusCode::PRECONDITION_FAILED {
                    return Err(ClientError::OtherVersion(detail));
                }
                Err(ClientError::Status { status, detail })
            }
        }
    }
}

/// True if an answer is one of the server, not of a proxy before it.
fn is_problem(response: &reqwest::Response) -> bool {
    let kind = response.headers().get(header::CONTENT_TYPE);
    kind.is_some_and(|kind| kind.as_bytes().starts_with(b"application/problem+json"))
}

/// Returns the builder of a client with the limits of a worker's requests.
fn with_limits(server: &ServerUrl) -> reqwest::ClientBuilder {
    let client = server.client();
    client.connect_timeout(Duration::from_secs(5)).timeout(Duration::from_secs(60))
}

/// Returns an error with its causes: the error alone is the URL that was requested.
fn causes(error: &dyn std::error::Error) -> String {
    let causes = std::iter::successors(Some(error), |error| error.source());
    causes.map(ToString::to_string).collect::<Vec<_>>().join(": ")
}

async fn read<T: DeserializeOwned>(response: reqwest::Response) -> Result<T, ClientError> {
    Ok(decode(&response.bytes().await?)?)
}

#[cfg(test)]
mod tests {
    use std::io::{Read as _, Write as _};
    use std::net::TcpListener;

    use super::*;
    use crate::ExportRequest;

    #[tokio::test]
    async fn client_at_an_address_connects_there_and_names_the_host() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port();
        let server = std::thread::spawn(move || {
            let (mut stream, _) = listener.accept().unwrap();
            let mut head = vec![0; 4096];
            let length = stream.read(&mut head).unwrap();
            stream.write_all(b"HTTP/1.1 204 No Content\r\n\r\n").unwrap();
            String::from_utf8_lossy(&head[..length]).to_lowercase()
        });
        let client = WorkerClient::new(&format!("http://brood.test:{port}"), "").unwrap();
        let own = client.at(IpAddr::from([127, 0, 0, 1])).unwrap();
        let request = ExportRequest { worker: "test".to_owned(), wait_ms: 0 };
        assert!(own.claim(&request).await.unwrap().is_none());
        let head = server.join().unwrap();
        assert!(head.contains(&format!("host: brood.test:{port}\r\n")), "{head}");
        assert!(head.contains(&format!("brood-worker: {}\r\n", worker_version())), "{head}");
    }

    #[tokio::test]
    async fn only_names_are_resolved() {
        let addresses = async |url: &str| WorkerClient::new(url, "").unwrap().addresses().await;
        for url in ["http://127.0.0.1:7320", "http://[::1]:7320", "http://localhost"] {
            assert!(addresses(url).await.is_empty(), "{url}");
        }
        assert!(addresses("http://nothing.invalid:7320").await.is_empty());
    }

    #[tokio::test]
    async fn error_names_the_cause() {
        let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
        let error = claim(port).await;
        assert!(error.is_unanswered(), "{error:?}");
        let error = error.to_string();
        assert!(error.starts_with("no answer from the server: "), "{error}");
        assert!(error.contains("Connection refused"), "{error}");
    }

    #[tokio::test]
    async fn answers_of_proxies_differ_from_those_of_the_server() {
        let of_server = "503 Busy\r\nContent-Type: application/problem+json";
        for (answer, words, is_unanswered) in [
            ("502 Bad Gateway", "its proxy answered 502", true),
            ("503 Service Unavailable\r\nContent-Type: text/html", "its proxy answered 503", true),
            ("504 Gateway Timeout", "its proxy answered 504", true),
            (of_server, "the server is busy", false),
            ("500 Error", "the server answered 500", false),
            ("308 Moved\r\nLocation: https://brood.test/", "to https://brood.test/; use", false),
        ] {
            let error = claim(answering(answer)).await;
            assert!(error.to_string().contains(words), "{error}");
            assert_eq!(error.is_unanswered(), is_unanswered, "{error}");
        }
    }

    /// Server that gives one answer, with this status and head.
    fn answering(answer: &'static str) -> u16 {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port();
        std::thread::spawn(move || {
            let (mut stream, _) = listener.accept().unwrap();
            let _ = stream.read(&mut [0; 4096]).unwrap();
            write!(stream, "HTTP/1.1 {answer}\r\nContent-Length: 0\r\n\r\n").unwrap();
        });
        port
    }

    /// Error of a request for a job at a port of this machine.
    async fn claim(port: u16) -> ClientError {
        let client = WorkerClient::new(&format!("http://127.0.0.1:{port}"), "").unwrap();
        let request = ExportRequest { worker: "test".to_owned(), wait_ms: 0 };
        client.claim(&request).await.unwrap_err()
    }
}
