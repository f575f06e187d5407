-- The family tree. Everything that is needed to breed a generation again (parents, amounts, constraints, seed) is
-- kept with it. All individuals of a generation have the parents of the generation, so parents are kept there.
CREATE TABLE lineage (
    id           BLOB    NOT NULL PRIMARY KEY CHECK (length(id) = 16),
    name         TEXT    NOT NULL,
    notes        TEXT    NOT NULL,
    scene_id     BLOB    NOT NULL REFERENCES scene (id),
    thumbnail_px INTEGER NOT NULL CHECK (thumbnail_px > 0),
    dialect_json TEXT    NOT NULL,
    saturation   REAL    NOT NULL,
    created_ms   INTEGER NOT NULL,
    hidden       INTEGER NOT NULL DEFAULT 0 CHECK (hidden IN (0, 1)),
    version      INTEGER NOT NULL DEFAULT 1 CHECK (version > 0)
) STRICT;

CREATE INDEX lineage_created ON lineage (created_ms, id);
CREATE INDEX lineage_scene ON lineage (scene_id);

-- `seed_bits` is the unsigned seed in two's complement: SQLite's integers are signed.
-- A centre that is purged with its own lineage is forgotten; the parent's hash below is not.
CREATE TABLE generation (
    id            BLOB    NOT NULL PRIMARY KEY CHECK (length(id) = 16),
    lineage_id    BLOB    NOT NULL REFERENCES lineage (id) ON DELETE CASCADE,
    position      INTEGER NOT NULL CHECK (position >= 0),
    seed_bits     INTEGER NOT NULL,
    centre_id     BLOB             REFERENCES individual (id) ON DELETE SET NULL,
    mutation      REAL    NOT NULL,
    recombination REAL    NOT NULL,
    curation      TEXT    NOT NULL CHECK (curation IN ('off', 'distinct', 'diverse')),
    isotropic     INTEGER          CHECK (isotropic IN (0, 1)),
    homogeneous   INTEGER          CHECK (homogeneous IN (0, 1)),
    saturation    REAL,
    created_ms    INTEGER NOT NULL,
    UNIQUE (lineage_id, position)
) STRICT;

CREATE INDEX generation_centre ON generation (centre_id) WHERE centre_id IS NOT NULL;

CREATE TABLE individual (
    id            BLOB    NOT NULL PRIMARY KEY CHECK (length(id) = 16),
    lineage_id    BLOB    NOT NULL REFERENCES lineage (id) ON DELETE CASCADE,
    generation_id BLOB    NOT NULL REFERENCES generation (id) ON DELETE CASCADE,
    slot          INTEGER NOT NULL CHECK (slot >= 0),
    genome_hash   BLOB    NOT NULL REFERENCES genome (hash),
    operator      TEXT    NOT NULL,
    attempts      INTEGER NOT NULL CHECK (attempts > 0),
    twin          INTEGER NOT NULL CHECK (twin IN (0, 1)),
    favourite     INTEGER NOT NULL DEFAULT 0 CHECK (favourite IN (0, 1)),
    note          TEXT    NOT NULL DEFAULT '',
    version       INTEGER NOT NULL DEFAULT 1 CHECK (version > 0),
    UNIQUE (generation_id, slot)
) STRICT;

CREATE INDEX individual_lineage ON individual (lineage_id);
CREATE INDEX individual_genome ON individual (genome_hash);
CREATE INDEX individual_favourite ON individual (id) WHERE favourite = 1;

-- The hash is there even where the parent was named by id: it outlives the parent's lineage.
CREATE TABLE generation_parent (
    generation_id BLOB    NOT NULL REFERENCES generation (id) ON DELETE CASCADE,
    place         INTEGER NOT NULL CHECK (place >= 0),
    genome_hash   BLOB    NOT NULL REFERENCES genome (hash),
    individual_id BLOB             REFERENCES individual (id) ON DELETE SET NULL,
    PRIMARY KEY (generation_id, place)
) STRICT, WITHOUT ROWID;

CREATE INDEX generation_parent_genome ON generation_parent (genome_hash);
CREATE INDEX generation_parent_individual ON generation_parent (individual_id) WHERE individual_id IS NOT NULL;
