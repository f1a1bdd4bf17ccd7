-- From a catalogue of version 22 to one of version 23 in PostgreSQL: whose units a job goes on with, by what they were made
-- from, how often machines in trouble gave work back, and what the files of maps in a store are. Part of a new one too.
ALTER TABLE job ADD COLUMN units_of TEXT COLLATE "C" NOT NULL DEFAULT '';  -- the job under whose id its units lie; '': not cut
ALTER TABLE job ADD COLUMN made_from TEXT COLLATE "C" NOT NULL DEFAULT '';  -- digest of what its units are made from
ALTER TABLE job ADD COLUMN troubles BIGINT NOT NULL DEFAULT 0;  -- of machines that gave it back
ALTER TABLE unit ADD COLUMN troubles BIGINT NOT NULL DEFAULT 0;  -- as of a job
UPDATE job SET units_of = id WHERE id IN (SELECT job_id FROM unit);
CREATE TABLE product(
  flight_id TEXT COLLATE "C" NOT NULL,
  revision BIGINT NOT NULL,
  name TEXT COLLATE "C" NOT NULL,  -- below the map's prefix
  sha256 TEXT COLLATE "C" NOT NULL,  -- in hex
  PRIMARY KEY(flight_id, revision, name),
  FOREIGN KEY(flight_id, revision) REFERENCES revision(flight_id, revision) ON DELETE CASCADE
);
