//! Client of the tests.

use std::sync::Arc;

use reqwest::ClientBuilder;
use rustls::{ClientConfig, RootCertStore};

/// Returns the builder of a client for HTTP alone: it trusts no certificate. reqwest is built with
/// TLS, as the program that is tested needs it, and would read the certificates of the system.
#[expect(clippy::missing_panics_doc, reason = "ring has what the default versions need")]
pub fn http_client() -> ClientBuilder {
    let provider = Arc::new(rustls::crypto::ring::default_provider());
    let tls = ClientConfig::builder_with_provider(provider)
        .with_safe_default_protocol_versions()
        .expect("ring has what the default versions need")
        .with_root_certificates(RootCertStore::empty())
        .with_no_client_auth();
    ClientBuilder::new().tls_backend_preconfigured(tls)
}
