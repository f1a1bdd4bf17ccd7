-- From a catalogue of version 22 to one of version 23: whose units a job goes on with, by what they were made from, and how
-- often machines in trouble gave work back. The outcome is that of schema.sql.
ALTER TABLE job ADD COLUMN units_of TEXT NOT NULL DEFAULT '';
ALTER TABLE job ADD COLUMN made_from TEXT NOT NULL DEFAULT '';
ALTER TABLE job ADD COLUMN troubles INTEGER NOT NULL DEFAULT 0;
ALTER TABLE unit ADD COLUMN troubles INTEGER NOT NULL DEFAULT 0;
UPDATE job SET units_of = id WHERE id IN (SELECT job_id FROM unit);
