-- Servers of schema 3 or later run on these tables.
-- Large files may be in an object store: rows then have the name of an object in place of the file. Servers of
-- schema 3 find no file in such a row: none runs any more once the database has an object store.
ALTER TABLE target_file ALTER COLUMN bytes DROP NOT NULL;
ALTER TABLE target_file ADD COLUMN object TEXT;
ALTER TABLE light_asset ALTER COLUMN bytes DROP NOT NULL;
ALTER TABLE light_asset ADD COLUMN object TEXT;
ALTER TABLE mesh ALTER COLUMN data DROP NOT NULL;
ALTER TABLE mesh ADD COLUMN object TEXT;
ALTER TABLE search_checkpoint ALTER COLUMN bytes DROP NOT NULL;
ALTER TABLE search_checkpoint ADD COLUMN object TEXT;
-- The object store of the database, at most one. The folder of the store has an object with the owner's name, so that
-- no other database removes its files.
CREATE TABLE blob_store (
    id      BIGINT NOT NULL PRIMARY KEY CHECK (id = 1),
    address TEXT   NOT NULL,
    owner   TEXT   NOT NULL
);
