-- Lineages can start with painted materials. SQLite cannot change a check, so the column is replaced.
ALTER TABLE lineage ADD COLUMN source TEXT NOT NULL DEFAULT 'wild'
    CHECK (source IN ('believable', 'models', 'painted', 'wild'));
UPDATE lineage SET source = start;
ALTER TABLE lineage DROP COLUMN start;
ALTER TABLE lineage RENAME COLUMN source TO start;
