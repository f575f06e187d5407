//! Client of the tests.

use std::sync::Arc;

use reqwest::ClientBuilder;
use rustls::{ClientConfig, RootCertStore};

/// Returns a client to be completed, for HTTP alone: it trusts no certificate. The program that is
/// tested needs reqwest with TLS, and reqwest reads the certificates of the system by default.
///
/// # Panics
/// Never: the settings are rustls's own.
pub fn http_client() -> ClientBuilder {
    let provider = Arc::new(rustls::crypto::ring::default_provider());
    let tls = ClientConfig::builder_with_provider(provider)
        .with_safe_default_protocol_versions()
        .expect("ring has what the default versions need")
        .with_root_certificates(RootCertStore::empty())
        .with_no_client_auth();
    ClientBuilder::new().tls_backend_preconfigured(tls)
}
