//! Lineages: create, list, change, hide. Owner of the table `lineage`. See `purge` for permanent
//! removal.

use std::fmt;
use std::str::FromStr;
use std::time::Duration;

use brood_protocol::{IndividualId, Lineage, LineageId, PatchLineage};

use crate::clock::steady_ms;
use crate::column::{Key, optional_key};
use crate::error::{Result, changed};
use crate::idempotency::{self, Idempotency};
use crate::lease;
use crate::row::{Record, key_set, record, select, signed};
use crate::sql::{Conn, query};
use crate::write::operation;
use crate::{StorageError, Store};

/// Time after the last slice of an import or a removal, after which another server removes the
/// lineage. A slice takes milliseconds, but may wait.
const UNFINISHED: Duration = Duration::from_secs(60);

/// Position in the list of lineages: after the lineage it names, even if that has been removed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LineageCursor {
    /// Creation time of the lineage, in milliseconds since 1970-01-01 UTC.
    pub created_ms: i64,
    /// Id of the lineage.
    pub id: LineageId,
}

/// Error of parsing a [`LineageCursor`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the cursor must be the `next` of an earlier page")]
pub struct InvalidCursor;

impl LineageCursor {
    /// Returns the position of a lineage.
    #[must_use]
    pub fn of(lineage: &Lineage) -> Self {
        Self { created_ms: lineage.created_ms, id: lineage.id }
    }
}

impl fmt::Display for LineageCursor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}", self.created_ms, self.id)
    }
}

impl FromStr for LineageCursor {
    type Err = InvalidCursor;

    fn from_str(text: &str) -> Result<Self, InvalidCursor> {
        let (created_ms, id) = text.split_once('.').ok_or(InvalidCursor)?;
        let created_ms = created_ms.parse().map_err(|_| InvalidCursor)?;
        Ok(Self { created_ms, id: id.parse().map_err(|_| InvalidCursor)? })
    }
}

/// Rows per read of a search.
const SEARCH_BATCH: u32 = 1000;

/// Selection of lineages for a list.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct LineageFilter {
    /// True for hidden lineages only, false for visible ones only; both by default.
    pub hidden: Option<bool>,
    /// Words in lower case; each must occur in the name, the notes or a tag.
    words: Vec<String>,
}

impl LineageFilter {
    /// Selects by visibility, and by words that are separated by spaces.
    #[must_use]
    pub fn new(hidden: Option<bool>, search: &str) -> Self {
        let words = search.split_whitespace().map(str::to_lowercase).collect();
        Self { hidden, words }
    }

    /// Returns the longest word that an engine can look for, as a pattern of LIKE: SQLite folds the
    /// case of ASCII letters only, and tags are JSON.
    fn pattern(&self) -> Option<String> {
        let is_plain = |word: &&String| word.bytes().all(|byte| byte.is_ascii_alphanumeric());
        let longest = self.words.iter().filter(is_plain).max_by_key(|word| word.len());
        longest.map(|word| format!("%{word}%"))
    }

    fn selects(&self, text: &LineageText) -> bool {
        let LineageText { name, notes, tags, .. } = text;
        let text = format!("{name}\n{notes}\n{}", tags.join("\n")).to_lowercase();
        self.words.iter().all(|word| text.contains(word))
    }
}

record! {
    /// Texts of a lineage that a search reads.
    struct LineageText {
        id: LineageId,
        name: String,
        notes: String,
        tags: Vec<String> = "tags_json",
        created_ms: i64,
    }
}

record!(Lineage {
    id,
    name,
    notes,
    tags = "tags_json",
    hidden,
    cover_individual = "cover_id",
    scene = "scene_id",
    thumbnail_px,
    start,
    dialect = "dialect_json",
    saturation,
    energy_limit,
    // Positions have no gaps; counting would read them all.
    generations = "(SELECT coalesce(max(position) + 1, 0) FROM generation WHERE lineage_id = lineage.id)",
    favourites = "(SELECT count(*) FROM individual WHERE lineage_id = lineage.id AND favourite /*sqlite*/ = 1 /*end*/)",
    created_ms,
    version,
});

impl Store {
    /// Stores a new lineage and returns it as stored. Its `hidden`, `cover_individual`,
    /// `generations`, `favourites` and `version` are not read.
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`] if the scene does not exist, [`StorageError::Conflict`]
    /// if the id or the idempotency key is in use.
    pub async fn create_lineage(
        &self,
        new: Lineage,
        idempotency: Option<Idempotency>,
    ) -> Result<Lineage> {
        self.write(operation!(|conn| {
            idempotency::insert(conn, idempotency.as_ref(), new.created_ms).await?;
            insert(conn, &new).await?;
            fetch(conn, new.id).await
        }))
        .await
    }

    /// Lists the lineages that a filter selects, the newest first, after the cursor.
    ///
    /// # Errors
    /// Returns a [`StorageError`] if the read fails.
    pub async fn list_lineages(
        &self,
        cursor: Option<LineageCursor>,
        limit: u32,
        filter: &LineageFilter,
    ) -> Result<Vec<Lineage>> {
        let mut conn = self.snapshot().await?;
        if filter.words.is_empty() {
            return fetch_after(&mut conn, cursor, limit, filter.hidden, None).await;
        }
        let found = search(&mut conn, cursor, limit, filter).await?;
        let rest = "FROM lineage WHERE id IN (SELECT unhex(value) FROM json_each(?))
             ORDER BY created_ms DESC, id DESC";
        let query = select::<Lineage>(rest).bind(key_set(&found));
        query.fetch_all(&mut conn).await?.iter().map(Lineage::read).collect()
    }

    /// Returns a lineage, hidden or not.
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`] if it does not exist.
    pub async fn lineage(&self, id: LineageId) -> Result<Lineage> {
        fetch(&mut self.reader().await?, id).await
    }

    /// Changes a lineage.
    ///
    /// # Errors
    /// Returns [`StorageError::StaleVersion`] if its version is not `expected_version`,
    /// [`StorageError::NotFound`] if it, the new scene or the new cover does not exist.
    pub async fn patch_lineage(
        &self,
        id: LineageId,
        expected_version: u64,
        patch: PatchLineage,
    ) -> Result<Lineage> {
        self.write(operation!(|conn| {
            let done = query(
                "UPDATE lineage SET name = coalesce(?, name), notes = coalesce(?, notes),
                     tags_json = coalesce(?, tags_json), hidden = coalesce(?, hidden),
                     cover_id = CASE WHEN ? THEN ? ELSE cover_id END,
                     scene_id = coalesce(?, scene_id), saturation = coalesce(?, saturation),
                     energy_limit = coalesce(?, energy_limit),
                     version = version + 1
                 WHERE id = ? AND version = ?",
            )
            .bind(patch.name)
            .bind(patch.notes)
            .bind(patch.tags.as_deref().map(tags_json))
            .bind(patch.hidden)
            .bind(patch.cover_individual.is_some())
            .bind(optional_key(patch.cover_individual.flatten()))
            .bind(optional_key(patch.scene))
            .bind(patch.saturation)
            .bind(patch.energy_limit)
            .bind(id.key())
            .bind(signed(expected_version))
            .execute(conn)
            .await?;
            let lineage = fetch(conn, id).await?;
            changed(done, StorageError::StaleVersion { current: lineage.version })?;
            Ok(lineage)
        }))
        .await
    }

    /// Hides a lineage from lists. It is kept, and links to it still work.
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`] if it does not exist.
    pub async fn hide_lineage(&self, id: LineageId) -> Result<()> {
        self.write(operation!(|conn| {
            let query = query("UPDATE lineage SET hidden = TRUE WHERE id = ?");
            changed(query.bind(id.key()).execute(conn).await?, StorageError::NotFound)
        }))
        .await
    }
}

/// Condition for a pattern; texts that are not ASCII always meet it.
const PATTERN: &str = "AND (lower(name || '\n' || notes || '\n' || tags_json) LIKE ?5
     OR length(name || notes || tags_json) < octet_length(name || notes || tags_json))";

/// Searches for the ids of at most `limit` lineages, the newest first. Reads batches until it has
/// enough.
async fn search(
    conn: &mut Conn,
    mut cursor: Option<LineageCursor>,
    limit: u32,
    filter: &LineageFilter,
) -> Result<Vec<LineageId>> {
    let mut found = Vec::new();
    loop {
        let read: Vec<LineageText> =
            fetch_after(conn, cursor, SEARCH_BATCH, filter.hidden, filter.pattern()).await?;
        let is_last = read.len() < SEARCH_BATCH as usize;
        let position =
            |last: &LineageText| LineageCursor { created_ms: last.created_ms, id: last.id };
        cursor = read.last().map(position);
        found.extend(read.iter().filter(|text| filter.selects(text)).map(|text| text.id));
        if is_last || found.len() >= limit as usize {
            found.truncate(limit as usize);
            return Ok(found);
        }
    }
}

/// Reads a batch of lineages, the newest first; only those that meet a pattern, if there is one.
async fn fetch_after<T: Record>(
    conn: &mut Conn,
    cursor: Option<LineageCursor>,
    limit: u32,
    hidden: Option<bool>,
    pattern: Option<String>,
) -> Result<Vec<T>> {
    // Two statements, so that SQLite starts at the cursor in the index.
    let after = if cursor.is_some() { "AND (created_ms, id) < (?3, ?4)" } else { "" };
    let within = if pattern.is_some() { PATTERN } else { "" };
    let query = select::<T>(&format!(
        "FROM lineage WHERE hidden = coalesce(?1, hidden) {after} {within}
             AND id NOT IN (SELECT lineage_id FROM unfinished_lineage)
         ORDER BY created_ms DESC, id DESC LIMIT ?2"
    ));
    let position = cursor.map(|cursor| (cursor.created_ms, cursor.id.key().to_vec()));
    let (created_ms, id) = position.unzip();
    let query = query.bind(hidden).bind(limit).bind(created_ms).bind(id).bind(pattern);
    query.fetch_all(conn).await?.iter().map(T::read).collect()
}

/// Lets no other server add a generation to a lineage before the end of the transaction.
///
/// # Errors
/// Returns [`StorageError::NotFound`] if it does not exist.
pub(crate) async fn lock(conn: &mut Conn, id: LineageId) -> Result<()> {
    if conn.has_other_writers() {
        let lock = query("SELECT id FROM lineage WHERE id = ? FOR NO KEY UPDATE");
        lock.bind(id.key()).fetch_one(conn).await?;
    }
    Ok(())
}

/// Work on an unfinished lineage.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Unfinished {
    Import,
    Removal,
}

impl Unfinished {
    /// Error if another server, or another request to this one, has removed the lineage or begun
    /// to.
    fn removed(self) -> StorageError {
        match self {
            Self::Import => StorageError::Conflict { what: "another server removes the lineage" },
            Self::Removal => StorageError::NotFound,
        }
    }
}

/// Hides a lineage from all lists until its import or removal is finished. Other servers do
/// not remove it until [`UNFINISHED`] after the last [`renew_unfinished`].
///
/// # Errors
/// Returns [`StorageError::NotFound`] if it does not exist.
pub(crate) async fn set_unfinished(conn: &mut Conn, id: LineageId, work: Unfinished) -> Result<()> {
    let hide = query("UPDATE lineage SET hidden = TRUE WHERE id = ?").bind(id.key());
    changed(hide.execute(conn).await?, StorageError::NotFound)?;
    let sql = format!(
        "INSERT INTO unfinished_lineage (lineage_id, until_ms, removing) VALUES (?2, {} + ?3, ?4)
         ON CONFLICT (lineage_id) DO UPDATE
             SET until_ms = excluded.until_ms, removing = excluded.removing",
        lease::now(1)
    );
    let set = query(sql).bind(steady_ms()).bind(id.key()).bind(lease::ttl_ms(UNFINISHED));
    set.bind(work == Unfinished::Removal).execute(conn).await?;
    Ok(())
}

/// Sets the deadline of an unfinished lineage to [`UNFINISHED`] from now. A removal ends an import:
/// the import can add no further generation. Locks the row in `lineage` before that in
/// `unfinished_lineage`, as [`set_unfinished`] does.
///
/// # Errors
/// Returns an error if the lineage is removed: [`StorageError::Conflict`] for an import,
/// [`StorageError::NotFound`] for a removal.
pub(crate) async fn renew_unfinished(
    conn: &mut Conn,
    id: LineageId,
    work: Unfinished,
) -> Result<()> {
    match lock(conn, id).await {
        Err(StorageError::NotFound) => return Err(work.removed()),
        locked => locked?,
    }
    let sql = format!(
        "UPDATE unfinished_lineage SET until_ms = {} + ?3, removing = ?4
         WHERE lineage_id = ?2 AND (?4 OR NOT removing)",
        lease::now(1)
    );
    let renew = query(sql).bind(steady_ms()).bind(id.key()).bind(lease::ttl_ms(UNFINISHED));
    let renewed = renew.bind(work == Unfinished::Removal).execute(conn).await?;
    changed(renewed, work.removed())
}

/// Marks the unfinished lineages whose deadline has passed for removal by this server, and returns
/// them. `all` also selects those of a SQLite file, which this process has just opened.
pub(crate) async fn take_unfinished(conn: &mut Conn, all: bool) -> Result<Vec<LineageId>> {
    let sql = format!(
        "UPDATE unfinished_lineage SET until_ms = {} + ?3, removing = TRUE
         WHERE until_ms <= {} RETURNING lineage_id",
        lease::now(1),
        lease::now(2)
    );
    let before = if all { i64::MAX } else { steady_ms() };
    let take = query(sql).bind(steady_ms()).bind(before).bind(lease::ttl_ms(UNFINISHED));
    take.fetch_all(conn).await?.iter().map(|row| row.column("lineage_id")).collect()
}

fn tags_json(tags: &[String]) -> String {
    serde_json::to_string(tags).expect("tags are plain data")
}

/// Inserts a lineage.
pub(crate) async fn insert(conn: &mut Conn, new: &Lineage) -> Result<()> {
    let dialect = serde_json::to_string(&new.dialect).expect("a dialect is plain data");
    query(
        "INSERT INTO lineage
             (id, name, notes, tags_json, scene_id, thumbnail_px, start, dialect_json, saturation,
              energy_limit, created_ms)
         VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
    )
    .bind(new.id.key())
    .bind(new.name.as_str())
    .bind(new.notes.as_str())
    .bind(tags_json(&new.tags))
    .bind(new.scene.key())
    .bind(new.thumbnail_px)
    .bind(new.start.name())
    .bind(dialect)
    .bind(new.saturation)
    .bind(new.energy_limit)
    .bind(new.created_ms)
    .execute(conn)
    .await?;
    Ok(())
}

/// Chooses the cover of a lineage.
pub(crate) async fn set_cover(conn: &mut Conn, id: LineageId, cover: IndividualId) -> Result<()> {
    let query = query("UPDATE lineage SET cover_id = ? WHERE id = ?");
    query.bind(cover.key()).bind(id.key()).execute(conn).await?;
    Ok(())
}

/// Reads a lineage.
pub(crate) async fn fetch(conn: &mut Conn, id: LineageId) -> Result<Lineage> {
    let query = select::<Lineage>("FROM lineage WHERE id = ?").bind(id.key());
    Lineage::read(&query.fetch_one(conn).await?)
}
