-- Schema for PostgreSQL: the tables of ../*.sql as they are after 0030; these files describe each table. Times are
-- milliseconds since 1970-01-01 UTC, ids have 16 bytes, hashes 32.
CREATE TABLE genome (
    hash              BYTEA   NOT NULL PRIMARY KEY CHECK (octet_length(hash) = 32),
    program_hash      BYTEA   NOT NULL CHECK (octet_length(program_hash) = 32),
    live_instructions BIGINT  NOT NULL CHECK (live_instructions >= 0),
    kept              BOOLEAN NOT NULL,
    text              TEXT    NOT NULL,
    bytes             BYTEA,
    layers            TEXT,
    bases             BYTEA   CHECK (octet_length(bases) % 32 = 0 AND octet_length(bases) <= 64)
);
CREATE INDEX genome_program ON genome (program_hash);
CREATE INDEX genome_kept ON genome (hash) WHERE kept;

CREATE TABLE mesh (
    id            BYTEA   NOT NULL PRIMARY KEY CHECK (octet_length(id) = 16),
    content_hash  BYTEA   NOT NULL UNIQUE CHECK (octet_length(content_hash) = 32),
    vertices      BIGINT  NOT NULL CHECK (vertices >= 0),
    triangles     BIGINT  NOT NULL CHECK (triangles >= 0),
    has_uv        BOOLEAN NOT NULL,
    warnings_json TEXT    NOT NULL,
    data          BYTEA   NOT NULL
);

CREATE TABLE light_asset (
    hash  BYTEA NOT NULL PRIMARY KEY CHECK (octet_length(hash) = 32),
    kind  TEXT  NOT NULL CHECK (kind IN ('profile', 'environment', 'image')),
    bytes BYTEA NOT NULL
);

CREATE TABLE scene (
    id           BYTEA  NOT NULL PRIMARY KEY CHECK (octet_length(id) = 16),
    content_hash BYTEA  NOT NULL UNIQUE CHECK (octet_length(content_hash) = 32),
    created_ms   BIGINT NOT NULL,
    json         TEXT   NOT NULL
);

CREATE TABLE lineage (
    id           BYTEA            NOT NULL PRIMARY KEY CHECK (octet_length(id) = 16),
    name         TEXT             NOT NULL,
    notes        TEXT             NOT NULL,
    tags_json    TEXT             NOT NULL DEFAULT '[]',
    scene_id     BYTEA            NOT NULL REFERENCES scene (id),
    thumbnail_px BIGINT           NOT NULL CHECK (thumbnail_px > 0),
    start        TEXT             NOT NULL CHECK (start IN ('believable', 'models', 'painted', 'wild')),
    dialect_json TEXT             NOT NULL,
    saturation   DOUBLE PRECISION NOT NULL,
    energy_limit BOOLEAN          NOT NULL,
    cover_id     BYTEA,
    created_ms   BIGINT           NOT NULL,
    hidden       BOOLEAN          NOT NULL DEFAULT FALSE,
    version      BIGINT           NOT NULL DEFAULT 1 CHECK (version > 0)
);
CREATE INDEX lineage_created ON lineage (created_ms, id);
CREATE INDEX lineage_scene ON lineage (scene_id);
CREATE INDEX lineage_cover ON lineage (cover_id) WHERE cover_id IS NOT NULL;

CREATE TABLE unfinished_lineage (
    lineage_id BYTEA NOT NULL PRIMARY KEY REFERENCES lineage (id) ON DELETE CASCADE
);

CREATE TABLE generation (
    id            BYTEA            NOT NULL PRIMARY KEY CHECK (octet_length(id) = 16),
    lineage_id    BYTEA            NOT NULL REFERENCES lineage (id) ON DELETE CASCADE,
    position      BIGINT           NOT NULL CHECK (position >= 0),
    seed_bits     BIGINT           NOT NULL,
    centre_id     BYTEA,
    mutation      DOUBLE PRECISION NOT NULL,
    recombination DOUBLE PRECISION NOT NULL,
    curation      TEXT             NOT NULL CHECK (curation IN ('off', 'distinct', 'diverse')),
    isotropic     BOOLEAN,
    homogeneous   BOOLEAN,
    bumps         BOOLEAN,
    saturation    DOUBLE PRECISION,
    energy_limit  BOOLEAN,
    locks_json    TEXT,
    steer_json    TEXT             NOT NULL,
    painting_json TEXT,
    created_ms    BIGINT           NOT NULL,
    UNIQUE (lineage_id, position)
);
CREATE INDEX generation_centre ON generation (centre_id) WHERE centre_id IS NOT NULL;

CREATE TABLE individual (
    id            BYTEA   NOT NULL PRIMARY KEY CHECK (octet_length(id) = 16),
    lineage_id    BYTEA   NOT NULL REFERENCES lineage (id) ON DELETE CASCADE,
    generation_id BYTEA   NOT NULL REFERENCES generation (id) ON DELETE CASCADE,
    slot          BIGINT  NOT NULL CHECK (slot >= 0),
    genome_hash   BYTEA   NOT NULL REFERENCES genome (hash),
    operator      TEXT    NOT NULL,
    attempts      BIGINT  NOT NULL CHECK (attempts > 0),
    twin          BOOLEAN NOT NULL,
    favourite     BOOLEAN NOT NULL DEFAULT FALSE,
    note          TEXT    NOT NULL DEFAULT '',
    version       BIGINT  NOT NULL DEFAULT 1 CHECK (version > 0),
    UNIQUE (generation_id, slot)
);
CREATE INDEX individual_lineage ON individual (lineage_id);
CREATE INDEX individual_genome ON individual (genome_hash);
CREATE INDEX individual_favourite ON individual (id) WHERE favourite;
CREATE INDEX individual_lineage_favourite ON individual (lineage_id, id) WHERE favourite;

ALTER TABLE lineage ADD FOREIGN KEY (cover_id) REFERENCES individual (id) ON DELETE SET NULL;
ALTER TABLE generation ADD FOREIGN KEY (centre_id) REFERENCES individual (id) ON DELETE SET NULL;

CREATE TABLE generation_parent (
    generation_id        BYTEA  NOT NULL REFERENCES generation (id) ON DELETE CASCADE,
    place                BIGINT NOT NULL CHECK (place >= 0),
    genome_hash          BYTEA  NOT NULL REFERENCES genome (hash),
    individual_id        BYTEA  REFERENCES individual (id) ON DELETE SET NULL,
    parent_generation_id BYTEA  REFERENCES generation (id) ON DELETE SET NULL,
    PRIMARY KEY (generation_id, place)
);
CREATE INDEX generation_parent_genome ON generation_parent (genome_hash);
CREATE INDEX generation_parent_individual ON generation_parent (individual_id) WHERE individual_id IS NOT NULL;
CREATE INDEX generation_parent_generation ON generation_parent (parent_generation_id)
WHERE parent_generation_id IS NOT NULL;

CREATE TABLE picture (
    key              BYTEA            NOT NULL PRIMARY KEY CHECK (octet_length(key) = 32),
    genome_hash      BYTEA            NOT NULL REFERENCES genome (hash) ON DELETE CASCADE,
    scene_id         BYTEA            NOT NULL REFERENCES scene (id),
    light_deg        DOUBLE PRECISION NOT NULL,
    size_px          BIGINT           NOT NULL CHECK (size_px > 0),
    height_px        BIGINT           CHECK (height_px > 0),
    samples          BIGINT           NOT NULL CHECK (samples > 0),
    adaptive         BOOLEAN          NOT NULL,
    area             TEXT             NOT NULL,
    format           TEXT             NOT NULL CHECK (format IN ('png', 'exr')),
    backend          TEXT             NOT NULL CHECK (backend IN ('auto', 'cpu', 'gpu', 'reference')),
    renderer_version BIGINT           NOT NULL CHECK (renderer_version > 0)
);
CREATE INDEX picture_genome ON picture (genome_hash);
CREATE INDEX picture_scene ON picture (scene_id);

-- Listed in the order of bytes, whatever the language of the database.
CREATE TABLE token (
    name       TEXT  COLLATE "C" NOT NULL PRIMARY KEY,
    scope      TEXT  NOT NULL CHECK (scope IN ('read', 'breed', 'work', 'admin')),
    hash       BYTEA NOT NULL UNIQUE CHECK (octet_length(hash) = 32),
    expires_ms BIGINT
);

CREATE TABLE closed (at_ms BIGINT NOT NULL);

CREATE TABLE idempotency (
    key        TEXT   COLLATE "C" NOT NULL,
    route      TEXT   COLLATE "C" NOT NULL,
    body_hash  BYTEA  NOT NULL CHECK (octet_length(body_hash) = 32),
    status     BIGINT NOT NULL,
    created_ms BIGINT NOT NULL,
    answer     BYTEA  NOT NULL,
    PRIMARY KEY (key, route)
);
CREATE INDEX idempotency_created ON idempotency (created_ms);

CREATE TABLE target_file (
    hash  BYTEA NOT NULL PRIMARY KEY CHECK (octet_length(hash) = 32),
    bytes BYTEA NOT NULL
);

CREATE TABLE target (
    id         BYTEA  NOT NULL PRIMARY KEY CHECK (octet_length(id) = 16),
    kind       TEXT   NOT NULL CHECK (kind IN ('samples', 'slice', 'merl', 'rgl', 'cornell', 'image')),
    file_hash  BYTEA  NOT NULL REFERENCES target_file (hash),
    created_ms BIGINT NOT NULL,
    json       TEXT   NOT NULL
);
CREATE INDEX target_file_hash ON target (file_hash);

CREATE TABLE search (
    id            BYTEA            NOT NULL PRIMARY KEY CHECK (octet_length(id) = 16),
    target_id     BYTEA            NOT NULL CHECK (octet_length(target_id) = 16),
    target_kind   TEXT             NOT NULL,
    target_hash   BYTEA            NOT NULL CHECK (octet_length(target_hash) = 32),
    lineage_id    BYTEA            NOT NULL REFERENCES lineage (id) ON DELETE CASCADE,
    state         TEXT             NOT NULL
        CHECK (state IN ('queued', 'running', 'paused', 'succeeded', 'failed', 'cancelled')),
    epoch         BIGINT           NOT NULL CHECK (epoch >= 0),
    turn          BIGINT           NOT NULL,
    deaths        BIGINT           NOT NULL CHECK (deaths >= 0),
    worker        TEXT,
    reason        TEXT,
    generation    BIGINT           NOT NULL CHECK (generation >= 0),
    evaluations   BIGINT           NOT NULL CHECK (evaluations >= 0),
    seconds       DOUBLE PRECISION NOT NULL,
    fitted        DOUBLE PRECISION,
    held          DOUBLE PRECISION,
    recorded      DOUBLE PRECISION,
    population    BYTEA            CHECK (octet_length(population) = 32),
    created_ms    BIGINT           NOT NULL,
    started_ms    BIGINT,
    ended_ms      BIGINT,
    options_json  TEXT             NOT NULL,
    best_json     TEXT,
    front_json    TEXT,
    spread_json   TEXT,
    darkest_png   BYTEA,
    brightest_png BYTEA,
    start         BYTEA            NOT NULL,
    checkpoint    BYTEA
);
CREATE INDEX search_waiting ON search (turn, id) WHERE state = 'queued';
CREATE INDEX search_lineage ON search (lineage_id);
CREATE INDEX search_target ON search (target_id);

CREATE TABLE search_log (
    search_id   BYTEA            NOT NULL REFERENCES search (id) ON DELETE CASCADE,
    generation  BIGINT           NOT NULL,
    evaluations BIGINT           NOT NULL,
    seconds     DOUBLE PRECISION NOT NULL,
    fitted      DOUBLE PRECISION,
    held        DOUBLE PRECISION,
    median      DOUBLE PRECISION,
    diversity   DOUBLE PRECISION,
    repeats     BIGINT,
    best_hash   BYTEA            CHECK (octet_length(best_hash) = 32),
    PRIMARY KEY (search_id, generation)
);

CREATE TABLE export (
    id           BYTEA   NOT NULL PRIMARY KEY CHECK (octet_length(id) = 16),
    state        TEXT    NOT NULL CHECK (state IN ('queued', 'running', 'succeeded', 'failed', 'cancelled')),
    epoch        BIGINT  NOT NULL CHECK (epoch >= 0),
    deaths       BIGINT  NOT NULL CHECK (deaths >= 0),
    worker       TEXT,
    reason       TEXT,
    energy_limit BOOLEAN,
    created_ms   BIGINT  NOT NULL,
    started_ms   BIGINT,
    ended_ms     BIGINT,
    plan_json    TEXT    NOT NULL
);
CREATE INDEX export_waiting ON export (id) WHERE state = 'queued';

CREATE TABLE export_file (
    export_id   BYTEA  NOT NULL REFERENCES export (id) ON DELETE CASCADE,
    number      BIGINT NOT NULL CHECK (number >= 0),
    genome_hash BYTEA  NOT NULL CHECK (octet_length(genome_hash) = 32),
    format      TEXT   NOT NULL,
    bytes       BIGINT CHECK (bytes >= 0),
    note        TEXT,
    PRIMARY KEY (export_id, number)
);
