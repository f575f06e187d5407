//! TLS, and HTTP clients over it. They trust the public authorities of webpki-roots, or those of a
//! file.

use std::path::Path;
use std::sync::Arc;

use reqwest::redirect::Policy;
use reqwest::{ClientBuilder, Url};
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
    /// The file of authorities has none.
    #[error("there are no valid certificates in {0}")]
    Empty(String),
    /// rustls rejects the default protocol versions.
    #[error("cannot set up TLS: {0}")]
    Library(#[from] rustls::Error),
}

/// Returns the settings of clients: TLS 1.2 and 1.3 by rustls and ring. Clients trust the
/// authorities of a file in PEM format; without a file, the public authorities. rustls cannot read
/// some certificates of common systems: these are ignored.
///
/// # Errors
/// Returns a [`TlsError`] if the file cannot be read or has no valid certificate.
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
    let read = CertificateDer::pem_file_iter(file).map_err(unreadable)?;
    let certificates = read.collect::<Result<Vec<_>, _>>().map_err(unreadable)?;
    match roots.add_parsable_certificates(certificates) {
        (0, _) => Err(TlsError::Empty(name())),
        _ => Ok(roots),
    }
}

/// Error of the URL of a server.
#[derive(Debug, thiserror::Error)]
pub enum ServerUrlError {
    /// The URL is malformed, or of another scheme.
    #[error("the URL of a server begins with http:// or https:// and has a name, got {0:?}")]
    Malformed(String),
    /// The URL has a user, a password, a query or a fragment.
    #[error("the URL of a server has no user, password, query or fragment")]
    Extra,
    /// The authorities cannot be read.
    #[error("SSL_CERT_FILE: {0}")]
    Tls(#[from] TlsError),
}

/// URL of a server, which may have a path, with the settings of TLS for connections to it.
#[derive(Debug, Clone)]
pub struct ServerUrl {
    url: Url,
    tls: ClientConfig,
}

impl ServerUrl {
    /// Parses a URL. With `https`, reads the authorities of the file that the environment variable
    /// `SSL_CERT_FILE` names; without it, the public ones are trusted.
    ///
    /// # Errors
    /// Returns a [`ServerUrlError`] if the URL is malformed or the file cannot be read.
    pub fn parse(text: &str) -> Result<Self, ServerUrlError> {
        let file = std::env::var_os(AUTHORITIES).filter(|file| !file.is_empty());
        Self::with_authorities(text, file.as_deref().map(Path::new))
    }

    /// Parses a URL; with `https`, the authorities of this file are trusted instead of the public
    /// ones.
    pub(crate) fn with_authorities(
        text: &str,
        authorities: Option<&Path>,
    ) -> Result<Self, ServerUrlError> {
        let url = Url::parse(text).ok();
        let url = url.filter(|url| ["http", "https"].contains(&url.scheme()) && url.has_host());
        let url = url.ok_or_else(|| ServerUrlError::Malformed(text.to_owned()))?;
        let has_user = !url.username().is_empty() || url.password().is_some();
        if has_user || url.query().is_some() || url.fragment().is_some() {
            return Err(ServerUrlError::Extra);
        }
        let tls = tls_config(authorities.filter(|_| url.scheme() == "https"))?;
        Ok(Self { url, tls })
    }

    /// Returns the URL without a slash at the end.
    #[must_use]
    pub fn as_str(&self) -> &str {
        self.url.as_str().trim_end_matches('/')
    }

    /// Returns the name or address, and the port.
    pub(crate) fn host(&self) -> Option<(&str, u16)> {
        Some((self.url.host_str()?, self.url.port_or_known_default()?))
    }

    /// Returns the builder of an HTTP client. The client follows no redirect, because reqwest
    /// removes the token before a request to another host. It ignores proxies of the environment.
    pub fn client(&self) -> ClientBuilder {
        let client = ClientBuilder::new().tls_backend_preconfigured(self.tls.clone());
        client.tcp_nodelay(true).no_proxy().redirect(Policy::none())
    }
}

#[cfg(test)]
mod tests {
    use std::io::{Read as _, Write as _};
    use std::net::{IpAddr, TcpListener};
    use std::path::PathBuf;
    use std::thread::JoinHandle;

    use rustls::pki_types::PrivateKeyDer;
    use rustls::{ServerConfig, ServerConnection, Stream};

    use super::*;
    use crate::{ClientError, ExportGrant, ExportRequest, WorkerClient};

    /// Certificate of `brood.test`, signed with its own key, valid until 2126; and the key.
    fn pem(name: &str) -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/tls").join(name)
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

    /// Requests a job at 127.0.0.1 as the server of this URL.
    async fn claim(
        url: &str,
        authorities: Option<&Path>,
    ) -> Result<Option<ExportGrant>, ClientError> {
        let url = ServerUrl::with_authorities(url, authorities).unwrap();
        let client = WorkerClient::of(url, "").unwrap().at(IpAddr::from([127, 0, 0, 1])).unwrap();
        client.claim(&ExportRequest { worker: "test".to_owned(), wait_ms: 0 }).await
    }

    #[tokio::test]
    async fn server_of_a_trusted_authority_is_reached_at_its_address_by_its_name() {
        let (port, server) = serve();
        let url = format!("https://brood.test:{port}");
        assert!(claim(&url, Some(&pem("certificate.pem"))).await.unwrap().is_none());
        assert_eq!(server.join().unwrap(), "POST /v1/leases/exports HTTP/1.1");
    }

    #[tokio::test]
    async fn server_is_refused_when_its_authority_is_unknown_or_its_name_another() {
        let authorities = pem("certificate.pem");
        for (name, authorities, reason) in [
            ("brood.test", None, "UnknownIssuer"),
            ("other.test", Some(authorities.as_path()), "not valid for name"),
        ] {
            let (port, server) = serve();
            let url = format!("https://{name}:{port}");
            let error = claim(&url, authorities).await.unwrap_err().to_string();
            assert!(error.contains(reason), "{error}");
            assert!(server.join().unwrap().contains("alert"));
        }
    }

    #[test]
    fn authorities_are_read_for_https_only_and_errors_name_the_file() {
        let parse = |url: &str, file: &Path| ServerUrl::with_authorities(url, Some(file));
        let missing = Path::new("/no/such/file");
        assert!(parse("http://brood.test", missing).is_ok());
        let error = parse("https://brood.test", missing).unwrap_err().to_string();
        let start = "SSL_CERT_FILE: cannot read the certificates of /no/such/file: ";
        assert!(error.starts_with(start), "{error}");
        let key = pem("key.pem");
        let error = parse("https://brood.test", &key).unwrap_err().to_string();
        let end = format!("there are no valid certificates in {}", key.display());
        assert!(error.ends_with(&end), "{error}");
    }

    #[test]
    fn url_is_checked() {
        let parse = |url: &str| ServerUrl::with_authorities(url, None);
        for url in ["brood.test:7320", "brood.test", "ftp://brood.test", "http://", ""] {
            let error = parse(url).unwrap_err().to_string();
            assert!(error.ends_with(&format!("and has a name, got {url:?}")), "{error}");
        }
        for part in ["anna:secret@brood.test", "anna@brood.test", "brood.test?a", "brood.test#a"] {
            let error = parse(&format!("http://{part}")).unwrap_err().to_string();
            assert!(error.ends_with("has no user, password, query or fragment"), "{error}");
        }
        for (url, found) in [
            ("https://brood.test/", "https://brood.test"),
            ("http://brood.test:7320/studio/ ", "http://brood.test:7320/studio"),
        ] {
            assert_eq!(parse(url).unwrap().as_str(), found);
        }
    }
}
