-- Genomes are stored as their canonical bytes from here on: a third of the text's size, in a column of their own behind
-- it. Rows from before keep their text and have no bytes; new rows have bytes and an empty text.
ALTER TABLE genome ADD COLUMN bytes BLOB;
