-- Genomes that `bytes` is packed against: none or up to two hashes of 32 bytes, one after the other. They are the
-- parents of a generation that the genome was born in, and their own bytes are packed against none. NULL in rows whose
-- bytes are not packed: those from before, until `brood compact` packs them.
ALTER TABLE genome ADD COLUMN bases BLOB CHECK (length(bases) % 32 = 0 AND length(bases) <= 64);
