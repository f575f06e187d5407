-- The darkest and the brightest that the material of a search could be, as PNG. Null for searches without spread_json, and
-- for those that ended before this migration.
ALTER TABLE search ADD COLUMN darkest_png BLOB;
ALTER TABLE search ADD COLUMN brightest_png BLOB;
