//! Session of the page: a token in a cookie that scripts cannot read.

use axum::extract::State;
use axum::response::{IntoResponse, Response};
use http::{StatusCode, header};
use serde::Deserialize;

use crate::extract::Json;
use crate::layer::COOKIE;
use crate::problem::ApiError;
use crate::state::App;

const YEAR_S: u32 = 31_536_000;

/// Sign-in request.
#[derive(Debug, Clone, Deserialize, utoipa::ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SignIn {
    /// Token as printed by `brood token add`.
    token: String,
}

/// Signs in: stores a token in the page's cookie.
#[utoipa::path(post, path = "/v1/session", tag = "operation", request_body = SignIn,
    responses((status = 204, description = "cookie with the token set")))]
pub async fn sign_in(State(app): State<App>, body: Json<SignIn>) -> Result<Response, ApiError> {
    let token = body.value.token;
    // Tokens are hexadecimal digits: other characters must not reach a header.
    let plausible = !token.is_empty() && token.bytes().all(|byte| byte.is_ascii_alphanumeric());
    if !plausible || app.access.scope(&app.store, &token).await?.is_none() {
        return Err(ApiError::unauthorized("the token is unknown, expired or revoked").at("/token"));
    }
    Ok(cookie(&token, YEAR_S))
}

/// Signs out: removes the token from the page's cookie.
#[utoipa::path(delete, path = "/v1/session", tag = "operation",
    responses((status = 204, description = "cookie removed")))]
pub async fn sign_out() -> Response {
    cookie("", 0)
}

fn cookie(value: &str, max_age_s: u32) -> Response {
    let cookie =
        format!("{COOKIE}={value}; Path=/; Max-Age={max_age_s}; HttpOnly; SameSite=Strict");
    (StatusCode::NO_CONTENT, [(header::SET_COOKIE, cookie)]).into_response()
}
