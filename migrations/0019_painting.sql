-- Colours of the picture that a generation was painted with, as JSON, so that it can be repeated
-- without the picture. Null for generations without one.
ALTER TABLE generation ADD COLUMN painting_json TEXT;
