//! Access layer: checks the token's scope, and rejects new work while the server stops.

use axum::extract::{Request, State};
use axum::middleware::Next;
use axum::response::Response;
use http::{HeaderMap, Method, header};

use crate::access::Need;
use crate::client::{Client, Peer};
use crate::listen::Stopping;
use crate::open_connections::OpenConnection;
use crate::problem::ApiError;
use crate::state::App;

/// Cookie with the page's token.
pub const COOKIE: &str = "brood_token";

/// Passes requests whose token has the needed scope.
///
/// # Errors
/// 401 or 403 if the token is missing or its scope is too small; 503 if the server stops.
pub async fn gate(
    State(app): State<App>,
    request: Request,
    next: Next,
) -> Result<Response, ApiError> {
    let need = need(request.method(), request.uri().path());
    // Workers still bring the results of running renders.
    let goes_on = need == Need::Work || request.uri().path() == "/healthz";
    if request.extensions().get::<Stopping>().is_some() && !goes_on {
        return Err(ApiError::stopping("retry after the restart"));
    }
    app.access.check(&app.store, need, token(request.headers())).await?;
    if need == Need::Work
        && let Some(connection) = request.extensions().get::<OpenConnection>()
    {
        connection.serves_worker();
    }
    if app.stopping.is_cancelled() && matches!(need, Need::Breed | Need::Admin) {
        return Err(ApiError::stopping("retry after the restart"));
    }
    let peer = request.extensions().get::<Peer>().map(|peer| peer.0);
    let client = Client::new(token(request.headers()), peer);
    Ok(client.run(next.run(request)).await)
}

/// Returns the token of a request, from its `Authorization` header or the page's cookie.
pub fn token(headers: &HeaderMap) -> Option<&str> {
    bearer(headers).or_else(|| cookie_value(headers))
}

/// Returns the least access that a route needs. Purging needs more, which its handler checks.
fn need(method: &Method, path: &str) -> Need {
    let below = |prefix: &str| {
        path.strip_prefix(prefix).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
    };
    if below("/v1/leases") {
        return Need::Work;
    }
    if below("/v1/session") || !(below("/v1") || below("/metrics")) {
        return Need::Nothing;
    }
    // These answer what the genome in the body looks like, and store nothing.
    // An export as a job stores files.
    let is_answer = below("/v1/exports") && path != "/v1/exports" || path == "/v1/render.png";
    // A client may cancel its own deferred answer; the handler checks the rest.
    let is_cancel = below("/v1/jobs") && path.ends_with("/cancel");
    match *method {
        Method::POST if is_answer || is_cancel => Need::Read,
        Method::GET | Method::HEAD | Method::OPTIONS => Need::Read,
        _ => Need::Breed,
    }
}

fn bearer(headers: &HeaderMap) -> Option<&str> {
    let text = headers.get(header::AUTHORIZATION)?.to_str().ok()?;
    let (scheme, token) = text.split_once(' ')?;
    scheme.eq_ignore_ascii_case("bearer").then(|| token.trim())
}

/// Returns the token in the page's cookie.
fn cookie_value(headers: &HeaderMap) -> Option<&str> {
    let cookies = headers.get_all(header::COOKIE).iter().filter_map(|value| value.to_str().ok());
    cookies
        .flat_map(|line| line.split(';'))
        .find_map(|pair| pair.trim().strip_prefix(COOKIE)?.strip_prefix('='))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn need_follows_route_and_method() {
        let need = |method, path| need(&method, path);
        assert_eq!(need(Method::GET, "/"), Need::Nothing);
        assert_eq!(need(Method::GET, "/v1/lineages"), Need::Read);
        assert_eq!(need(Method::GET, "/metrics"), Need::Read);
        assert_eq!(need(Method::POST, "/v1/lineages"), Need::Breed);
        assert_eq!(need(Method::POST, "/v1/exports/glsl"), Need::Read);
        assert_eq!(need(Method::POST, "/v1/exports"), Need::Breed);
        assert_eq!(need(Method::POST, "/v1/render.png"), Need::Read);
        assert_eq!(need(Method::POST, "/v1/jobs/x/cancel"), Need::Read);
        assert_eq!(need(Method::POST, "/v1/jobs/x/pause"), Need::Breed);
        assert_eq!(need(Method::POST, "/v1/leases"), Need::Work);
        assert_eq!(need(Method::GET, "/v1/leases/meshes/00"), Need::Work);
        assert_eq!(need(Method::POST, "/v1/session"), Need::Nothing);
        assert_eq!(need(Method::DELETE, "/v1/lineages/x"), Need::Breed);
    }

    #[test]
    fn token_is_found_in_header_and_cookie() {
        let mut headers = HeaderMap::new();
        headers.insert(header::AUTHORIZATION, "Bearer abc".parse().unwrap());
        headers.insert(header::COOKIE, "a=b; brood_token=xyz".parse().unwrap());
        assert_eq!(bearer(&headers), Some("abc"));
        assert_eq!(cookie_value(&headers), Some("xyz"));
        headers.insert(header::COOKIE, "not_brood_token=xyz".parse().unwrap());
        assert_eq!(cookie_value(&headers), None);
    }
}
