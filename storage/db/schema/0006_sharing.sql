-- Several who use one server: what each may take, whose turn it is, and what the stages of a job have cost so far.
ALTER TABLE token ADD COLUMN most_bytes INTEGER;                -- of files stored; NULL: as many as the disk takes
ALTER TABLE token ADD COLUMN requests_per_minute INTEGER;       -- NULL: as many as come

ALTER TABLE flight ADD COLUMN owner TEXT NOT NULL DEFAULT '';   -- id of the token that made it; '' without one
CREATE INDEX flight_of_owner ON flight(owner);

ALTER TABLE job ADD COLUMN owner TEXT NOT NULL DEFAULT '';      -- id of the token that asked for it
ALTER TABLE job ADD COLUMN expected_s REAL;                     -- how long the whole of it should take, by what others took
ALTER TABLE job ADD COLUMN expected_low_s REAL;
ALTER TABLE job ADD COLUMN expected_high_s REAL;
CREATE INDEX job_of_owner ON job(owner, attempt_started_us);

CREATE TABLE stage_cost(
  job_id TEXT NOT NULL,                        -- stays when the job goes: its cost is still true
  stage TEXT NOT NULL,
  photos INTEGER NOT NULL,
  seconds REAL NOT NULL,
  PRIMARY KEY(job_id, stage)
) STRICT;
