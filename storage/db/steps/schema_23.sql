-- From a catalogue of version 22 to one of version 23: whose units a job goes on with, by what they were made from, how often
-- machines in trouble gave work back, and what the files of maps in a store are. The outcome is that of schema.sql.
ALTER TABLE job ADD COLUMN units_of TEXT NOT NULL DEFAULT '';
ALTER TABLE job ADD COLUMN made_from TEXT NOT NULL DEFAULT '';
ALTER TABLE job ADD COLUMN troubles INTEGER NOT NULL DEFAULT 0;
ALTER TABLE unit ADD COLUMN troubles INTEGER NOT NULL DEFAULT 0;
UPDATE job SET units_of = id WHERE id IN (SELECT job_id FROM unit);
-- The files of maps that lie in a store, by which those who can write to the store alone cannot replace a map.
CREATE TABLE product(
  flight_id TEXT NOT NULL,
  revision INTEGER NOT NULL,
  name TEXT NOT NULL,                          -- below the map's prefix
  sha256 TEXT NOT NULL,                        -- in hex
  PRIMARY KEY(flight_id, revision, name),
  FOREIGN KEY(flight_id, revision) REFERENCES revision(flight_id, revision) ON DELETE CASCADE
) STRICT;
