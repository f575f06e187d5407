-- The models that a genome has besides its program, by name with spaces between, so that an individual is told with them and
-- nobody reads a genome for it. Empty where there are none; NULL in rows from before, whose bytes are read for it.
ALTER TABLE genome ADD COLUMN layers TEXT;
