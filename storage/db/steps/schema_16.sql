-- From a catalogue of version 15 to one of version 16: jobs that are cut into units, and where the bytes of a resumable
-- upload are that do not lie in the data folder. The outcome is that of schema.sql.
ALTER TABLE upload ADD COLUMN parts TEXT NOT NULL DEFAULT '';
ALTER TABLE job ADD COLUMN units_from REAL NOT NULL DEFAULT 0;
ALTER TABLE job ADD COLUMN units_to REAL NOT NULL DEFAULT 0;

-- The units of jobs that are cut, each for any worker.
CREATE TABLE unit(
  job_id TEXT NOT NULL REFERENCES job(id) ON DELETE CASCADE,
  kind TEXT NOT NULL,
  number INTEGER NOT NULL,
  items INTEGER NOT NULL,                      -- that all units of this kind share: files, blocks
  state TEXT NOT NULL CHECK(state IN ('waiting','running','done')),
  attempts INTEGER NOT NULL DEFAULT 0,
  lease_until_us INTEGER NOT NULL DEFAULT 0,
  lease_token INTEGER NOT NULL DEFAULT 0,      -- grows with every claim, as that of a job
  worker TEXT NOT NULL DEFAULT '',
  PRIMARY KEY(job_id, kind, number)
) STRICT;
CREATE INDEX unit_open ON unit(state) WHERE state <> 'done';

CREATE TRIGGER units_end AFTER UPDATE OF state ON job WHEN NEW.state NOT IN ('accepted','running') BEGIN
  DELETE FROM unit WHERE job_id = NEW.id;
END;
