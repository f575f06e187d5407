//! Idempotency keys: a repeated request gets the first answer and has no second effect.

use std::collections::HashSet;
use std::sync::{Arc, Mutex};

use axum::extract::FromRequestParts;
use brood_storage::{Idempotency, IdempotencyLookup, Store};
use http::request::Parts;
use http::{HeaderName, StatusCode};
use serde::Serialize;
use serde_json::Value;
use utoipa::IntoParams;
use utoipa::openapi::path::{Parameter, ParameterBuilder, ParameterIn};
use utoipa::openapi::schema::Type;
use utoipa::openapi::{ObjectBuilder, Required};

use crate::clock::now_ms;
use crate::problem::ApiError;

const HEADER: HeaderName = HeaderName::from_static("idempotency-key");
const KEY_BYTES: usize = 255;

/// Key of a request, if any, with its method and path.
#[derive(Debug, Clone)]
pub struct IdempotencyKey {
    key: Option<String>,
    route: String,
}

impl IntoParams for IdempotencyKey {
    fn into_params(_: impl Fn() -> Option<ParameterIn>) -> Vec<Parameter> {
        let words =
            "Key chosen by the client: a request that is sent again with its key is executed once";
        let schema = ObjectBuilder::new()
            .schema_type(Type::String)
            .min_length(Some(1))
            .max_length(Some(KEY_BYTES))
            .pattern(Some("^[ -~]+$"));
        let parameter = ParameterBuilder::new()
            .name("Idempotency-Key")
            .parameter_in(ParameterIn::Header)
            .required(Required::False)
            .description(Some(words))
            .schema(Some(schema));
        vec![parameter.build()]
    }
}

impl<S: Send + Sync> FromRequestParts<S> for IdempotencyKey {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, ApiError> {
        let malformed = || {
            let words =
                format!("Idempotency-Key must be 1 to {KEY_BYTES} printable ASCII characters");
            ApiError::bad_request(words)
        };
        let mut values = parts.headers.get_all(HEADER).iter();
        let key = match (values.next(), values.next()) {
            (None, _) => None,
            (Some(value), None) => {
                let text = value.to_str().map_err(|_| malformed())?;
                let fits = (1..=KEY_BYTES).contains(&text.len()) && !text.contains('\t');
                Some(if fits { text.to_owned() } else { return Err(malformed()) })
            }
            (Some(_), Some(_)) => return Err(malformed()),
        };
        Ok(Self { key, route: format!("{} {}", parts.method, parts.uri.path()) })
    }
}

/// Hash of a request's body.
#[derive(Debug, Clone, Copy)]
pub struct BodyHash([u8; 32]);

impl BodyHash {
    /// Hashes a body.
    pub fn of(body: &[u8]) -> Self {
        Self(*blake3::hash(body).as_bytes())
    }
}

/// Keys whose first request is still running.
#[derive(Debug, Clone, Default)]
pub struct Ledger {
    running: Arc<Mutex<HashSet<(String, String)>>>,
}

/// State of a request's key.
#[derive(Debug)]
enum Begun {
    /// Already done; the stored answer.
    Replay(Value),
    /// Not done yet.
    Fresh(Attempt),
}

/// Request in progress; dropping it releases its key.
#[derive(Debug)]
pub struct Attempt {
    ledger: Ledger,
    key: Option<(String, String)>,
    body_hash: [u8; 32],
}

impl Ledger {
    /// Answers a request once: by `replay` if its key and the `hash` of its body were received
    /// before, else by `make`, which must store the record of the attempt. If that conflicts with
    /// the same request at another server, `replay` gets the answer of that one.
    ///
    /// # Errors
    /// 409 if the first request is still running, 422 if the key was used with another body, and
    /// those of `make` and `replay`.
    pub async fn once<T, Made, Replayed>(
        &self,
        store: &Store,
        (key, hash): (IdempotencyKey, BodyHash),
        make: impl FnOnce(Attempt) -> Made,
        replay: impl FnOnce(Value) -> Replayed,
    ) -> Result<T, ApiError>
    where
        Made: Future<Output = Result<T, ApiError>>,
        Replayed: Future<Output = Result<T, ApiError>>,
    {
        let attempt = match self.begin(store, &key, hash).await? {
            Begun::Replay(answer) => return replay(answer).await,
            Begun::Fresh(attempt) => attempt,
        };
        let error = match make(attempt).await {
            Err(error) if error.status() == StatusCode::CONFLICT && key.key.is_some() => error,
            made => return made,
        };
        match self.begin(store, &key, hash).await {
            Ok(Begun::Replay(answer)) => replay(answer).await,
            Err(other) if other.status() == StatusCode::UNPROCESSABLE_ENTITY => Err(other),
            _ => Err(error),
        }
    }

    /// Claims the key and looks up an earlier request with this key and body.
    async fn begin(
        &self,
        store: &Store,
        IdempotencyKey { key, route }: &IdempotencyKey,
        BodyHash(body_hash): BodyHash,
    ) -> Result<Begun, ApiError> {
        let Some(name) = key else {
            return Ok(Begun::Fresh(Attempt { ledger: self.clone(), key: None, body_hash }));
        };
        let attempt = self.claim((name.clone(), route.clone()), body_hash)?;
        match store.lookup_idempotent(name, route, body_hash).await? {
            IdempotencyLookup::Fresh => Ok(Begun::Fresh(attempt)),
            IdempotencyLookup::OtherBody => {
                Err(ApiError::refused("this Idempotency-Key was already used with another body"))
            }
            IdempotencyLookup::Replay { body, .. } => {
                let answer = serde_json::from_slice(&body).map_err(|error| {
                    ApiError::internal(format!("cannot decode a stored answer: {error}"))
                })?;
                Ok(Begun::Replay(answer))
            }
        }
    }

    /// Returns an attempt without a key, for changes that no client requested.
    pub fn unkeyed(&self) -> Attempt {
        Attempt { ledger: self.clone(), key: None, body_hash: [0; 32] }
    }

    fn claim(&self, key: (String, String), body_hash: [u8; 32]) -> Result<Attempt, ApiError> {
        let mut running = self.running.lock().expect("nothing panics under this lock");
        if !running.insert(key.clone()) {
            return Err(ApiError::running("retry in a moment"));
        }
        Ok(Attempt { ledger: self.clone(), key: Some(key), body_hash })
    }
}

impl Attempt {
    /// Returns the record to write in the same transaction as the request's effect.
    pub fn record<T: Serialize>(&self, status: StatusCode, answer: &T) -> Option<Idempotency> {
        let (key, route) = self.key.clone()?;
        let answer = serde_json::to_vec(answer).expect("answers are plain data");
        let status = status.as_u16();
        Some(Idempotency { key, route, body_hash: self.body_hash, status, answer })
    }

    /// Stores the record of a request whose effect may be repeated, after the effect.
    ///
    /// # Errors
    /// [`ApiError`] if the store fails.
    pub async fn store<T: Serialize>(
        &self,
        store: &Store,
        status: StatusCode,
        answer: &T,
    ) -> Result<(), ApiError> {
        match self.record(status, answer) {
            Some(record) => Ok(store.store_idempotency(record, now_ms()).await?),
            None => Ok(()),
        }
    }
}

impl Drop for Attempt {
    fn drop(&mut self) {
        if let Some(key) = &self.key {
            self.ledger.running.lock().expect("nothing panics under this lock").remove(key);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pair(key: &str) -> (String, String) {
        (key.to_owned(), "POST /v1/lineages".to_owned())
    }

    #[test]
    fn key_is_claimed_while_its_first_request_runs() {
        let ledger = Ledger::default();
        let first = ledger.claim(pair("a"), [0; 32]).unwrap();
        assert_eq!(ledger.claim(pair("a"), [0; 32]).unwrap_err().status(), 409);
        let _other = ledger.claim(pair("b"), [0; 32]).unwrap();
        drop(first);
        ledger.claim(pair("a"), [0; 32]).unwrap();
    }

    #[tokio::test]
    async fn key_is_refused_when_malformed() {
        for (value, good) in [("a", true), ("", false), (&"x".repeat(256), false), ("ä", false)] {
            let request = http::Request::post("/v1/lineages").header(HEADER, value);
            let (mut parts, ()) = request.body(()).unwrap().into_parts();
            let key = IdempotencyKey::from_request_parts(&mut parts, &()).await;
            assert_eq!(key.is_ok(), good, "{value}");
        }
    }
}
