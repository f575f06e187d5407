//! Origin check: browsers may write only from this server's own page.

use axum::extract::Request;
use axum::middleware::Next;
use axum::response::Response;
use http::{HeaderMap, Method, header};

use crate::problem::ApiError;

/// Passes reads, and writes that do not come from another site's page.
///
/// # Errors
/// 403 for writes of other sites.
pub async fn check(request: Request, next: Next) -> Result<Response, ApiError> {
    check_headers(request.method(), request.headers())?;
    Ok(next.run(request).await)
}

fn check_headers(method: &Method, headers: &HeaderMap) -> Result<(), ApiError> {
    if method.is_safe() {
        return Ok(());
    }
    let refuse = || Err(ApiError::cross_origin("the request comes from another site's page"));
    let text = |name| headers.get(name).map(|value| value.to_str().unwrap_or("?"));
    if text("sec-fetch-site").is_some_and(|site| site != "same-origin" && site != "none") {
        return refuse();
    }
    let Some(origin) = text(header::ORIGIN.as_str()) else { return Ok(()) };
    let authority = origin.strip_prefix("http://").or_else(|| origin.strip_prefix("https://"));
    match (authority, text(header::HOST.as_str())) {
        (Some(authority), Some(host)) if authority.eq_ignore_ascii_case(host) => Ok(()),
        _ => refuse(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn passes(method: Method, origin: Option<&'static str>, site: Option<&'static str>) -> bool {
        let mut headers = HeaderMap::new();
        headers.insert(header::HOST, "localhost:7320".parse().unwrap());
        if let Some(origin) = origin {
            headers.insert(header::ORIGIN, origin.parse().unwrap());
        }
        if let Some(site) = site {
            headers.insert("sec-fetch-site", site.parse().unwrap());
        }
        check_headers(&method, &headers).is_ok()
    }

    #[test]
    fn writes_pass_from_scripts_and_from_the_own_page() {
        assert!(passes(Method::POST, None, None));
        assert!(passes(Method::POST, Some("http://localhost:7320"), Some("same-origin")));
        assert!(passes(Method::DELETE, Some("https://LOCALHOST:7320"), None));
        assert!(passes(Method::GET, Some("http://evil.example"), Some("cross-site")));
    }

    #[test]
    fn writes_are_refused_from_other_sites() {
        assert!(!passes(Method::POST, Some("http://evil.example"), None));
        assert!(!passes(Method::PATCH, Some("http://localhost:1"), None));
        assert!(!passes(Method::DELETE, Some("null"), None));
        assert!(!passes(Method::POST, None, Some("cross-site")));
        assert!(!passes(Method::POST, None, Some("same-site")));
    }
}
