//! Who may do what: tokens, their scopes, and the open door of a server that only this machine can reach.

use std::sync::Mutex;
use std::time::{Duration, Instant};

use brood_storage::{Scope, Store};
use moka::sync::Cache;

use crate::error::ServerError;
use crate::problem::ApiError;

/// Tokens made or revoked by another process are noticed after this time.
const REMEMBER: Duration = Duration::from_millis(500);

/// What a request needs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Need {
    /// Nothing: the page, the documentation, the health checks, the session.
    Nothing,
    /// At least `read`.
    Read,
    /// At least `breed`.
    Breed,
    /// `admin`.
    Admin,
    /// `work`.
    Work,
}

/// Checks tokens.
pub struct Access {
    loopback: bool,
    worker_token: String,
    worker_hash: blake3::Hash,
    any: Mutex<Option<(Instant, bool)>>,
    scopes: Cache<[u8; 32], Option<Scope>>,
}

impl Access {
    /// For a server that listens on loopback or not; makes the token of its own workers.
    pub fn new(loopback: bool) -> Result<Self, ServerError> {
        let mut secret = [0; 32];
        getrandom::fill(&mut secret).map_err(|_| ServerError::Random)?;
        let worker_token = blake3::Hash::from_bytes(secret).to_hex().to_string();
        Ok(Self {
            loopback,
            worker_hash: blake3::hash(worker_token.as_bytes()),
            worker_token,
            any: Mutex::new(None),
            scopes: Cache::builder().max_capacity(1024).time_to_live(REMEMBER).build(),
        })
    }

    /// The token of the server's own workers; it dies with the process.
    pub fn worker_token(&self) -> &str {
        &self.worker_token
    }

    /// Refuses a request that needs more than it brings.
    pub async fn check(
        &self,
        store: &Store,
        need: Need,
        token: Option<&str>,
    ) -> Result<(), ApiError> {
        if need == Need::Nothing {
            return Ok(());
        }
        if need != Need::Work && self.loopback && !self.any_token(store).await? {
            return Ok(());
        }
        let token = token.ok_or_else(|| {
            ApiError::unauthorized("send a token as Authorization: Bearer, or sign in on the page")
        })?;
        let scope = self.scope(store, token).await?;
        let scope = scope.ok_or_else(|| {
            ApiError::unauthorized("this token is not known here, or has been revoked")
        })?;
        let needed = match need {
            Need::Nothing | Need::Read => Scope::Read,
            Need::Breed => Scope::Breed,
            Need::Admin => Scope::Admin,
            Need::Work => Scope::Work,
        };
        if scope.allows(needed) { Ok(()) } else { Err(ApiError::forbidden(refusal(need))) }
    }

    /// The scope of a token; `None` where there is no such token, or no longer.
    pub async fn scope(&self, store: &Store, token: &str) -> Result<Option<Scope>, ApiError> {
        let hash = blake3::hash(token.as_bytes());
        if hash == self.worker_hash {
            return Ok(Some(Scope::Work));
        }
        let hash = *hash.as_bytes();
        if let Some(known) = self.scopes.get(&hash) {
            return Ok(known);
        }
        let token = store.token_by_hash(hash).await?;
        let now = crate::state::now_ms();
        let valid = token.filter(|token| token.expires_ms.is_none_or(|expires| expires > now));
        let scope = valid.map(|token| token.scope);
        self.scopes.insert(hash, scope);
        Ok(scope)
    }

    async fn any_token(&self, store: &Store) -> Result<bool, ApiError> {
        let known = *self.any.lock().expect("nothing panics under this lock");
        if let Some((when, any)) = known
            && when.elapsed() < REMEMBER
        {
            return Ok(any);
        }
        let any = store.any_token().await?;
        *self.any.lock().expect("nothing panics under this lock") = Some((Instant::now(), any));
        Ok(any)
    }
}

fn refusal(need: Need) -> &'static str {
    match need {
        Need::Nothing | Need::Read => "this needs a token of scope read, breed or admin",
        Need::Breed => "this needs a token of scope breed or admin",
        Need::Admin => "this needs a token of scope admin",
        Need::Work => "leases need a token of scope work or admin",
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
