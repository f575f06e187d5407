-- Leases of searches and exports end at a time of the database's clock.
ALTER TABLE search ADD COLUMN lease_until_ms BIGINT;
ALTER TABLE export ADD COLUMN lease_until_ms BIGINT;
-- No server runs: the workers of its leases have not died.
UPDATE search SET state = 'queued', epoch = epoch + 1, worker = NULL WHERE state = 'running';
UPDATE export SET state = 'queued', epoch = epoch + 1, worker = NULL WHERE state = 'running';
CREATE INDEX search_running ON search (id) WHERE state = 'running';
CREATE INDEX export_running ON export (id) WHERE state = 'running';
-- Checkpoints are large and change more rarely than the progress of their searches.
CREATE TABLE search_checkpoint (
    search_id  BYTEA NOT NULL PRIMARY KEY REFERENCES search (id) ON DELETE CASCADE,
    generation BIGINT NOT NULL CHECK (generation >= 0),
    bytes      BYTEA NOT NULL
);
INSERT INTO search_checkpoint SELECT id, generation, checkpoint FROM search WHERE checkpoint IS NOT NULL;
ALTER TABLE search DROP COLUMN checkpoint;
-- Another server goes on with the removal of an unfinished lineage after this time of the database's clock.
ALTER TABLE unfinished_lineage ADD COLUMN until_ms BIGINT NOT NULL DEFAULT 0;
ALTER TABLE unfinished_lineage ADD COLUMN removing BOOLEAN NOT NULL DEFAULT FALSE;
-- Files of exports, in parts, so that all servers can read them. Parts without a file in export_file that has a size
-- are removed one by one; there is no reference, since a cascade over gigabytes can take longer than 30 s.
CREATE TABLE export_blob (
    export_id BYTEA  NOT NULL CHECK (octet_length(export_id) = 16),
    number    BIGINT NOT NULL CHECK (number >= 0),
    part      BIGINT NOT NULL CHECK (part >= 0),
    bytes     BYTEA  NOT NULL,
    PRIMARY KEY (export_id, number, part)
);
-- Not compressed: most bytes are tables of floating-point numbers.
ALTER TABLE export_blob ALTER COLUMN bytes SET STORAGE EXTERNAL;
