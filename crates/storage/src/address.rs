//! Addresses of PostgreSQL databases.

use std::fmt;
use std::str::FromStr;

/// Address of a PostgreSQL database, `postgres://USER:PASSWORD@HOST:PORT/DATABASE`. A socket is
/// `postgres://USER@%2Fvar%2Frun%2Fpostgresql/DATABASE`. What is missing comes from the environment
/// (`PGHOST`, `PGPASSFILE` and so on). Printing it leaves the password out.
#[derive(Clone, PartialEq, Eq)]
pub struct DatabaseAddress(String);

/// Error of parsing a [`DatabaseAddress`]. It does not repeat the text, which may have a password.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the address of a database must begin with postgres://")]
pub struct InvalidDatabaseAddress;

impl DatabaseAddress {
    /// Returns the address with its password.
    pub(crate) fn as_str(&self) -> &str {
        &self.0
    }
}

impl FromStr for DatabaseAddress {
    type Err = InvalidDatabaseAddress;

    fn from_str(text: &str) -> Result<Self, InvalidDatabaseAddress> {
        let known = ["postgres://", "postgresql://"].iter().any(|start| text.starts_with(start));
        if known { Ok(Self(text.to_owned())) } else { Err(InvalidDatabaseAddress) }
    }
}

impl fmt::Display for DatabaseAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Parameters after `?` may have a password, too.
        let shown = self.0.split('?').next().unwrap_or_default();
        let (scheme, rest) = shown.split_once("://").unwrap_or(("postgres", shown));
        let (user, place) = rest.rsplit_once('@').unwrap_or(("", rest));
        match user.split(':').next().unwrap_or_default() {
            "" => write!(f, "{scheme}://{place}"),
            name => write!(f, "{scheme}://{name}@{place}"),
        }
    }
}

impl fmt::Debug for DatabaseAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn password_is_not_printed() {
        for (text, shown) in [
            ("postgres://anna:secret@db:5433/brood", "postgres://anna@db:5433/brood"),
            ("postgres://anna:p@ss@db/brood?password=x", "postgres://anna@db/brood"),
            ("postgresql:///brood", "postgresql:///brood"),
        ] {
            let address: DatabaseAddress = text.parse().unwrap();
            assert_eq!((address.to_string(), format!("{address:?}")), (shown.into(), shown.into()));
        }
        let error = "mysql://anna:secret@db".parse::<DatabaseAddress>().unwrap_err();
        assert!(!error.to_string().contains("secret"));
    }
}
