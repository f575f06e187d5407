//! Layers around every request, one concern per file. From the outside in: [`finish`] (id, span,
//! metrics, problem bodies, security headers), panics, [`host`], [`origin`], [`gate`] (access and
//! shutdown).

mod finish;
mod gate;
mod host;
mod origin;
mod watch;

use axum::Router;
use axum::middleware::{from_fn, from_fn_with_state};
use tower_http::catch_panic::CatchPanicLayer;

use crate::problem::ApiError;
use crate::state::App;
use axum::response::{IntoResponse, Response};

pub use gate::{COOKIE, token};

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
