-- What of a catalogue PostgreSQL alone has as it stands here, beside the tables of schema.sql. Triggers: functions_postgres.sql.

CREATE TABLE catalogue_version(
  one BIGINT PRIMARY KEY CHECK(one = 1),
  version BIGINT NOT NULL,
  server_start TIMESTAMPTZ  -- of the server's start that after_start has seen
);

-- The server's clock: the one by which leases end, whatever the machines' clocks say.
CREATE FUNCTION now_us() RETURNS BIGINT LANGUAGE sql VOLATILE AS
  $$ SELECT (extract(epoch FROM clock_timestamp()) * 1000000)::BIGINT $$;

-- Owners who may have waiting jobs, so that a claim finds whose turn it is without reading every job. Unlike in SQLite no
-- claim has to change a row here that another claim changes as well: `last_us` and `first_id` are never later than what
-- they stand for, the claim looks at the jobs for the truth, and refreshes what it finds unlocked.
CREATE TABLE turn(
  owner TEXT COLLATE "C" NOT NULL,  -- of jobs; '' is one too
  priority BIGINT NOT NULL,
  last_us BIGINT NOT NULL,  -- not later than the latest attempt at a job of this owner
  first_id TEXT COLLATE "C" NOT NULL,  -- not behind the first of the waiting jobs
  PRIMARY KEY(owner, priority)
);
CREATE INDEX turn_in_order ON turn(priority DESC, last_us, first_id, owner);

-- The present start of each machine that has a server or worker on this catalogue (storage/db/machine_boot.h).
CREATE TABLE machine(
  host TEXT COLLATE "C" PRIMARY KEY,
  boot_id TEXT COLLATE "C" NOT NULL,
  seen_us BIGINT NOT NULL  -- to within a day; one that was not seen for a month is forgotten
);

-- Events of all flights in one order, written by triggers so that no change can be missed.
CREATE SEQUENCE event_seq;
CREATE TABLE event(
  seq BIGINT PRIMARY KEY,  -- in the order of the commits: see event_numbered
  at_us BIGINT NOT NULL DEFAULT now_us(),
  flight_id TEXT COLLATE "C" NOT NULL,
  job_id TEXT COLLATE "C",
  kind TEXT COLLATE "C" NOT NULL,  -- job, map, file, preview, deleted, restored
  body TEXT COLLATE "C" NOT NULL  -- JSON
);
CREATE INDEX event_of_flight ON event(flight_id, seq);
CREATE INDEX event_of_job ON event(job_id, seq) WHERE job_id IS NOT NULL;

-- The time by which uploads and the trash expire (storage/db/age_clock.h): goes by the server's clock, but by no more than
-- an hour at a time, and never back.
CREATE TABLE age_clock(
  id BIGINT PRIMARY KEY CHECK(id = 1),
  age_us BIGINT NOT NULL,
  seen_us BIGINT NOT NULL  -- what the server's clock showed when it was last put forward
);
INSERT INTO age_clock VALUES(1, now_us(), now_us());
