//! HTTP client of the lease protocol, for workers.

use std::time::Duration;

use brood_mesh::Mesh;
use reqwest::{Method, StatusCode, header};
use serde::{Serialize, de::DeserializeOwned};

use crate::lease::{
    CONTENT_TYPE, LeaseRenewal, LeaseResults, LeaseTicket, WireError, decode, decode_stored, encode,
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
    server: String,
    token: String,
}

/// Error of a [`WorkerClient`] call.
#[derive(Debug, thiserror::Error)]
pub enum ClientError {
    /// The server could not be reached, or the connection broke.
    #[error("no answer from the server: {0}")]
    Transport(#[from] reqwest::Error),
    /// The lease has expired or was granted to another worker.
    #[error("the lease has expired or was granted to another worker")]
    Stale,
    /// The token is missing, unknown or of another scope.
    #[error("the server rejected the token ({0})")]
    Refused(StatusCode),
    /// The server is overloaded or shutting down.
    #[error("the server is busy or shutting down; try again later")]
    Busy,
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
    Wire(#[from] WireError),
}

impl WorkerClient {
    /// Creates a client for the server at this URL.
    ///
    /// # Errors
    /// Returns [`ClientError::Transport`] if the TLS backend cannot be initialised.
    pub fn new(server: &str, token: &str) -> Result<Self, ClientError> {
        let http = reqwest::Client::builder()
            .connect_timeout(Duration::from_secs(5))
            .timeout(Duration::from_secs(60))
            .tcp_nodelay(true)
            .no_proxy()
            .build()?;
        let server = server.trim_end_matches('/').to_owned();
        Ok(Self { http, server, token: token.to_owned() })
    }

    /// Returns the URL of the server.
    #[must_use]
    pub fn server(&self) -> &str {
        &self.server
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
            .request(method, format!("{}{path}", self.server))
            .bearer_auth(&self.token)
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
            StatusCode::SERVICE_UNAVAILABLE | StatusCode::TOO_MANY_REQUESTS => {
                Err(ClientError::Busy)
            }
            status => {
                let detail = response.json::<crate::Problem>().await.unwrap_or_default().detail;
                Err(ClientError::Status { status, detail })
            }
        }
    }
}

async fn read<T: DeserializeOwned>(response: reqwest::Response) -> Result<T, ClientError> {
    Ok(decode(&response.bytes().await?)?)
}
