-- Pictures are sampled adaptively unless a number of samples is asked for, and may be a part of a whole one. The number
-- stays a column of its own: where `adaptive` is 1 it is the least that every pixel gets. `area` is x,y,width,height in
-- pixels of the whole picture, and empty for all of it. Keys of before are of an older renderer; they keep their meaning.
ALTER TABLE picture ADD COLUMN adaptive INTEGER NOT NULL DEFAULT 0 CHECK (adaptive IN (0, 1));
ALTER TABLE picture ADD COLUMN area     TEXT    NOT NULL DEFAULT '';
