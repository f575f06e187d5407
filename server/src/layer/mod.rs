//! Layers around every request, one concern per file. From the outside in: compression, [`finish`]
//! (id, span, metrics, problem bodies, security headers), panics, [`host`], [`origin`], [`gate`]
//! (access and shutdown). [`query`] is around the documented routes only, [`prefer`] around those
//! that take long.

mod finish;
mod gate;
mod host;
mod origin;
mod prefer;
mod query;
mod watch;

use axum::Router;
use axum::body::HttpBody;
use axum::extract::Request;
use axum::middleware::{Next, from_fn, from_fn_with_state};
use axum::response::{IntoResponse, Response};
use http::HeaderValue;
use http::header::ACCEPT_ENCODING;
use tower_http::catch_panic::CatchPanicLayer;
use tower_http::compression::predicate::{DefaultPredicate, Predicate};
use tower_http::compression::{CompressionLayer, CompressionLevel};
use utoipa::openapi::OpenApi;

use crate::problem::ApiError;
use crate::state::App;
use query::QueryRoutes;

pub use gate::{COOKIE, token};

/// Level of Brotli and gzip: higher ones take several times as long for a few percent.
const COMPRESSION: CompressionLevel = CompressionLevel::Precise(5);

/// Largest body that is compressed: that takes about 20 ms of a thread of the runtime. Larger ones
/// are files, such as lineages and meshes.
const COMPRESSED_BYTES_MAX: u64 = 1 << 20;

/// Selects answers that are not too large to compress.
#[derive(Clone, Copy)]
struct Moderate;

impl Predicate for Moderate {
    fn should_compress<B: HttpBody>(&self, answer: &http::Response<B>) -> bool {
        answer.body().size_hint().upper().is_some_and(|bytes| bytes <= COMPRESSED_BYTES_MAX)
    }
}

/// Wraps documented routes in the check of their queries.
pub fn check_queries<S: Clone + Send + Sync + 'static>(
    router: Router<S>,
    openapi: &OpenApi,
) -> Router<S> {
    router.route_layer(from_fn_with_state(QueryRoutes::of(openapi), query::check))
}

/// Wraps routes whose answers can be deferred.
pub fn defer_answers(router: Router<App>, app: &App) -> Router<App> {
    router.route_layer(from_fn_with_state(app.clone(), prefer::defer))
}

/// Wraps the routes in the layers.
pub fn wrap(router: Router, app: &App) -> Router {
    router
        .layer(from_fn_with_state(app.clone(), gate::gate))
        .layer(from_fn(origin::check))
        .layer(from_fn_with_state(app.clone(), host::check))
        .layer(CatchPanicLayer::custom(panicked))
        .layer(from_fn_with_state(app.clone(), finish::finish))
        // Outermost, because `finish` replaces bodies. The default skips pictures and events.
        .layer(
            CompressionLayer::new()
                .quality(COMPRESSION)
                .compress_when(DefaultPredicate::new().and(Moderate)),
        )
        .layer(from_fn(accept_identity))
}

/// Makes uncompressed answers acceptable if nothing else is. Without this, a change would be made
/// and then answered with 406.
async fn accept_identity(mut request: Request, next: Next) -> Response {
    let headers = request.headers_mut();
    if let http::header::Entry::Occupied(mut accepted) = headers.entry(ACCEPT_ENCODING) {
        let values: Vec<HeaderValue> = accepted.iter().cloned().collect();
        // The first of several values of an encoding counts.
        accepted.insert(HeaderValue::from_static("identity;q=0.001"));
        values.into_iter().for_each(|value| accepted.append(value));
    }
    next.run(request).await
}

fn panicked(payload: Box<dyn std::any::Any + Send>) -> Response {
    let text = payload.downcast_ref::<&str>().map(|text| (*text).to_owned());
    let text = text.or_else(|| payload.downcast_ref::<String>().cloned());
    let text = text.unwrap_or_else(|| "a panic without a message".to_owned());
    ApiError::internal(format!("a handler panicked: {text}")).into_response()
}
