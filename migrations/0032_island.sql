-- Islands of a search over several workers: further rows of it, one for each. The row of the search is island 0.
ALTER TABLE search ADD COLUMN parent_id BLOB REFERENCES search (id) ON DELETE CASCADE;
ALTER TABLE search ADD COLUMN island INTEGER NOT NULL DEFAULT 0 CHECK (island >= 0);
-- The island whose programs this one takes.
ALTER TABLE search ADD COLUMN previous_id BLOB;
-- The generation of the checkpoint, if programs that the previous island had at it are to be added to it.
ALTER TABLE search ADD COLUMN awaits INTEGER;
-- Front of an island that has ended, until all have.
ALTER TABLE search ADD COLUMN found BLOB;
CREATE INDEX search_parent ON search (parent_id) WHERE parent_id IS NOT NULL;
-- Programs that an island had at a generation, for the next one.
CREATE TABLE migrant (
    search_id  BLOB NOT NULL REFERENCES search (id) ON DELETE CASCADE,
    generation INTEGER NOT NULL CHECK (generation > 0),
    genomes    BLOB NOT NULL,
    PRIMARY KEY (search_id, generation)
) STRICT;
