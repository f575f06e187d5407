-- Constraint on the bumps of children: 1 all have them, 0 none has; null as their parents.
ALTER TABLE generation ADD COLUMN bumps INTEGER CHECK (bumps IN (0, 1));
