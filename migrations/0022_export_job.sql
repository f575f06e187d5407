-- Archives that take long, as jobs. The files of a job are in the folder `exports` of the data directory, one folder for
-- each job. A file's row gets its size after the file is on disk, so that what a row names can be read, and a job goes on
-- after any end of server or worker. `plan_json` is the manifest without notes. A job is deleted with its files after a
-- day, or when others need the space. Genomes are named without a reference: an export is no part of a history.
CREATE TABLE export (
    id           BLOB    NOT NULL PRIMARY KEY CHECK (length(id) = 16),
    state        TEXT    NOT NULL CHECK (state IN ('queued', 'running', 'succeeded', 'failed', 'cancelled')),
    epoch        INTEGER NOT NULL CHECK (epoch >= 0),
    deaths       INTEGER NOT NULL CHECK (deaths >= 0),
    worker       TEXT,
    reason       TEXT,
    energy_limit INTEGER          CHECK (energy_limit IN (0, 1)),
    created_ms   INTEGER NOT NULL,
    started_ms   INTEGER,
    ended_ms     INTEGER,
    plan_json    TEXT    NOT NULL
) STRICT;

CREATE INDEX export_waiting ON export (id) WHERE state = 'queued';

CREATE TABLE export_file (
    export_id   BLOB    NOT NULL REFERENCES export (id) ON DELETE CASCADE,
    number      INTEGER NOT NULL CHECK (number >= 0),
    genome_hash BLOB    NOT NULL CHECK (length(genome_hash) = 32),
    format      TEXT    NOT NULL,
    bytes       INTEGER          CHECK (bytes >= 0),
    note        TEXT,
    PRIMARY KEY (export_id, number)
) STRICT, WITHOUT ROWID;
