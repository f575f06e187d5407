-- PostgreSQL's rows have the names of objects in place of large files; SQLite's have all files, and no names.
ALTER TABLE target_file ADD COLUMN object TEXT;
ALTER TABLE light_asset ADD COLUMN object TEXT;
ALTER TABLE mesh ADD COLUMN object TEXT;
ALTER TABLE search_checkpoint ADD COLUMN object TEXT;
