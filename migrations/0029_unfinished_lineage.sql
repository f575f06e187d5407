-- Lineages that are being imported or removed, in several transactions. Lists leave them out, and
-- the next start removes them if the process ends before they are finished.
CREATE TABLE unfinished_lineage (
    lineage_id BLOB NOT NULL PRIMARY KEY REFERENCES lineage (id) ON DELETE CASCADE
) STRICT, WITHOUT ROWID;
