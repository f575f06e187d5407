-- Searches: what is to be matched, and how far each search has come. A target's file is kept once by its content. A search is
-- not in the table of render jobs: it lives for minutes or days, moves by a compare-and-set on id, epoch and state, and carries
-- its checkpoint, from which it goes on with the same bits after any end of server or worker. `turn` is its place in the queue:
-- one that has had its slice of time goes behind the others. The kind `image` is allowed from the start, because a CHECK
-- cannot be widened without copying the table. A search is a part of its lineage's history and goes with it; the target is
-- named without a reference, so that an old one can be deleted while what was found by it stays.
CREATE TABLE target_file (
    hash  BLOB NOT NULL PRIMARY KEY CHECK (length(hash) = 32),
    bytes BLOB NOT NULL
) STRICT;

CREATE TABLE target (
    id         BLOB    NOT NULL PRIMARY KEY CHECK (length(id) = 16),
    kind       TEXT    NOT NULL CHECK (kind IN ('samples', 'slice', 'merl', 'rgl', 'cornell', 'image')),
    file_hash  BLOB    NOT NULL REFERENCES target_file (hash),
    created_ms INTEGER NOT NULL,
    json       TEXT    NOT NULL
) STRICT;

CREATE INDEX target_file_hash ON target (file_hash);

CREATE TABLE search (
    id           BLOB    NOT NULL PRIMARY KEY CHECK (length(id) = 16),
    target_id    BLOB    NOT NULL CHECK (length(target_id) = 16),
    target_kind  TEXT    NOT NULL,
    target_hash  BLOB    NOT NULL CHECK (length(target_hash) = 32),
    lineage_id   BLOB    NOT NULL REFERENCES lineage (id) ON DELETE CASCADE,
    state        TEXT    NOT NULL CHECK (state IN ('queued', 'running', 'paused', 'succeeded', 'failed', 'cancelled')),
    epoch        INTEGER NOT NULL CHECK (epoch >= 0),
    turn         INTEGER NOT NULL,
    deaths       INTEGER NOT NULL CHECK (deaths >= 0),
    worker       TEXT,
    reason       TEXT,
    generation   INTEGER NOT NULL CHECK (generation >= 0),
    evaluations  INTEGER NOT NULL CHECK (evaluations >= 0),
    seconds      REAL    NOT NULL,
    fitted       REAL,
    held         REAL,
    recorded     REAL,
    population   BLOB             CHECK (length(population) = 32),
    created_ms   INTEGER NOT NULL,
    started_ms   INTEGER,
    ended_ms     INTEGER,
    options_json TEXT    NOT NULL,
    best_json    TEXT,
    front_json   TEXT,
    start        BLOB    NOT NULL,
    checkpoint   BLOB
) STRICT;

CREATE INDEX search_waiting ON search (turn, id) WHERE state = 'queued';
CREATE INDEX search_lineage ON search (lineage_id);
CREATE INDEX search_target ON search (target_id);

CREATE TABLE search_log (
    search_id   BLOB    NOT NULL REFERENCES search (id) ON DELETE CASCADE,
    generation  INTEGER NOT NULL,
    evaluations INTEGER NOT NULL,
    seconds     REAL    NOT NULL,
    fitted      REAL,
    held        REAL,
    best_hash   BLOB             CHECK (length(best_hash) = 32),
    PRIMARY KEY (search_id, generation)
) STRICT, WITHOUT ROWID;
