-- What a generation of a search looked like besides its best. Lines of before have none of it.
ALTER TABLE search_log ADD COLUMN median REAL;
ALTER TABLE search_log ADD COLUMN diversity REAL;
ALTER TABLE search_log ADD COLUMN repeats INTEGER;
