-- Spread of the materials that match a search's target about as well as the best, as JSON. Null until the search has
-- ended, and for strategies without probabilities.
ALTER TABLE search ADD COLUMN spread_json TEXT;
