-- The work queue. A generation and the job that renders it are written in one transaction, which is why the queue is
-- here and not in memory. Each lease counts the epoch up, and every later word about the job must name it: a worker
-- that was thought dead and comes back changes nothing. All states of the design are allowed from the start, because
-- a CHECK cannot be widened without copying the table.
CREATE TABLE job (
    id         BLOB    NOT NULL PRIMARY KEY CHECK (length(id) = 16),
    kind       TEXT    NOT NULL CHECK (kind IN ('render', 'fit')),
    queue      TEXT    NOT NULL CHECK (queue IN ('interactive', 'batch')),
    state      TEXT    NOT NULL DEFAULT 'queued' CHECK (state IN (
                   'queued', 'leased', 'running', 'checkpointed', 'paused', 'succeeded', 'failed', 'cancelled', 'dead')),
    epoch      INTEGER NOT NULL DEFAULT 0 CHECK (epoch >= 0),
    deaths     INTEGER NOT NULL DEFAULT 0 CHECK (deaths >= 0),
    worker     TEXT,
    reason     TEXT,
    created_ms INTEGER NOT NULL,
    payload    BLOB    NOT NULL
) STRICT;

CREATE INDEX job_waiting ON job (queue, id) WHERE state = 'queued';
CREATE INDEX job_state ON job (state, queue, id);
