//! Layers around every request, one concern per file. From the outside in: [`finish`] (id, span,
//! metrics, problem bodies, security headers), panics, [`host`], [`origin`], [`gate`] (access and
//! shutdown). [`query`] is around the documented routes only.

mod finish;
mod gate;
mod host;
mod origin;
mod query;
mod watch;

use axum::Router;
use axum::middleware::{from_fn, from_fn_with_state};
use tower_http::catch_panic::CatchPanicLayer;
use utoipa::openapi::OpenApi;

use crate::problem::ApiError;
use crate::state::App;
use axum::response::{IntoResponse, Response};
use query::QueryRoutes;

pub use gate::{COOKIE, token};

/// Wraps documented routes in the check of their queries.
pub fn check_queries<S: Clone + Send + Sync + 'static>(
    router: Router<S>,
    openapi: &OpenApi,
) -> Router<S> {
    router.route_layer(from_fn_with_state(QueryRoutes::of(openapi), query::check))
}

/// Wraps the routes in the layers.
pub fn wrap(router: Router, app: &App) -> Router {
    router
        .layer(from_fn_with_state(app.clone(), gate::gate))
        .layer(from_fn(origin::check))
        .layer(from_fn_with_state(app.clone(), host::check))
        .layer(CatchPanicLayer::custom(panicked))
        .layer(from_fn_with_state(app.clone(), finish::finish))
}

fn panicked(payload: Box<dyn std::any::Any + Send>) -> Response {
    let text = payload.downcast_ref::<&str>().map(|text| (*text).to_owned());
    let text = text.or_else(|| payload.downcast_ref::<String>().cloned());
    let text = text.unwrap_or_else(|| "a panic without a message".to_owned());
    ApiError::internal(format!("a handler panicked: {text}")).into_response()
}
