//! Host names that the server answers to.

use std::collections::HashSet;
use std::net::IpAddr;

use http::{Request, Version, header, uri::Authority};

use crate::error::ServerError;
use crate::problem::{ApiError, quote};

/// Host names that the server answers to.
#[derive(Debug, Clone)]
pub struct HostNames(HashSet<String>);

impl HostNames {
    /// Collects the three forms of localhost, the listening address, and the allowed names.
    ///
    /// # Errors
    /// [`ServerError::HostName`] if an allowed name is not a host name.
    pub fn new(listen: IpAddr, allowed: &[String]) -> Result<Self, ServerError> {
        let mut names: HashSet<_> =
            ["localhost", "127.0.0.1", "[::1]"].into_iter().map(str::to_owned).collect();
        if !listen.is_unspecified() {
            names.insert(match listen {
                IpAddr::V4(address) => address.to_string(),
                IpAddr::V6(address) => format!("[{address}]"),
            });
        }
        for name in allowed {
            let authority: Option<Authority> = name.parse().ok();
            let authority = authority.filter(|a| a.port().is_none() && !name.contains('@'));
            let authority = authority.ok_or_else(|| ServerError::HostName(quote(name)))?;
            names.insert(authority.host().to_ascii_lowercase());
        }
        Ok(Self(names))
    }

    /// Checks the host of a request.
    ///
    /// # Errors
    /// 421 if the host is foreign, 400 if it is missing, repeated or malformed.
    pub fn check<B>(&self, request: &Request<B>) -> Result<(), ApiError> {
        let mut hosts = request.headers().get_all(header::HOST).iter();
        let (first, second) = (hosts.next(), hosts.next());
        if second.is_some() {
            return Err(ApiError::bad_request("there must be one Host header, got several"));
        }
        match first {
            Some(host) => {
                let text = host
                    .to_str()
                    .map_err(|_| ApiError::bad_request("the Host header must be ASCII"))?;
                self.check_name(text)?;
            }
            None if request.version() < Version::HTTP_2 => {
                return Err(ApiError::bad_request("the Host header is missing"));
            }
            None => {}
        }
        // An absolute request target takes precedence over the header, so it is checked as well.
        request.uri().authority().map_or(Ok(()), |authority| self.check_name(authority.as_str()))
    }

    fn check_name(&self, text: &str) -> Result<(), ApiError> {
        let malformed = || ApiError::bad_request("the Host header must be a host name");
        let authority: Authority = text.parse().map_err(|_| malformed())?;
        if text.contains('@') {
            return Err(malformed());
        }
        if self.0.contains(&authority.host().to_ascii_lowercase()) {
            return Ok(());
        }
        Err(ApiError::foreign_host(format!(
            "{} is not a name of this server; allow it with --allow-host",
            quote(authority.host())
        )))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn status(uri: &str, hosts: &[&str]) -> u16 {
        let names =
            HostNames::new("127.0.0.1".parse().unwrap(), &["Brood.example".to_owned()]).unwrap();
        let mut request = Request::builder().uri(uri);
        for host in hosts {
            request = request.header(header::HOST, *host);
        }
        match names.check(&request.body(()).unwrap()) {
            Ok(()) => 200,
            Err(error) => error.status(),
        }
    }

    #[test]
    fn own_names_pass_with_any_port() {
        for host in ["localhost", "LOCALHOST:1", "127.0.0.1:7320", "[::1]:80", "brood.example:443"]
        {
            assert_eq!(status("/", &[host]), 200, "{host}");
        }
    }

    #[test]
    fn foreign_names_are_misdirected() {
        for host in ["evil.example", "localhost.evil.example", "127.0.0.2", "localhost."] {
            assert_eq!(status("/", &[host]), 421, "{host}");
        }
        assert_eq!(status("http://evil.example/", &["localhost"]), 421);
    }

    #[test]
    fn missing_repeated_and_malformed_hosts_are_bad_requests() {
        assert_eq!(status("/", &[]), 400);
        assert_eq!(status("/", &["localhost", "localhost"]), 400);
        assert_eq!(status("/", &["a b"]), 400);
        assert_eq!(status("/", &["user@localhost"]), 400);
        assert_eq!(status("/", &[""]), 400);
    }

    #[test]
    fn allowed_names_are_refused_when_they_are_not_host_names() {
        let listen = "0.0.0.0".parse().unwrap();
        for name in ["", "a b", "a/b", "host:80", "user@host"] {
            assert!(HostNames::new(listen, &[name.to_owned()]).is_err(), "{name}");
        }
    }
}
