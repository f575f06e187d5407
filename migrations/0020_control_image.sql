-- Control images of painted materials are kept beside the files of lights. SQLite cannot change a check, so the table is
-- made anew.
CREATE TABLE light_asset_with_images (
    hash  BLOB NOT NULL PRIMARY KEY CHECK (length(hash) = 32),
    kind  TEXT NOT NULL CHECK (kind IN ('profile', 'environment', 'image')),
    bytes BLOB NOT NULL
) STRICT;
INSERT INTO light_asset_with_images (hash, kind, bytes) SELECT hash, kind, bytes FROM light_asset;
DROP TABLE light_asset;
ALTER TABLE light_asset_with_images RENAME TO light_asset;
