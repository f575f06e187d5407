-- Genomes are facts and are kept once, under the hash of their content, however many individuals carry them.
-- The text comes last so that joins for the small columns never read its overflow pages. Programs are not kept:
-- lowering is cheap and may improve. `kept` marks genomes that someone saved by hand; a purge leaves those alone.
CREATE TABLE genome (
    hash              BLOB    NOT NULL PRIMARY KEY CHECK (length(hash) = 32),
    program_hash      BLOB    NOT NULL CHECK (length(program_hash) = 32),
    live_instructions INTEGER NOT NULL CHECK (live_instructions >= 0),
    kept              INTEGER NOT NULL CHECK (kept IN (0, 1)),
    text              TEXT    NOT NULL
) STRICT;

-- Neutral twins share a program, and with it their pictures: a purge hands pictures over to a surviving twin.
CREATE INDEX genome_program ON genome (program_hash);
