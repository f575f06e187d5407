//! Addresses of PostgreSQL databases.

use std::fmt;

/// Address of a PostgreSQL database, `postgres://USER:PASSWORD@HOST:PORT/DATABASE`. A socket is
/// `postgres://USER@%2Fvar%2Frun%2Fpostgresql/DATABASE`. Missing parts come from the environment
/// (`PGHOST`, `PGPASSFILE` and so on). Any text is accepted here and checked when it is used, so
/// that no parser repeats it in an error. Printing it leaves the password out.
#[derive(Clone, PartialEq, Eq)]
pub struct DatabaseAddress {
    text: String,
    connections: u32,
}

/// Connections of a server for reads and writes, by default.
const CONNECTIONS: u32 = 24;

/// Parameters after `?`. sqlx would log the value of another one.
const PARAMETERS: [&str; 20] = [
    "sslmode",
    "ssl-mode",
    "sslrootcert",
    "ssl-root-cert",
    "ssl-ca",
    "sslcert",
    "ssl-cert",
    "sslkey",
    "ssl-key",
    "statement-cache-capacity",
    "host",
    "hostaddr",
    "port",
    "dbname",
    "user",
    "password",
    "application_name",
    "options",
    "options[search_path]",
    "options%5Bsearch_path%5D",
];

impl From<String> for DatabaseAddress {
    fn from(text: String) -> Self {
        Self { text, connections: CONNECTIONS }
    }
}

impl DatabaseAddress {
    /// Returns the address with its password.
    pub(crate) fn as_str(&self) -> &str {
        &self.text
    }

    /// Sets the number of connections of a server for reads and writes, 24 by default.
    #[must_use]
    pub fn with_connections(self, connections: u32) -> Self {
        Self { connections, ..self }
    }

    /// Number of connections of a server for reads and writes.
    pub(crate) fn connections(&self) -> u32 {
        self.connections
    }

    /// True if it begins as an address of PostgreSQL.
    pub(crate) fn is_of_postgres(&self) -> bool {
        ["postgres://", "postgresql://"].iter().any(|start| self.text.starts_with(start))
    }

    /// Returns the name of a parameter that is not known.
    pub(crate) fn unknown_parameter(&self) -> Option<&str> {
        let (_, parameters) = self.text.split_once('?')?;
        let names = parameters.split('&').map(|one| one.split('=').next().unwrap_or_default());
        names.into_iter().find(|name| !PARAMETERS.contains(name))
    }

    /// Returns user, host and database; `None` if it is unclear where the password is.
    fn shown(&self) -> Option<String> {
        let (scheme, rest) = self.text.split_once("://").filter(|_| self.is_of_postgres())?;
        let end = rest.find(['/', '?', '#']).unwrap_or(rest.len());
        let (authority, path) = rest.split_at(end);
        let path = path.split(['?', '#']).next().unwrap_or_default();
        if let Some((user, host)) = authority.rsplit_once('@') {
            let name = user.split(':').next().unwrap_or_default();
            return Some(format!("{scheme}://{name}@{host}{path}"));
        }
        // A sign that ends the host may stand in a password that was not escaped.
        let port = authority.split_once(':').map_or("", |(_, port)| port);
        let is_clear = !rest.contains('@') && port.bytes().all(|byte| byte.is_ascii_digit());
        is_clear.then(|| format!("{scheme}://{authority}{path}"))
    }
}

impl fmt::Display for DatabaseAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.shown().as_deref().unwrap_or("postgres://..."))
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
            ("postgres://db:5433/brood?password=a", "postgres://db:5433/brood"),
            ("postgres://db/brood?password=a@b", "postgres://..."),
            ("postgres://anna:secret?x@db/brood", "postgres://..."),
            ("postgres://anna:secret", "postgres://..."),
            ("mysql://anna:secret@db", "postgres://..."),
        ] {
            let address = DatabaseAddress::from(text.to_owned());
            assert_eq!((address.to_string(), format!("{address:?}")), (shown.into(), shown.into()));
        }
    }

    #[test]
    fn unknown_parameters_are_found() {
        for (text, unknown) in [
            ("postgres://db/brood", None),
            ("postgres://db/brood?sslmode=disable&options[search_path]=x", None),
            ("postgres://db/brood?sslpassword=secret", Some("sslpassword")),
        ] {
            assert_eq!(DatabaseAddress::from(text.to_owned()).unknown_parameter(), unknown);
        }
    }
}
