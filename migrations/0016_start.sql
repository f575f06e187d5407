-- What the random children of a lineage are drawn from. Before, the dialect decided: length 0 meant models.
ALTER TABLE lineage ADD COLUMN start TEXT NOT NULL DEFAULT 'wild' CHECK (start IN ('believable', 'models', 'wild'));
UPDATE lineage SET start = 'models' WHERE json_extract(dialect_json, '$.length') = 0;
