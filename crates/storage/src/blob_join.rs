//! The one object store of a database: remembered at its first use, and the same for all servers.

use std::collections::HashSet;

use crate::blob_address::BlobAddress;
use crate::blob_store::Blobs;
use crate::engine::postgres::lock_of;
use crate::error::Result;
use crate::sql::{Conn, query};
use crate::write::operation;
use crate::{StorageError, Store};

/// Schema whose servers read files from an object store.
const SCHEMA: i64 = 4;
/// Tables with files that may be in the object store.
pub(crate) const TABLES: [&str; 4] = ["light_asset", "mesh", "search_checkpoint", "target_file"];

/// User of the object store.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Joiner {
    /// Server, which decides on the store of the database.
    Server,
    /// Command that reads.
    Reader,
}

impl Store {
    /// Uses an object store for files over 1 MiB, which all servers of a database must have in
    /// common. Credentials and endpoint are variables of the environment: `AWS_ACCESS_KEY_ID`,
    /// `AWS_ENDPOINT` and so on. At the first use, writes an object and removes it.
    ///
    /// # Errors
    /// Returns [`StorageError::Unsupported`] on SQLite, or if the database has files in another
    /// store, [`StorageError::BlobsUnreachable`] if an object cannot be written at the first use.
    pub async fn with_blobs(self, address: Option<&BlobAddress>) -> Result<Self> {
        self.join(address, environment(), Joiner::Server).await
    }

    /// As [`Store::with_blobs`], for a command that only reads.
    ///
    /// # Errors
    /// Returns [`StorageError::Unsupported`] if the database has another object store.
    pub async fn with_blobs_to_read(self, address: Option<&BlobAddress>) -> Result<Self> {
        self.join(address, environment(), Joiner::Reader).await
    }

    /// As [`Store::with_blobs`], with these variables instead of the environment.
    #[cfg(test)]
    pub(crate) async fn with_blobs_at(
        self,
        address: Option<&BlobAddress>,
        variables: Vec<(String, String)>,
    ) -> Result<Self> {
        self.join(address, variables, Joiner::Server).await
    }

    async fn join(
        mut self,
        address: Option<&BlobAddress>,
        variables: Vec<(String, String)>,
        joiner: Joiner,
    ) -> Result<Self> {
        match find(&self, address, &variables, joiner).await {
            Ok(blobs) => {
                self.set_blobs(blobs);
                Ok(self)
            }
            Err(error) => {
                self.close().await?;
                Err(error)
            }
        }
    }
}

fn environment() -> Vec<(String, String)> {
    let text = |(name, value): (std::ffi::OsString, std::ffi::OsString)| {
        Some((name.into_string().ok()?, value.into_string().ok()?))
    };
    std::env::vars_os().filter_map(text).collect()
}

/// Returns the object store of a database. Remembers its address if it is new.
async fn find(
    store: &Store,
    address: Option<&BlobAddress>,
    variables: &[(String, String)],
    joiner: Joiner,
) -> Result<Option<Blobs>> {
    if !store.is_shared() {
        return match address {
            None => Ok(None),
            Some(_) => Err(StorageError::Unsupported(
                "files are kept in an object store only beside a PostgreSQL database (--database)"
                    .to_owned(),
            )),
        };
    }
    let mut conn = store.reader().await?;
    let known = query("SELECT address FROM blob_store").fetch_optional(&mut conn).await?;
    let known = known.map(|row| row.column::<String>("address")).transpose()?;
    let Some(address) = address else {
        return match known {
            Some(known) if joiner == Joiner::Server && is_used(&mut conn).await? => {
                Err(other_store(&known))
            }
            _ => Ok(None),
        };
    };
    drop(conn);
    let blobs = Blobs::open(address, variables)?;
    let text = address.to_string();
    match (known, joiner) {
        (Some(known), _) if known == text => {}
        (Some(known), Joiner::Reader) => return Err(other_store(&known)),
        (None, Joiner::Reader) => {}
        (_, Joiner::Server) => {
            blobs.probe().await?;
            let found = blobs.owner().await?;
            let is_new = found.is_none();
            let owner = remember(store, text.clone(), found).await?;
            if is_new && blobs.claim(&owner).await?.as_ref() != Some(&owner) {
                return Err(StorageError::Unsupported(other_owner(&text)));
            }
        }
    }
    Ok(Some(blobs))
}

/// Makes a store that of the database, unless rows have files in another or the folder has another
/// owner. Returns the name of the database as an owner.
async fn remember(store: &Store, address: String, found: Option<String>) -> Result<String> {
    store
        .write(operation!(|conn| {
            let insert = "INSERT INTO blob_store (id, address, owner) VALUES (1, ?, ?)
                 ON CONFLICT DO NOTHING";
            let name = uuid::Uuid::now_v7().to_string();
            query(insert).bind(address.as_str()).bind(name).execute(conn).await?;
            // Writes of rows that have an object share this lock.
            let known = "SELECT address, owner FROM blob_store WHERE id = 1 /*pg: FOR UPDATE*/";
            let row = query(known).fetch_one(conn).await?;
            let (known, owner): (String, String) = (row.column("address")?, row.column("owner")?);
            if found.is_some_and(|found| found != owner) {
                return Err(StorageError::Unsupported(other_owner(&address)));
            }
            if known != address {
                if is_used(conn).await? {
                    return Err(other_store(&known));
                }
                let update = query("UPDATE blob_store SET address = ? WHERE id = 1");
                update.bind(address).execute(conn).await?;
            }
            exclude_earlier(conn).await?;
            Ok(owner)
        }))
        .await
}

/// Excludes servers of earlier schemas, which cannot read rows with an object.
///
/// # Errors
/// Returns [`StorageError::Unsupported`] if one runs.
async fn exclude_earlier(conn: &mut Conn) -> Result<()> {
    let exclude = "UPDATE _brood_step SET oldest = ?1 WHERE version = ?1 AND oldest < ?1";
    if query(exclude).bind(SCHEMA).execute(conn).await? == 0 {
        return Ok(());
    }
    // Free until the end of the transaction. Servers share it.
    let lock = "SELECT pg_try_advisory_xact_lock(hashtext(?), hashtext(current_schema()))";
    if query(lock).bind(lock_of(SCHEMA - 1)).fetch_value(conn).await? {
        return Ok(());
    }
    Err(StorageError::Unsupported(
        "servers of an earlier version of brood use the database, which cannot read files of an \
         object store; upgrade them first"
            .to_owned(),
    ))
}

/// Checks once for a process that the folder belongs to the database, before an object is stored
/// there: a store at another endpoint may have the same address.
///
/// # Errors
/// As [`assert_owner`].
pub(crate) async fn confirm_owner(store: &Store, blobs: &Blobs) -> Result<()> {
    blobs.confirmed.get_or_try_init(|| assert_owner(store, blobs)).await.copied()
}

/// Checks that the folder of a store belongs to the database, so that objects may be stored there,
/// and those without a row removed.
///
/// # Errors
/// Returns [`StorageError::BlobsUnreachable`] if it belongs to another database or to none, if this
/// database has another store now, or if the store does not answer.
pub(crate) async fn assert_owner(store: &Store, blobs: &Blobs) -> Result<()> {
    let address = blobs.address().to_string();
    let mut conn = store.reader().await?;
    let own = query("SELECT owner FROM blob_store WHERE address = ?").bind(address.as_str());
    let own = own.fetch_optional(&mut conn).await?;
    let own = own.map(|row| row.column::<String>("owner")).transpose()?;
    let Some(own) = own else {
        return Err(blobs.unreachable("the database has another store now; restart this server"));
    };
    let is_used = is_used(&mut conn).await?;
    drop(conn);
    let found = match blobs.owner().await? {
        // The first server ended before it had written it.
        None if !is_used => blobs.claim(&own).await?,
        found => found,
    };
    match found {
        Some(found) if found == own => Ok(()),
        Some(_) => Err(blobs.unreachable(other_owner(&address))),
        None => Err(blobs.unreachable(
            "it has no object `owner` of this database; is AWS_ENDPOINT the one of other servers?",
        )),
    }
}

/// True if a row has a file in the object store.
async fn is_used(conn: &mut Conn) -> Result<bool> {
    for table in TABLES {
        let sql = format!("SELECT EXISTS (SELECT 1 FROM {table} WHERE object IS NOT NULL)");
        if query(sql).fetch_value(conn).await? {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Returns the names of all objects that rows have, from one name to another.
pub(crate) async fn used_objects(
    conn: &mut Conn,
    (first, last): (&str, &str),
) -> Result<HashSet<String>> {
    let mut used = HashSet::new();
    for table in TABLES {
        let sql = format!(
            "SELECT object FROM {table}
             WHERE object IS NOT NULL AND object /*pg: COLLATE \"C\"*/ BETWEEN ?1 AND ?2"
        );
        for row in query(sql).bind(first).bind(last).fetch_all(conn).await? {
            used.insert(row.column("object")?);
        }
    }
    Ok(used)
}

fn other_owner(address: &str) -> String {
    format!("the object store {address} belongs to another database; name another folder")
}

fn other_store(known: &str) -> StorageError {
    StorageError::Unsupported(format!(
        "files of the database are in the object store {known}; start this with --blobs {known}"
    ))
}
