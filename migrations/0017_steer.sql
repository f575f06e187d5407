-- Words that steered a generation, as a JSON list. Rows from before were not steered.
ALTER TABLE generation ADD COLUMN steer_json TEXT NOT NULL DEFAULT '[]';
