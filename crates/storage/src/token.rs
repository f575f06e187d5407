//! Access tokens, identified by the hash of their secret. Owner of the tables `token` and `closed`
//! and of the scopes' permissions. Secrets never reach this module.

use crate::column::columns;
use crate::error::{Result, changed, unique_conflict};
use crate::row::{Record, record, select};
use crate::sql::{Conn, query};
use crate::write::operation;
use crate::{StorageError, Store};

brood_genome::named_enum! {
    /// Permissions of a token.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub enum Scope {
        /// Read only.
        Read => "read",
        /// Read and breed.
        Breed => "breed",
        /// Lease jobs and submit results, nothing else.
        Work => "work",
        /// Everything.
        Admin => "admin",
    }
}

impl Scope {
    /// True if a token of this scope may do what requires `needed`: `read` < `breed` < `admin`,
    /// with `work` separate from `read` and `breed`.
    #[must_use]
    pub fn allows(self, needed: Self) -> bool {
        match self {
            Self::Admin => true,
            Self::Breed => matches!(needed, Self::Read | Self::Breed),
            Self::Read | Self::Work => self == needed,
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
        Self::from_name(text)
            .ok_or_else(|| "the scope must be read, breed, work or admin".to_owned())
    }
}

columns! {
    String => Scope: |name| Self::from_name(&name);
}

record! {
    /// Token without its secret.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct Token {
        /// Name of the token.
        pub name: String,
        /// Scope of the token.
        pub scope: Scope,
        /// Expiry time, in milliseconds since 1970-01-01 UTC; `None` for no expiry.
        pub expires_ms: Option<i64>,
    }
}

impl Store {
    /// Stores a token.
    ///
    /// # Errors
    /// Returns [`StorageError::Conflict`] if the name is in use.
    pub async fn create_token(
        &self,
        name: &str,
        scope: Scope,
        hash: [u8; 32],
        expires_ms: Option<i64>,
    ) -> Result<()> {
        let name = name.to_owned();
        self.write(operation!(|conn| {
            query("INSERT INTO token (name, scope, hash, expires_ms) VALUES (?, ?, ?, ?)")
                .bind(name)
                .bind(scope.name())
                .bind(hash.as_slice())
                .bind(expires_ms)
                .execute(conn)
                .await
                .map_err(unique_conflict("a token with this name already exists"))?;
            Ok(())
        }))
        .await
    }

    /// Lists all tokens by name, including expired ones.
    ///
    /// # Errors
    /// Returns a [`StorageError`] if the read fails.
    pub async fn list_tokens(&self) -> Result<Vec<Token>> {
        let query = select::<Token>("FROM token ORDER BY name");
        query.fetch_all(&mut self.reader().await?).await?.iter().map(Token::read).collect()
    }

    /// Deletes a token; true if it was the last one. Access stays closed then: see
    /// [`Store::needs_token`].
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`] if there is no token with this name.
    pub async fn revoke_token(&self, name: &str, now_ms: i64) -> Result<bool> {
        let name = name.to_owned();
        self.write(operation!(|conn| {
            lock(conn).await?;
            let delete = query("DELETE FROM token WHERE name = ?").bind(name);
            changed(delete.execute(conn).await?, StorageError::NotFound)?;
            let close =
                "INSERT INTO closed (at_ms) SELECT ? WHERE NOT EXISTS (SELECT 1 FROM token)";
            Ok(query(close).bind(now_ms).execute(conn).await? > 0)
        }))
        .await
    }

    /// Opens access again that was closed with the last token.
    ///
    /// # Errors
    /// Returns [`StorageError::Conflict`] if there is a token.
    pub async fn open_access(&self) -> Result<()> {
        self.write(operation!(|conn| {
            lock(conn).await?;
            let any = query("SELECT EXISTS (SELECT 1 FROM token)");
            if any.fetch_value(conn).await? {
                return Err(StorageError::Conflict { what: "there are tokens" });
            }
            query("DELETE FROM closed").execute(conn).await?;
            Ok(())
        }))
        .await
    }

    /// True if requests need a token: there is one, or the last one was revoked.
    ///
    /// # Errors
    /// Returns a [`StorageError`] if the read fails.
    pub async fn needs_token(&self) -> Result<bool> {
        let sql = "SELECT EXISTS (SELECT 1 FROM token) OR EXISTS (SELECT 1 FROM closed)";
        query(sql).fetch_value(&mut self.reader().await?).await
    }

    /// Returns the token with this hash, or `None`. The caller checks if it has expired.
    ///
    /// # Errors
    /// Returns a [`StorageError`] if the read fails.
    pub async fn token_by_hash(&self, hash: [u8; 32]) -> Result<Option<Token>> {
        let query = select::<Token>("FROM token WHERE hash = ?").bind(hash.as_slice());
        let row = query.fetch_optional(&mut self.reader().await?).await?;
        row.as_ref().map(Token::read).transpose()
    }

    /// True if there is any token, expired or not.
    ///
    /// # Errors
    /// Returns a [`StorageError`] if the read fails.
    pub async fn any_token(&self) -> Result<bool> {
        let query = query("SELECT EXISTS (SELECT 1 FROM token)");
        query.fetch_value(&mut self.reader().await?).await
    }
}

/// Lets no other transaction change the tokens: of two that revoke the last two tokens at the same
/// time, each would find the other's token.
async fn lock(conn: &mut Conn) -> Result<()> {
    if conn.has_other_writers() {
        query("LOCK TABLE token IN SHARE ROW EXCLUSIVE MODE").execute(conn).await?;
    }
    Ok(())
}
