-- Leases of searches and exports end at a time of the database's clock.
ALTER TABLE search ADD COLUMN lease_until_ms INTEGER;
ALTER TABLE export ADD COLUMN lease_until_ms INTEGER;
CREATE INDEX search_running ON search (id) WHERE state = 'running';
CREATE INDEX export_running ON export (id) WHERE state = 'running';
-- Checkpoints are large and change more rarely than the progress of their searches.
CREATE TABLE search_checkpoint (
    search_id  BLOB NOT NULL PRIMARY KEY REFERENCES search (id) ON DELETE CASCADE,
    generation INTEGER NOT NULL CHECK (generation >= 0),
    bytes      BLOB NOT NULL
) STRICT;
INSERT INTO search_checkpoint SELECT id, generation, checkpoint FROM search WHERE checkpoint IS NOT NULL;
ALTER TABLE search DROP COLUMN checkpoint;
-- Another server goes on with the removal of an unfinished lineage after this time of the database's clock.
ALTER TABLE unfinished_lineage ADD COLUMN until_ms INTEGER NOT NULL DEFAULT 0;
ALTER TABLE unfinished_lineage ADD COLUMN removing INTEGER NOT NULL DEFAULT 0 CHECK (removing IN (0, 1));
