-- Files that lights of scenes refer to, by the hash of their bytes: photometric profiles and pictures of environments. They
-- are kept as they came, so that what a lamp's maker published can be read again by a better reader.
CREATE TABLE light_asset (
    hash  BLOB NOT NULL PRIMARY KEY CHECK (length(hash) = 32),
    kind  TEXT NOT NULL CHECK (kind IN ('profile', 'environment')),
    bytes BLOB NOT NULL
) STRICT;
