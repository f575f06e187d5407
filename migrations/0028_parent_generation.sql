-- Generation in which a parent was born, so that descendants are found from brood to brood.
ALTER TABLE generation_parent ADD COLUMN parent_generation_id BLOB REFERENCES generation (id) ON DELETE SET NULL;
UPDATE generation_parent
SET parent_generation_id = (SELECT generation_id FROM individual WHERE id = generation_parent.individual_id)
WHERE individual_id IS NOT NULL;
CREATE INDEX generation_parent_generation ON generation_parent (parent_generation_id)
WHERE parent_generation_id IS NOT NULL;
