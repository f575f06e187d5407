-- Uploaded meshes and scenes are kept once by content, so that uploading a file twice or asking for the same scene
-- twice gives the same id and the same pictures. Mesh data comes last: descriptions are read without it.
CREATE TABLE mesh (
    id            BLOB    NOT NULL PRIMARY KEY CHECK (length(id) = 16),
    content_hash  BLOB    NOT NULL UNIQUE CHECK (length(content_hash) = 32),
    vertices      INTEGER NOT NULL CHECK (vertices >= 0),
    triangles     INTEGER NOT NULL CHECK (triangles >= 0),
    has_uv        INTEGER NOT NULL CHECK (has_uv IN (0, 1)),
    warnings_json TEXT    NOT NULL,
    data          BLOB    NOT NULL
) STRICT;

CREATE TABLE scene (
    id           BLOB    NOT NULL PRIMARY KEY CHECK (length(id) = 16),
    content_hash BLOB    NOT NULL UNIQUE CHECK (length(content_hash) = 32),
    created_ms   INTEGER NOT NULL,
    json         TEXT    NOT NULL
) STRICT;
