//! The worker's side of the lease protocol over HTTP.

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

/// Talks to one server with one token.
#[derive(Debug, Clone)]
pub struct WorkerClient {
    http: reqwest::Client,
    server: String,
    token: String,
}

/// Why a call failed.
#[derive(Debug, thiserror::Error)]
pub enum ClientError {
    /// The server could not be reached or the connection broke.
    #[error("no answer from the server: {0}")]
    Transport(#[from] reqwest::Error),
    /// The lease is no longer this worker's.
    #[error("the lease has passed to someone else")]
    Stale,
    /// The token is missing, wrong or of another scope.
    #[error("the server refuses the token ({0})")]
    Refused(StatusCode),
    /// The server is full or stopping.
    #[error("the server asks to come back later")]
    Busy,
    /// Any other status.
    #[error("the server answered {status}: {detail}")]
    Status {
        /// The status.
        status: StatusCode,
        /// The problem's detail, if it sent one.
        detail: String,
    },
    /// The answer was not understood.
    #[error(transparent)]
    Wire(#[from] WireError),
}

impl WorkerClient {
    /// A client for the server at that URL.
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

    /// Waits for a job; `None` where there was none in the time asked for.
    pub async fn lease(&self, request: &LeaseRequest) -> Result<Option<LeaseGrant>, ClientError> {
        let response = self.send(Method::POST, "/v1/leases", Some(request)).await?;
        if response.status() == StatusCode::NO_CONTENT {
            return Ok(None);
        }
        Ok(Some(read(response).await?))
    }

    /// Keeps a lease.
    pub async fn heartbeat(&self, ticket: &LeaseTicket) -> Result<(), ClientError> {
        let path = format!("/v1/leases/{}/heartbeat", ticket.lease);
        self.send(Method::POST, &path, Some(ticket)).await.map(drop)
    }

    /// Hands the results over.
    pub async fn results(&self, results: &LeaseResults) -> Result<(), ClientError> {
        let path = format!("/v1/leases/{}/results", results.ticket.lease);
        self.send(Method::POST, &path, Some(results)).await.map(drop)
    }

    /// Gives a lease back undone.
    pub async fn release(&self, ticket: &LeaseTicket) -> Result<(), ClientError> {
        let path = format!("/v1/leases/{}", ticket.lease);
        self.send(Method::DELETE, &path, Some(ticket)).await.map(drop)
    }

    /// An uploaded mesh by its content hash.
    pub async fn mesh(&self, hash: &[u8; 32]) -> Result<Mesh, ClientError> {
        let path = format!("/v1/leases/meshes/{}", blake3::Hash::from_bytes(*hash).to_hex());
        read(self.send::<()>(Method::GET, &path, None).await?).await
    }

    /// A file that a light refers to.
    pub async fn light_asset(&self, id: &str) -> Result<LightAssetFile, ClientError> {
        read(self.send::<()>(Method::GET, &format!("/v1/leases/light-assets/{id}"), None).await?)
            .await
    }

    /// Waits for a search; `None` where there was none in the time asked for.
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

    /// Keeps the lease of a search.
    pub async fn keep_search(&self, ticket: &SearchTicket) -> Result<(), ClientError> {
        let path = format!("/v1/leases/searches/{}/heartbeat", ticket.job);
        self.send(Method::POST, &path, Some(ticket)).await.map(drop)
    }

    /// Tells what came of a search.
    pub async fn report_search(&self, report: &SearchReport) -> Result<Directive, ClientError> {
        let path = format!("/v1/leases/searches/{}/report", report.ticket.job);
        read(self.send(Method::POST, &path, Some(report)).await?).await
    }

    /// Gives a search back to its queue.
    pub async fn release_search(&self, ticket: &SearchTicket) -> Result<(), ClientError> {
        let path = format!("/v1/leases/searches/{}", ticket.job);
        self.send(Method::DELETE, &path, Some(ticket)).await.map(drop)
    }

    /// A target's file by its content hash.
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
