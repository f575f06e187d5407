-- A picture's key is handed out before its pixels exist and long after they were thrown away: what it stands for must
-- be a fact. The pixels are not kept here. A key of an older renderer stays, so that it can be answered as gone.
CREATE TABLE picture (
    key              BLOB    NOT NULL PRIMARY KEY CHECK (length(key) = 32),
    genome_hash      BLOB    NOT NULL REFERENCES genome (hash) ON DELETE CASCADE,
    scene_id         BLOB    NOT NULL REFERENCES scene (id),
    light_deg        REAL    NOT NULL,
    size_px          INTEGER NOT NULL CHECK (size_px > 0),
    samples          INTEGER NOT NULL CHECK (samples > 0),
    format           TEXT    NOT NULL CHECK (format IN ('png', 'exr')),
    backend          TEXT    NOT NULL CHECK (backend IN ('auto', 'cpu', 'gpu', 'reference')),
    renderer_version INTEGER NOT NULL CHECK (renderer_version > 0)
) STRICT;

CREATE INDEX picture_genome ON picture (genome_hash);
CREATE INDEX picture_scene ON picture (scene_id);
