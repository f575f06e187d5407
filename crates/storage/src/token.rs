//! Tokens by the hash of their secret. Owns the table `token` and what scopes allow; refuses to see a secret.

use sqlx::sqlite::SqliteRow;

use crate::error::taken;
use crate::row::{Columns, damaged};
use crate::{StorageError, Store};

/// What a token is good for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Scope {
    /// Looking.
    Read,
    /// Looking and breeding.
    Breed,
    /// Taking leases and handing results in, and nothing else.
    Work,
    /// Everything.
    Admin,
}

impl Scope {
    /// Whether a token of this scope opens what needs the other: `read` < `breed` < `admin`, and `work` apart from
    /// both.
    #[must_use]
    pub fn allows(self, needed: Self) -> bool {
        match self {
            Self::Admin => true,
            Self::Breed => matches!(needed, Self::Read | Self::Breed),
            Self::Read | Self::Work => self == needed,
        }
    }

    /// The word on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Read => "read",
            Self::Breed => "breed",
            Self::Work => "work",
            Self::Admin => "admin",
        }
    }
}

impl std::fmt::Display for Scope {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

impl std::str::FromStr for Scope {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        [Self::Read, Self::Breed, Self::Work, Self::Admin]
            .into_iter()
            .find(|scope| scope.name() == text)
            .ok_or_else(|| "a scope is read, breed, work or admin".to_owned())
    }
}

/// A token without its secret.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Token {
    /// Its name.
    pub name: String,
    /// What it is good for.
    pub scope: Scope,
    /// When it ends, milliseconds since 1970.
    pub expires_ms: Option<i64>,
}

impl Store {
    /// Stores a token; a name that is taken: [`StorageError::Conflict`].
    pub async fn create_token(
        &self,
        name: &str,
        scope: Scope,
        hash: [u8; 32],
        expires_ms: Option<i64>,
    ) -> Result<(), StorageError> {
        let name = name.to_owned();
        self.write(move |conn| {
            Box::pin(async move {
                sqlx::query(
                    "INSERT INTO token (name, scope, hash, expires_ms) VALUES (?, ?, ?, ?)",
                )
                .bind(name)
                .bind(scope.name())
                .bind(hash.as_slice())
                .bind(expires_ms)
                .execute(conn)
                .await
                .map_err(taken("the name of the token"))?;
                Ok(())
            })
        })
        .await
    }

    /// All tokens by name, expired ones too.
    pub async fn list_tokens(&self) -> Result<Vec<Token>, StorageError> {
        let query = sqlx::query("SELECT name, scope, expires_ms FROM token ORDER BY name");
        let rows = query.fetch_all(&mut *self.reader().await?).await?;
        rows.iter().map(read).collect()
    }

    /// Removes a token.
    pub async fn revoke_token(&self, name: &str) -> Result<(), StorageError> {
        let name = name.to_owned();
        self.write(move |conn| {
            Box::pin(async move {
                let query = sqlx::query("DELETE FROM token WHERE name = ?").bind(name);
                match query.execute(conn).await?.rows_affected() {
                    0 => Err(StorageError::NotFound),
                    _ => Ok(()),
                }
            })
        })
        .await
    }

    /// The token with that hash; the caller, who has a clock, looks whether it has expired.
    pub async fn token_by_hash(&self, hash: [u8; 32]) -> Result<Option<Token>, StorageError> {
        let query = sqlx::query("SELECT name, scope, expires_ms FROM token WHERE hash = ?");
        let row = query.bind(hash.as_slice()).fetch_optional(&mut *self.reader().await?).await?;
        row.as_ref().map(read).transpose()
    }

    /// Whether there is a token at all, expired or not.
    pub async fn any_token(&self) -> Result<bool, StorageError> {
        let query = sqlx::query_scalar("SELECT EXISTS (SELECT 1 FROM token)");
        Ok(query.fetch_one(&mut *self.reader().await?).await?)
    }
}

fn read(row: &SqliteRow) -> Result<Token, StorageError> {
    Ok(Token {
        name: row.text("name")?,
        scope: row.text("scope")?.parse().map_err(|_| damaged("scope"))?,
        expires_ms: sqlx::Row::try_get(row, "expires_ms")?,
    })
}
