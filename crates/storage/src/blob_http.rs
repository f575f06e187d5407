//! HTTP of the object store, with the TLS that connections to PostgreSQL use: rustls, ring, and
//! the public authorities of webpki-roots.

use std::sync::Arc;
use std::time::Duration;

use async_trait::async_trait;
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
use rustls::pki_types::CertificateDer;
use rustls::pki_types::pem::PemObject as _;
use rustls::{ClientConfig, RootCertStore};

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
        let provider = Arc::new(rustls::crypto::ring::default_provider());
        let tls = ClientConfig::builder_with_provider(provider)
            .with_safe_default_protocol_versions()
            .map_err(|error| StorageError::Unsupported(error.to_string()))?
            .with_root_certificates(roots(authorities)?)
            .with_no_client_auth();
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

fn roots(authorities: Option<&str>) -> Result<RootCertStore> {
    let mut roots = RootCertStore::empty();
    let Some(file) = authorities else {
        roots.extend(webpki_roots::TLS_SERVER_ROOTS.iter().cloned());
        return Ok(roots);
    };
    let invalid = |error: String| {
        StorageError::Unsupported(format!("cannot read the certificates of AWS_CA_BUNDLE: {error}"))
    };
    let read = CertificateDer::pem_file_iter(file).map_err(|error| invalid(error.to_string()))?;
    for certificate in read {
        let certificate = certificate.map_err(|error| invalid(error.to_string()))?;
        roots.add(certificate).map_err(|error| invalid(error.to_string()))?;
    }
    if roots.is_empty() {
        return Err(invalid("the file has none".to_owned()));
    }
    Ok(roots)
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
