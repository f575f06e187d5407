//! Access control: tokens, their scopes, and unauthenticated access on a loopback address.

use std::time::Duration;

use brood_protocol::random_token;
use brood_storage::{Scope, Store};
use http::StatusCode;
use moka::future::Cache;

use crate::error::ServerError;
use crate::problem::ApiError;

/// Lifetime of a cached token check: a token added or revoked by another process takes effect after
/// this time.
const TOKEN_TTL: Duration = Duration::from_millis(500);
/// Time for which the token of a worker remains valid after its last check if the database does not
/// answer. So workers continue to render and to renew leases of pictures, without the database.
const KNOWN_TTL: Duration = Duration::from_secs(60);
/// Time for the database to answer about the known token of a worker. Leases last 2 s or more.
const KNOWN_WAIT: Duration = Duration::from_millis(250);

/// Access that a request needs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Need {
    /// No token: the page, the documentation, the health checks, the session.
    Nothing,
    /// Scope `read`, `breed` or `admin`.
    Read,
    /// Scope `breed` or `admin`.
    Breed,
    /// Scope `admin`.
    Admin,
    /// Scope `work` or `admin`.
    Work,
}

/// Token checker with a short-lived cache of scopes.
pub struct Access {
    loopback: bool,
    worker_token: String,
    worker_hash: blake3::Hash,
    needs_token: Cache<(), bool>,
    scopes: Cache<[u8; 32], Option<Scope>>,
    /// Valid tokens of workers, by their hashes, with their scopes.
    known: Cache<[u8; 32], Scope>,
}

impl Access {
    /// Creates the checker, and the token of the server's own workers.
    ///
    /// On loopback, requests need no token until the first one is added. They still need one after
    /// the last is revoked.
    ///
    /// # Errors
    /// [`ServerError::Random`] if the system has no random bytes.
    pub fn new(loopback: bool) -> Result<Self, ServerError> {
        let worker_token = random_token().map_err(|_| ServerError::Random)?;
        Ok(Self {
            loopback,
            worker_hash: blake3::hash(worker_token.as_bytes()),
            worker_token,
            needs_token: Cache::builder().max_capacity(1).time_to_live(TOKEN_TTL).build(),
            scopes: Cache::builder().max_capacity(1024).time_to_live(TOKEN_TTL).build(),
            known: Cache::builder().max_capacity(1024).time_to_live(KNOWN_TTL).build(),
        })
    }

    /// Returns the token of the server's own workers, valid until the process ends.
    pub fn worker_token(&self) -> &str {
        &self.worker_token
    }

    /// True for the token of the server's own workers.
    pub fn is_own_worker(&self, token: &str) -> bool {
        blake3::hash(token.as_bytes()) == self.worker_hash
    }

    /// Checks that a request has the access it needs.
    ///
    /// # Errors
    /// 401 if a token is needed and missing, unknown or expired; 403 if its scope is too small.
    pub async fn check(
        &self,
        store: &Store,
        need: Need,
        token: Option<&str>,
    ) -> Result<(), ApiError> {
        if need == Need::Nothing {
            return Ok(());
        }
        if need != Need::Work && self.loopback && !self.needs_token(store).await? {
            return Ok(());
        }
        let token = token.ok_or_else(|| {
            ApiError::unauthorized(
                "send a token as `Authorization: Bearer TOKEN`, or sign in on the page",
            )
        })?;
        let scope = match need {
            Need::Work => self.scope_of_worker(store, token).await?,
            _ => self.scope(store, token).await?,
        };
        let scope = scope
            .ok_or_else(|| ApiError::unauthorized("the token is unknown, expired or revoked"))?;
        let needed = match need {
            Need::Nothing | Need::Read => Scope::Read,
            Need::Breed => Scope::Breed,
            Need::Admin => Scope::Admin,
            Need::Work => Scope::Work,
        };
        if scope.allows(needed) { Ok(()) } else { Err(ApiError::forbidden(refusal(need))) }
    }

    /// Returns the scope of a token; `None` if it is unknown, expired or revoked.
    ///
    /// # Errors
    /// [`ApiError`] if the store cannot be read.
    pub async fn scope(&self, store: &Store, token: &str) -> Result<Option<Scope>, ApiError> {
        let hash = blake3::hash(token.as_bytes());
        if hash == self.worker_hash {
            return Ok(Some(Scope::Work));
        }
        let hash = *hash.as_bytes();
        let read = async {
            let token = store.token_by_hash(hash).await?;
            let now = crate::clock::now_ms();
            let valid = token.filter(|token| token.expires_ms.is_none_or(|expires| expires > now));
            Ok::<_, ApiError>(valid.map(|token| token.scope))
        };
        Ok(self.scopes.try_get_with(hash, read).await?)
    }

    /// Returns the scope of a worker's token; the last known one while the database does not
    /// answer.
    async fn scope_of_worker(&self, store: &Store, token: &str) -> Result<Option<Scope>, ApiError> {
        let hash = *blake3::hash(token.as_bytes()).as_bytes();
        let read = self.scope(store, token);
        let found = match self.known.get(&hash).await {
            None => read.await?,
            Some(known) => match tokio::time::timeout(KNOWN_WAIT, read).await {
                Err(_) => return Ok(Some(known)),
                Ok(Err(error)) if error.status() == StatusCode::SERVICE_UNAVAILABLE => {
                    return Ok(Some(known));
                }
                Ok(found) => found?,
            },
        };
        match found {
            Some(scope) => self.known.insert(hash, scope).await,
            None => self.known.invalidate(&hash).await,
        }
        Ok(found)
    }

    async fn needs_token(&self, store: &Store) -> Result<bool, ApiError> {
        let read = async { Ok::<_, ApiError>(store.needs_token().await?) };
        Ok(self.needs_token.try_get_with((), read).await?)
    }
}

fn refusal(need: Need) -> &'static str {
    match need {
        Need::Nothing | Need::Read => "a token with scope `read`, `breed` or `admin` is required",
        Need::Breed => "a token with scope `breed` or `admin` is required",
        Need::Admin => "a token with scope `admin` is required",
        Need::Work => "leases require a token with scope `work` or `admin`",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn worker_tokens_differ_between_servers() {
        let (a, b) = (Access::new(true).unwrap(), Access::new(true).unwrap());
        assert_ne!(a.worker_token(), b.worker_token());
        assert_eq!(a.worker_token().len(), 64);
    }
}
