//! Query check: operations without query parameters refuse a query. Those with parameters parse it
//! strictly.

use std::collections::HashSet;
use std::sync::Arc;

use axum::extract::{MatchedPath, Request, State};
use axum::middleware::Next;
use axum::response::Response;
use http::Method;
use utoipa::openapi::path::{Operation, ParameterIn};
use utoipa::openapi::{OpenApi, RefOr};

use crate::problem::ApiError;

/// Operations with query parameters, by path and method.
pub struct QueryRoutes(HashSet<(String, Method)>);

impl QueryRoutes {
    /// Returns the operations that document query parameters.
    pub fn of(openapi: &OpenApi) -> Arc<Self> {
        let has_query = |operation: &Operation| {
            let mut parameters = operation.parameters.iter().flatten();
            parameters.any(|parameter| match parameter {
                RefOr::T(parameter) => parameter.parameter_in == ParameterIn::Query,
                RefOr::Ref(_) => false,
            })
        };
        let mut found = HashSet::new();
        for (path, item) in &openapi.paths.paths {
            let operations = [
                (Method::GET, &item.get),
                (Method::POST, &item.post),
                (Method::PATCH, &item.patch),
                (Method::PUT, &item.put),
                (Method::DELETE, &item.delete),
            ];
            for (method, operation) in operations {
                if operation.as_ref().is_some_and(has_query) {
                    found.insert((path.clone(), method));
                }
            }
        }
        Arc::new(Self(found))
    }
}

/// Passes requests without a query, and those of operations with query parameters. Probes such as
/// `/healthz`, outside `/v1`, ignore a query.
///
/// # Errors
/// 400 for other requests.
pub async fn check(
    State(routes): State<Arc<QueryRoutes>>,
    path: MatchedPath,
    request: Request,
    next: Next,
) -> Result<Response, ApiError> {
    let has_query = request.uri().query().is_some_and(|query| !query.is_empty());
    if has_query && path.as_str().starts_with("/v1/") {
        let method = match request.method() {
            &Method::HEAD => Method::GET,
            method => method.clone(),
        };
        if !routes.0.contains(&(path.as_str().to_owned(), method)) {
            return Err(ApiError::bad_request("this address takes no query parameters"));
        }
    }
    Ok(next.run(request).await)
}
