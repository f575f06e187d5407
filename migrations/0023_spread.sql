-- What a search leaves open: the spread of the materials that match its target about as well as the best. Null until the
-- search has ended, and for strategies without probabilities.
ALTER TABLE search ADD COLUMN spread_json TEXT;
