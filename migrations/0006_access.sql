-- Tokens are kept as hashes: whoever reads the file cannot use them. Answers of requests with an idempotency key are
-- written in the transaction that they answer for, so that a retry after a crash sees either both or neither.
CREATE TABLE token (
    name       TEXT    NOT NULL PRIMARY KEY,
    scope      TEXT    NOT NULL CHECK (scope IN ('read', 'breed', 'work', 'admin')),
    hash       BLOB    NOT NULL UNIQUE CHECK (length(hash) = 32),
    expires_ms INTEGER
) STRICT;

CREATE TABLE idempotency (
    key        TEXT    NOT NULL,
    route      TEXT    NOT NULL,
    body_hash  BLOB    NOT NULL CHECK (length(body_hash) = 32),
    status     INTEGER NOT NULL,
    created_ms INTEGER NOT NULL,
    answer     BLOB    NOT NULL,
    PRIMARY KEY (key, route)
) STRICT;

CREATE INDEX idempotency_created ON idempotency (created_ms);
