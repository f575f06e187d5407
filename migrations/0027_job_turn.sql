-- Order in which render jobs are claimed within a queue: clients take turns, in proportion to the work that they ask
-- for. Jobs of one client are claimed in the order of their ids.
ALTER TABLE job ADD COLUMN turn INTEGER NOT NULL DEFAULT 0 CHECK (turn >= 0);
DROP INDEX job_waiting;
CREATE INDEX job_waiting ON job (queue, turn, id) WHERE state = 'queued';
