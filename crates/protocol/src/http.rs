//! TLS, and the client of HTTP over it. Trusted are the public authorities of webpki-roots, or
//! those of a file.

use std::path::Path;
use std::sync::Arc;

use rustls::pki_types::CertificateDer;
use rustls::pki_types::pem::{Error as PemError, PemObject as _};
use rustls::{ClientConfig, RootCertStore};

/// Environment variable that OpenSSL reads too: file with the authorities to trust instead of the
/// public ones, in PEM format.
const AUTHORITIES: &str = "SSL_CERT_FILE";

/// Error of the set-up of TLS.
#[derive(Debug, thiserror::Error)]
pub enum TlsError {
    /// The file of authorities cannot be read.
    #[error("cannot read the certificates of {0}: {1}")]
    Authorities(String, PemError),
    /// An authority is malformed.
    #[error("a certificate of {0} is malformed: {1}")]
    Authority(String, rustls::Error),
    /// The file of authorities has none.
    #[error("there are no certificates in {0}")]
    Empty(String),
    /// The library refuses its own defaults.
    #[error("cannot set up TLS: {0}")]
    Library(#[from] rustls::Error),
}

/// Returns the settings of clients: TLS 1.2 and 1.3 by rustls and ring. They trust the authorities
/// of a file in PEM format, or else the public ones.
///
/// # Errors
/// Returns a [`TlsError`] if the file cannot be read.
pub fn tls_config(authorities: Option<&Path>) -> Result<ClientConfig, TlsError> {
    let provider = Arc::new(rustls::crypto::ring::default_provider());
    let config =
        ClientConfig::builder_with_provider(provider).with_safe_default_protocol_versions()?;
    Ok(config.with_root_certificates(roots(authorities)?).with_no_client_auth())
}

fn roots(authorities: Option<&Path>) -> Result<RootCertStore, TlsError> {
    let mut roots = RootCertStore::empty();
    let Some(file) = authorities else {
        roots.extend(webpki_roots::TLS_SERVER_ROOTS.iter().cloned());
        return Ok(roots);
    };
    let name = || file.display().to_string();
    let unreadable = |error| TlsError::Authorities(name(), error);
    for certificate in CertificateDer::pem_file_iter(file).map_err(unreadable)? {
        let added = roots.add(certificate.map_err(unreadable)?);
        added.map_err(|error| TlsError::Authority(name(), error))?;
    }
    if roots.is_empty() {
        return Err(TlsError::Empty(name()));
    }
    Ok(roots)
}

/// Returns a client of HTTP and HTTPS to be completed, which ignores proxies of the environment.
/// It trusts the authorities of the file that the environment variable `SSL_CERT_FILE` names, or
/// else the public ones.
///
/// # Errors
/// Returns a [`TlsError`] if the file cannot be read.
pub fn http_client() -> Result<reqwest::ClientBuilder, TlsError> {
    let file = std::env::var_os(AUTHORITIES).filter(|file| !file.is_empty());
    http_client_with(file.as_deref().map(Path::new))
}

/// Returns the client with the authorities of a file, or the public ones.
pub(crate) fn http_client_with(
    authorities: Option<&Path>,
) -> Result<reqwest::ClientBuilder, TlsError> {
    let config = tls_config(authorities)?;
    let client = reqwest::Client::builder().tls_backend_preconfigured(config);
    Ok(client.tcp_nodelay(true).no_proxy())
}

#[cfg(test)]
mod tests {
    use std::io::{Read as _, Write as _};
    use std::net::TcpListener;
    use std::path::PathBuf;
    use std::thread::JoinHandle;

    use rustls::pki_types::PrivateKeyDer;
    use rustls::{ServerConfig, ServerConnection, Stream};

    use super::*;

    /// Certificate of `localhost`, signed with its own key, valid until 2126, and the key.
    fn pem(name: &str) -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("src/localhost").join(name)
    }

    /// Answers one connection with TLS. Returns the port, and the first line of the request, or the
    /// reason of the failed handshake.
    fn serve() -> (u16, JoinHandle<String>) {
        let certificate = CertificateDer::from_pem_file(pem("certificate.pem")).unwrap();
        let key = PrivateKeyDer::from_pem_file(pem("key.pem")).unwrap();
        let provider = Arc::new(rustls::crypto::ring::default_provider());
        let config = ServerConfig::builder_with_provider(provider)
            .with_safe_default_protocol_versions()
            .unwrap()
            .with_no_client_auth()
            .with_single_cert(vec![certificate], key)
            .unwrap();
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port();
        let server = std::thread::spawn(move || {
            let (mut tcp, _) = listener.accept().unwrap();
            let mut tls = ServerConnection::new(Arc::new(config)).unwrap();
            let mut stream = Stream::new(&mut tls, &mut tcp);
            let mut head = vec![0; 4096];
            match stream.read(&mut head) {
                Err(error) => error.to_string(),
                Ok(length) => {
                    stream.write_all(b"HTTP/1.1 204 No Content\r\n\r\n").unwrap();
                    let head = String::from_utf8_lossy(&head[..length]);
                    head.lines().next().unwrap_or_default().to_owned()
                }
            }
        });
        (port, server)
    }

    async fn get(port: u16, authorities: Option<&Path>) -> reqwest::Result<reqwest::Response> {
        let client = http_client_with(authorities).unwrap().build().unwrap();
        client.get(format!("https://localhost:{port}/readyz")).send().await
    }

    #[tokio::test]
    async fn server_of_a_trusted_authority_is_reached() {
        let (port, server) = serve();
        let answer = get(port, Some(&pem("certificate.pem"))).await.unwrap();
        assert_eq!(answer.status(), 204);
        assert_eq!(server.join().unwrap(), "GET /readyz HTTP/1.1");
    }

    #[tokio::test]
    async fn server_of_an_unknown_authority_is_refused() {
        let (port, server) = serve();
        let error = crate::client::causes(&get(port, None).await.unwrap_err());
        assert!(error.contains("invalid peer certificate: UnknownIssuer"), "{error}");
        assert!(server.join().unwrap().contains("alert"));
    }

    #[test]
    fn error_names_the_file_of_authorities() {
        let error = |file: &Path| tls_config(Some(file)).unwrap_err().to_string();
        let missing = error(Path::new("/no/such/file"));
        assert!(
            missing.starts_with("cannot read the certificates of /no/such/file: "),
            "{missing}"
        );
        let empty = pem("key.pem");
        let expected = format!("there are no certificates in {}", empty.display());
        assert_eq!(error(&empty), expected);
    }
}
