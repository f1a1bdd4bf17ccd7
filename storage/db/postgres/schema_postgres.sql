-- The catalogue: flights and their files, uploads under way, maps and previews, the queue of jobs, tokens, events,
-- webhooks and the trash, in PostgreSQL. The tables and columns are those of schema.sql (a test compares them), but for what
-- says why it is another. Times (`..._us`) are microseconds since 1970, UTC. Its number is kSchemaVersion in schema.cc.

CREATE TABLE catalogue_version(
  one BIGINT PRIMARY KEY CHECK(one = 1),
  version BIGINT NOT NULL,
  server_start TIMESTAMPTZ  -- of the server's start that after_start has seen
);

-- The server's clock: the one by which leases end, whatever the machines' clocks say.
CREATE FUNCTION now_us() RETURNS BIGINT LANGUAGE sql VOLATILE AS
  $$ SELECT (extract(epoch FROM clock_timestamp()) * 1000000)::BIGINT $$;

-- Flights, their files and their finished maps.
CREATE TABLE flight(
  id TEXT COLLATE "C" PRIMARY KEY,
  name TEXT COLLATE "C" NOT NULL,
  created_us BIGINT NOT NULL,
  options TEXT COLLATE "C" NOT NULL DEFAULT '{}',  -- JSON, as the user gave it
  active_revision BIGINT,
  next_revision BIGINT NOT NULL DEFAULT 1,
  owner TEXT COLLATE "C" NOT NULL DEFAULT '',  -- id of the token that made it; '' without one
  deleted_us BIGINT,  -- by the machine's clock, for display; NULL: not in the trash
  deleted_age_us BIGINT  -- by the AgeClock: the days in the trash count from here
);
CREATE INDEX flight_of_owner ON flight(owner);
CREATE INDEX flight_in_trash ON flight(deleted_age_us) WHERE deleted_us IS NOT NULL;

CREATE TABLE file(
  flight_id TEXT COLLATE "C" NOT NULL REFERENCES flight(id) ON DELETE CASCADE,
  name TEXT COLLATE "C" NOT NULL,  -- the user's; never a path
  bytes BIGINT NOT NULL,
  stored_name TEXT COLLATE "C" NOT NULL UNIQUE,  -- ours; a file in flights/<id>/files
  created_us BIGINT NOT NULL,
  preview_state BIGINT NOT NULL DEFAULT 0,  -- 0: to be drawn, 1: drawn or tried, 2: not a part of the preview
  PRIMARY KEY(flight_id, name)
);
CREATE INDEX file_to_preview ON file(flight_id) WHERE preview_state = 0;

CREATE TABLE revision(
  flight_id TEXT COLLATE "C" NOT NULL REFERENCES flight(id) ON DELETE CASCADE,
  revision BIGINT NOT NULL,
  created_us BIGINT NOT NULL,
  west DOUBLE PRECISION NOT NULL, south DOUBLE PRECISION NOT NULL, east DOUBLE PRECISION NOT NULL, north DOUBLE PRECISION NOT NULL,
  min_zoom BIGINT NOT NULL,
  max_zoom BIGINT NOT NULL,
  gsd_m DOUBLE PRECISION NOT NULL,
  photos_total BIGINT NOT NULL,
  photos_aligned BIGINT NOT NULL,
  photos_pose_only BIGINT NOT NULL,
  photos_left_out BIGINT NOT NULL,
  first_capture TEXT COLLATE "C" NOT NULL DEFAULT '',  -- of its photos, ISO 8601; '' where it is not known
  last_capture TEXT COLLATE "C" NOT NULL DEFAULT '',
  PRIMARY KEY(flight_id, revision)
);

-- Resumable uploads (tus): the bytes so far are the file uploads/<id>, of which byte_offset are known to be on the disk.
CREATE TABLE upload(
  id TEXT COLLATE "C" PRIMARY KEY,
  flight_id TEXT COLLATE "C" REFERENCES flight(id) ON DELETE CASCADE,  -- NULL: a part of an upload that is still to be put together
  name TEXT COLLATE "C" NOT NULL,  -- the file's, as the user named it
  metadata TEXT COLLATE "C" NOT NULL,  -- as sent, to be sent back
  length BIGINT,  -- NULL: not known yet
  byte_offset BIGINT NOT NULL DEFAULT 0,
  is_done BIGINT NOT NULL DEFAULT 0,  -- 1: it is a file of its flight now
  expires_us BIGINT NOT NULL,
  owner TEXT COLLATE "C" NOT NULL DEFAULT '',  -- id of the token that began it, the only one that may continue it; '' without one
  concat TEXT COLLATE "C" NOT NULL DEFAULT '',  -- 'partial', or 'final;' and the parts it was put together from; '' for any other
  parts TEXT COLLATE "C" NOT NULL DEFAULT ''  -- where photos lie elsewhere: '<key>:<bytes>;...' or '=<stored name>'; '' in the folder
);
CREATE INDEX upload_of_flight ON upload(flight_id);
CREATE INDEX upload_expiry ON upload(expires_us);

-- Maps of flights that are still uploading: coarse, from recorded poses, growing photo by photo.
CREATE TABLE preview(
  flight_id TEXT COLLATE "C" PRIMARY KEY REFERENCES flight(id) ON DELETE CASCADE,
  folder TEXT COLLATE "C" NOT NULL,  -- ours, below flights/<id>
  edition BIGINT NOT NULL,  -- grows with every change
  photos BIGINT NOT NULL,
  min_zoom BIGINT NOT NULL,
  max_zoom BIGINT NOT NULL,
  west DOUBLE PRECISION NOT NULL, south DOUBLE PRECISION NOT NULL, east DOUBLE PRECISION NOT NULL, north DOUBLE PRECISION NOT NULL,
  -- What the latest edition changed.
  changed_west DOUBLE PRECISION NOT NULL, changed_south DOUBLE PRECISION NOT NULL, changed_east DOUBLE PRECISION NOT NULL, changed_north DOUBLE PRECISION NOT NULL
);

-- The queue.
CREATE TABLE job(
  id TEXT COLLATE "C" PRIMARY KEY,
  flight_id TEXT COLLATE "C" NOT NULL REFERENCES flight(id) ON DELETE CASCADE,
  options TEXT COLLATE "C" NOT NULL DEFAULT '{}',
  state TEXT COLLATE "C" NOT NULL CHECK(state IN ('accepted','running','successful','failed','dismissed')),
  priority BIGINT NOT NULL DEFAULT 0,
  stage TEXT COLLATE "C" NOT NULL DEFAULT '',
  progress DOUBLE PRECISION NOT NULL DEFAULT 0,
  message TEXT COLLATE "C" NOT NULL DEFAULT '',
  attempts BIGINT NOT NULL DEFAULT 0,
  max_attempts BIGINT NOT NULL DEFAULT 3,
  not_before_us BIGINT NOT NULL DEFAULT 0,
  lease_until_us BIGINT NOT NULL DEFAULT 0,
  lease_token BIGINT NOT NULL DEFAULT 0,  -- fencing token: grows with every claim; whoever holds an older one has lost the job
  worker TEXT COLLATE "C" NOT NULL DEFAULT '',
  cancel BIGINT NOT NULL DEFAULT 0,
  error_code TEXT COLLATE "C",
  error_message TEXT COLLATE "C",
  created_us BIGINT NOT NULL,
  started_us BIGINT,
  attempt_started_us BIGINT,
  finished_us BIGINT,
  owner TEXT COLLATE "C" NOT NULL DEFAULT '',  -- id of the token that queued it
  expected_s DOUBLE PRECISION,  -- predicted duration of the whole job, from earlier jobs
  expected_low_s DOUBLE PRECISION,
  expected_high_s DOUBLE PRECISION,
  interruptions BIGINT NOT NULL DEFAULT 0,  -- claims that ended through no fault of the job: a restart is not an attempt
  claimed_in TEXT COLLATE "C" NOT NULL DEFAULT '',  -- the boot its worker was last heard in; '': before the server's start
  units_from DOUBLE PRECISION NOT NULL DEFAULT 0,  -- its progress before its units of one kind, and after them
  units_to DOUBLE PRECISION NOT NULL DEFAULT 0
);
CREATE INDEX job_waiting ON job(priority DESC, id) WHERE state = 'accepted';
CREATE INDEX job_leased ON job(lease_until_us) WHERE state = 'running';
CREATE INDEX job_of_flight ON job(flight_id, id);
CREATE INDEX job_of_owner ON job(owner, attempt_started_us);
CREATE INDEX job_waiting_of_owner ON job(owner, priority, id) WHERE state = 'accepted';
CREATE INDEX job_running_of_owner ON job(owner) WHERE state = 'running';

-- The units of jobs that are cut, each for any worker.
CREATE TABLE unit(
  job_id TEXT COLLATE "C" NOT NULL REFERENCES job(id) ON DELETE CASCADE,
  kind TEXT COLLATE "C" NOT NULL,
  number BIGINT NOT NULL,
  items BIGINT NOT NULL,  -- that all units of this kind share: files, blocks
  state TEXT COLLATE "C" NOT NULL CHECK(state IN ('waiting','running','done')),
  attempts BIGINT NOT NULL DEFAULT 0,
  lease_until_us BIGINT NOT NULL DEFAULT 0,
  lease_token BIGINT NOT NULL DEFAULT 0,  -- grows with every claim, as that of a job
  worker TEXT COLLATE "C" NOT NULL DEFAULT '',
  PRIMARY KEY(job_id, kind, number)
);
CREATE INDEX unit_open ON unit(state) WHERE state <> 'done';

-- What the stages of jobs have cost, for predictions.
CREATE TABLE stage_cost(
  job_id TEXT COLLATE "C" NOT NULL,  -- kept when the job is deleted: its cost is still true
  stage TEXT COLLATE "C" NOT NULL,
  photos BIGINT NOT NULL,
  seconds DOUBLE PRECISION NOT NULL,
  PRIMARY KEY(job_id, stage)
);

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

-- Tasks of the NodeODM-compatible node: each is a flight under the UUID that its clients know.
CREATE TABLE node_task(
  uuid TEXT COLLATE "C" PRIMARY KEY,
  flight_id TEXT COLLATE "C" NOT NULL UNIQUE REFERENCES flight(id) ON DELETE CASCADE,
  options TEXT COLLATE "C" NOT NULL DEFAULT '[]',  -- JSON list of {name, value}, as the client may see it again
  created_ms BIGINT NOT NULL,  -- the client's date
  is_committed BIGINT NOT NULL DEFAULT 0,  -- 0: its files are still coming
  notes TEXT COLLATE "C" NOT NULL DEFAULT '',  -- what its client should know, a line each
  outputs TEXT COLLATE "C" NOT NULL DEFAULT '[]',  -- JSON list of the paths that all.zip shall hold; empty: the usual ones
  webhook TEXT COLLATE "C" NOT NULL DEFAULT '',  -- address that is told of the task's end; '': nobody
  canceled_job TEXT COLLATE "C" NOT NULL DEFAULT ''  -- the job that a client cancelled, ended or not
);

-- Who may do what. Only the SHA-256 of a token is stored, never the token.
CREATE TABLE token(
  id TEXT COLLATE "C" PRIMARY KEY,
  name TEXT COLLATE "C" NOT NULL UNIQUE,
  hash BYTEA NOT NULL UNIQUE,
  scope TEXT COLLATE "C" NOT NULL CHECK(scope IN ('read','upload','admin')),
  created_us BIGINT NOT NULL,
  expires_us BIGINT,  -- NULL: never
  most_bytes BIGINT,  -- quota of stored files; NULL: as much as the disk holds
  requests_per_minute BIGINT,  -- NULL: unlimited
  flight_id TEXT COLLATE "C" REFERENCES flight(id) ON DELETE CASCADE  -- a token for reading this flight alone, deleted with it; NULL: all flights
);
CREATE INDEX token_of_flight ON token(flight_id) WHERE flight_id IS NOT NULL;

-- Set once there has been a token: when the last one is revoked or expires, the server stays closed.
CREATE TABLE token_policy(
  id BIGINT PRIMARY KEY CHECK(id = 1),
  asks_for_token BIGINT NOT NULL
);
INSERT INTO token_policy VALUES(1, 0);

-- Answers to requests that a client may send again under the same key. An answer is repeated only to the token that got it.
CREATE TABLE idempotent_answer(
  owner TEXT COLLATE "C" NOT NULL,  -- id of the token that sent the request; '' without one
  key TEXT COLLATE "C" NOT NULL,
  route TEXT COLLATE "C" NOT NULL,  -- method and path
  fingerprint BYTEA NOT NULL,  -- SHA-256 of the request's body, or of its form's parts
  status BIGINT NOT NULL,
  location TEXT COLLATE "C" NOT NULL,
  body TEXT COLLATE "C" NOT NULL,
  created_us BIGINT NOT NULL,
  PRIMARY KEY(owner, key, route)
);
CREATE INDEX idempotent_answer_age ON idempotent_answer(created_us);

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

-- Addresses that are notified when a job ends or a map is shown, and the messages that are still to be sent.
CREATE TABLE webhook(
  id TEXT COLLATE "C" PRIMARY KEY,
  url TEXT COLLATE "C" NOT NULL,
  secret TEXT COLLATE "C" NOT NULL,  -- shared with the receiver; messages are signed with it
  created_us BIGINT NOT NULL
);

CREATE TABLE webhook_delivery(
  webhook_id TEXT COLLATE "C" NOT NULL REFERENCES webhook(id) ON DELETE CASCADE,
  event_seq BIGINT NOT NULL,
  body TEXT COLLATE "C" NOT NULL,  -- JSON, as it is sent
  attempts BIGINT NOT NULL DEFAULT 0,
  not_before_us BIGINT NOT NULL DEFAULT 0,
  PRIMARY KEY(webhook_id, event_seq)
);
CREATE INDEX webhook_delivery_due ON webhook_delivery(not_before_us);

-- Ends of tasks of the NodeODM-compatible node that are still to be told to the address that came with the task.
CREATE TABLE node_delivery(
  uuid TEXT COLLATE "C" NOT NULL REFERENCES node_task(uuid) ON DELETE CASCADE,
  job_id TEXT COLLATE "C" NOT NULL,
  attempts BIGINT NOT NULL DEFAULT 0,
  not_before_us BIGINT NOT NULL DEFAULT 0,
  PRIMARY KEY(uuid, job_id)
);
CREATE INDEX node_delivery_due ON node_delivery(not_before_us);

-- The time by which uploads and the trash expire (storage/db/age_clock.h): goes by the server's clock, but by no more than
-- an hour at a time, and never back.
CREATE TABLE age_clock(
  id BIGINT PRIMARY KEY CHECK(id = 1),
  age_us BIGINT NOT NULL,
  seen_us BIGINT NOT NULL  -- what the server's clock showed when it was last put forward
);
INSERT INTO age_clock VALUES(1, now_us(), now_us());

-- The id of the data folder that this catalogue belongs to: the one in its marker, skyquilt-data.json.
CREATE TABLE data_dir(
  one BIGINT PRIMARY KEY CHECK(one = 1),
  id TEXT COLLATE "C" NOT NULL
);
