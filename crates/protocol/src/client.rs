//! HTTP client of the lease protocol, for workers.

use std::time::Duration;

use brood_scene::Mesh;
use reqwest::{Method, StatusCode, header};
use serde::{Serialize, de::DeserializeOwned};

use crate::lease::{
    CONTENT_TYPE, LeaseGrant, LeaseRequest, LeaseResults, LeaseTicket, WireError, decode, encode,
};
use crate::{
    Directive, LightAssetFile, SearchGrant, SearchReport, SearchRequest, SearchTicket, TargetBytes,
};

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

    /// Requests a render job. Returns `None` if there was none within the requested time.
    ///
    /// # Errors
    /// Returns a [`ClientError`] if the call fails or the response cannot be decoded.
    pub async fn lease(&self, request: &LeaseRequest) -> Result<Option<LeaseGrant>, ClientError> {
        let response = self.send(Method::POST, "/v1/leases", Some(request)).await?;
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
    pub async fn heartbeat(&self, ticket: &LeaseTicket) -> Result<(), ClientError> {
        let path = format!("/v1/leases/{}/heartbeat", ticket.lease);
        self.send(Method::POST, &path, Some(ticket)).await.map(drop)
    }

    /// Submits results.
    ///
    /// # Errors
    /// Returns [`ClientError::Stale`] if the lease is no longer valid; other variants if the call
    /// fails.
    pub async fn results(&self, results: &LeaseResults) -> Result<(), ClientError> {
        let path = format!("/v1/leases/{}/results", results.ticket.lease);
        self.send(Method::POST, &path, Some(results)).await.map(drop)
    }

    /// Returns an unfinished job to the queue.
    ///
    /// # Errors
    /// Returns [`ClientError::Stale`] if the lease is no longer valid; other variants if the call
    /// fails.
    pub async fn release(&self, ticket: &LeaseTicket) -> Result<(), ClientError> {
        let path = format!("/v1/leases/{}", ticket.lease);
        self.send(Method::DELETE, &path, Some(ticket)).await.map(drop)
    }

    /// Downloads an uploaded mesh by its content hash.
    ///
    /// # Errors
    /// Returns a [`ClientError`] if the call fails or the response cannot be decoded.
    pub async fn mesh(&self, hash: &[u8; 32]) -> Result<Mesh, ClientError> {
        let path = format!("/v1/leases/meshes/{}", blake3::Hash::from_bytes(*hash).to_hex());
        read(self.send::<()>(Method::GET, &path, None).await?).await
    }

    /// Downloads a light asset.
    ///
    /// # Errors
    /// Returns a [`ClientError`] if the call fails or the response cannot be decoded.
    pub async fn light_asset(&self, id: &str) -> Result<LightAssetFile, ClientError> {
        read(self.send::<()>(Method::GET, &format!("/v1/leases/light-assets/{id}"), None).await?)
            .await
    }

    /// Requests a search. Returns `None` if there was none within the requested time.
    ///
    /// # Errors
    /// Returns a [`ClientError`] if the call fails or the response cannot be decoded.
    pub async fn lease_search(
        &self,
        request: &SearchRequest,
    ) -> Result<Option<SearchGrant>, ClientError> {
        let response = self.send(Method::POST, "/v1/leases/searches", Some(request)).await?;
        if response.status() == StatusCode::NO_CONTENT {
            return Ok(None);
        }
        Ok(Some(read(response).await?))
    }

    /// Renews the lease of a search.
    ///
    /// # Errors
    /// Returns [`ClientError::Stale`] if the lease is no longer valid; other variants if the call
    /// fails.
    pub async fn heartbeat_search(&self, ticket: &SearchTicket) -> Result<(), ClientError> {
        let path = format!("/v1/leases/searches/{}/heartbeat", ticket.job);
        self.send(Method::POST, &path, Some(ticket)).await.map(drop)
    }

    /// Reports progress or the end of a search.
    ///
    /// # Errors
    /// Returns [`ClientError::Stale`] if the lease is no longer valid; other variants if the call
    /// fails.
    pub async fn report_search(&self, report: &SearchReport) -> Result<Directive, ClientError> {
        let path = format!("/v1/leases/searches/{}/report", report.ticket.job);
        read(self.send(Method::POST, &path, Some(report)).await?).await
    }

    /// Returns a search to the queue.
    ///
    /// # Errors
    /// Returns [`ClientError::Stale`] if the lease is no longer valid; other variants if the call
    /// fails.
    pub async fn release_search(&self, ticket: &SearchTicket) -> Result<(), ClientError> {
        let path = format!("/v1/leases/searches/{}", ticket.job);
        self.send(Method::DELETE, &path, Some(ticket)).await.map(drop)
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
