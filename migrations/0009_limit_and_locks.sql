-- Whether new children of a lineage are under the energy limit, and what a generation was asked for: the limit, and the
-- parts of the first parent that were locked, as JSON. Rows from before asked for neither.
ALTER TABLE lineage ADD COLUMN energy_limit INTEGER NOT NULL DEFAULT 0 CHECK (energy_limit IN (0, 1));
ALTER TABLE generation ADD COLUMN energy_limit INTEGER CHECK (energy_limit IN (0, 1));
ALTER TABLE generation ADD COLUMN locks_json TEXT;
