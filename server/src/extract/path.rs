//! Path parameters: ids and names.

use axum::extract::FromRequestParts;
use http::request::Parts;
use serde::de::DeserializeOwned;

use super::NUL;
use crate::problem::ApiError;

/// Parameters of the route. A malformed id is 404, as it names nothing; so is one with U+0000,
/// which PostgreSQL refuses.
#[derive(Debug, Clone)]
pub struct Path<T>(pub T);

impl<T: DeserializeOwned + Send, S: Send + Sync> FromRequestParts<S> for Path<T> {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, ApiError> {
        let malformed = || ApiError::not_found("the address has a malformed id");
        if parts.uri.path().contains(NUL) {
            return Err(malformed());
        }
        let path = axum::extract::Path::<T>::from_request_parts(parts, state).await;
        path.map(|path| Self(path.0)).map_err(|_| malformed())
    }
}
