-- Pictures need not be square: `size_px` is the width, and `height_px` the height where it differs. Keys of before are of
-- square pictures and keep their meaning.
ALTER TABLE picture ADD COLUMN height_px INTEGER CHECK (height_px > 0);
