//! Host check: rejects requests to foreign host names that resolve to this server (DNS rebinding).

use axum::extract::{Request, State};
use axum::middleware::Next;
use axum::response::Response;

use crate::problem::ApiError;
use crate::state::App;

/// Passes requests to the server's own names.
///
/// # Errors
/// 421 if the host is foreign, 400 if it is missing, repeated or malformed.
pub async fn check(
    State(app): State<App>,
    request: Request,
    next: Next,
) -> Result<Response, ApiError> {
    app.hosts.check(&request)?;
    Ok(next.run(request).await)
}
