//! HTTP of the object store.

use std::path::Path;
use std::time::Duration;

use async_trait::async_trait;
use brood_protocol::tls_config;
use http_body_util::BodyExt as _;
use hyper_rustls::{HttpsConnector, HttpsConnectorBuilder};
use hyper_util::client::legacy;
use hyper_util::client::legacy::connect::HttpConnector as TcpConnector;
use hyper_util::rt::{TokioExecutor, TokioTimer};
use object_store::client::{
    HttpClient, HttpConnector, HttpError, HttpErrorKind, HttpRequest, HttpRequestBody,
    HttpResponse, HttpResponseBody, HttpService,
};
use object_store::{ClientConfigKey, ClientOptions};

use crate::StorageError;
use crate::error::Result;

/// Time for a connection to be accepted.
const CONNECT: Duration = Duration::from_secs(3);
/// Time after which a connection without requests is closed.
const IDLE: Duration = Duration::from_secs(20);

/// Client of an object store and of the services that give its credentials.
#[derive(Debug, Clone)]
pub(crate) struct BlobClient(legacy::Client<HttpsConnector<TcpConnector>, HttpRequestBody>);

impl BlobClient {
    /// Makes a client that trusts the authorities of a file, or the public ones.
    ///
    /// # Errors
    /// Returns [`StorageError::Unsupported`] if the file cannot be read.
    pub fn new(authorities: Option<&str>) -> Result<Self> {
        let tls = tls_config(authorities.map(Path::new))
            .map_err(|error| StorageError::Unsupported(format!("AWS_CA_BUNDLE: {error}")))?;
        let mut tcp = TcpConnector::new();
        tcp.enforce_http(false);
        tcp.set_nodelay(true);
        tcp.set_connect_timeout(Some(CONNECT));
        let https = HttpsConnectorBuilder::new()
            .with_tls_config(tls)
            .https_or_http()
            .enable_http1()
            .wrap_connector(tcp);
        let client = legacy::Client::builder(TokioExecutor::new())
            .pool_timer(TokioTimer::new())
            .pool_idle_timeout(IDLE)
            .build(https);
        Ok(Self(client))
    }
}

impl HttpConnector for BlobClient {
    fn connect(&self, options: &ClientOptions) -> object_store::Result<HttpClient> {
        let allowed = options.get_config_value(&ClientConfigKey::AllowHttp);
        let allows_plain = allowed.as_deref() == Some("true");
        Ok(HttpClient::new(BlobService { client: self.clone(), allows_plain }))
    }
}

/// Client for one purpose.
#[derive(Debug)]
struct BlobService {
    client: BlobClient,
    /// True if requests without TLS may be sent.
    allows_plain: bool,
}

#[async_trait]
impl HttpService for BlobService {
    async fn call(&self, request: HttpRequest) -> Result<HttpResponse, HttpError> {
        if !self.allows_plain && request.uri().scheme_str() != Some("https") {
            let words = "the endpoint must begin with https://, or AWS_ALLOW_HTTP must be true";
            return Err(HttpError::new_boxed(HttpErrorKind::Unknown, words.into()));
        }
        let answer = self.client.0.request(request).await.map_err(|error| {
            let kind = match error.is_connect() {
                true => HttpErrorKind::Connect,
                false => HttpErrorKind::Interrupted,
            };
            HttpError::new(kind, error)
        })?;
        let (head, body) = answer.into_parts();
        let body = body.map_err(|error| HttpError::new(HttpErrorKind::Interrupted, error));
        Ok(HttpResponse::from_parts(head, HttpResponseBody::new(body)))
    }
}
