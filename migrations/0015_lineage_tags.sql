-- Lineages are found by their tags, restored after hiding, and shown by a chosen cover. The index serves favourites of one
-- lineage, their number, and covers.
ALTER TABLE lineage ADD COLUMN tags_json TEXT NOT NULL DEFAULT '[]';
ALTER TABLE lineage ADD COLUMN cover_id BLOB REFERENCES individual (id) ON DELETE SET NULL;

CREATE INDEX lineage_cover ON lineage (cover_id) WHERE cover_id IS NOT NULL;
CREATE INDEX individual_lineage_favourite ON individual (lineage_id, id) WHERE favourite = 1;
