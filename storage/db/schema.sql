-- The catalogue: flights and their files, uploads under way, maps and previews, the queue of jobs, tokens, webhooks and the
-- trash, in either engine: schema.cc has its words in PostgreSQL. What each engine has otherwise, and its triggers, are in
-- schema_sqlite.sql and in postgres/. Times (`..._us`) are microseconds since 1970, UTC. Its number is kSchemaVersion in schema.h.

-- Flights, their files and their finished maps.
CREATE TABLE flight(
  id TEXT PRIMARY KEY,
  name TEXT NOT NULL,
  created_us INTEGER NOT NULL,
  options TEXT NOT NULL DEFAULT '{}',          -- JSON, as the user gave it
  active_revision INTEGER,
  next_revision INTEGER NOT NULL DEFAULT 1,
  owner TEXT NOT NULL DEFAULT '',              -- id of the token that made it; '' without one
  deleted_us INTEGER,                          -- by the machine's clock, for display; NULL: not in the trash
  deleted_age_us INTEGER,                      -- by the AgeClock: the days in the trash count from here
  tags TEXT NOT NULL DEFAULT '',               -- each between line breaks; see storage/tags/flight_tags.h
  is_kept INTEGER NOT NULL DEFAULT 0           -- 1: it never goes to the trash by itself
) STRICT;
CREATE INDEX flight_of_owner ON flight(owner);
CREATE INDEX flight_in_trash ON flight(deleted_age_us) WHERE deleted_us IS NOT NULL;

CREATE TABLE file(
  flight_id TEXT NOT NULL REFERENCES flight(id) ON DELETE CASCADE,
  name TEXT NOT NULL,                          -- the user's; never a path
  bytes INTEGER NOT NULL,
  stored_name TEXT NOT NULL UNIQUE,            -- ours; a file in flights/<id>/files
  created_us INTEGER NOT NULL,
  preview_state INTEGER NOT NULL DEFAULT 0,    -- 0: to be drawn, 1: drawn or tried, 2: not a part of the preview
  PRIMARY KEY(flight_id, name)
) STRICT;
CREATE INDEX file_to_preview ON file(flight_id) WHERE preview_state = 0;

CREATE TABLE revision(
  flight_id TEXT NOT NULL REFERENCES flight(id) ON DELETE CASCADE,
  revision INTEGER NOT NULL,
  created_us INTEGER NOT NULL,
  west REAL NOT NULL, south REAL NOT NULL, east REAL NOT NULL, north REAL NOT NULL,
  min_zoom INTEGER NOT NULL,
  max_zoom INTEGER NOT NULL,
  gsd_m REAL NOT NULL,
  photos_total INTEGER NOT NULL,
  photos_aligned INTEGER NOT NULL,
  photos_pose_only INTEGER NOT NULL,
  photos_left_out INTEGER NOT NULL,
  first_capture TEXT NOT NULL DEFAULT '',      -- of its photos, ISO 8601; '' where it is not known
  last_capture TEXT NOT NULL DEFAULT '',
  quality TEXT NOT NULL DEFAULT '',            -- JSON, as report.json has it; '' where it is not known
  PRIMARY KEY(flight_id, revision)
) STRICT;

-- The files of maps that lie in a store, by which those who can write to the store alone cannot replace a map.
CREATE TABLE product(
  flight_id TEXT NOT NULL,
  revision INTEGER NOT NULL,
  name TEXT NOT NULL,                          -- below the map's prefix
  sha256 TEXT NOT NULL,                        -- in hex
  PRIMARY KEY(flight_id, revision, name),
  FOREIGN KEY(flight_id, revision) REFERENCES revision(flight_id, revision) ON DELETE CASCADE
) STRICT;

-- Resumable uploads (tus): the bytes so far are the file uploads/<id>, of which byte_offset are known to be on the disk.
CREATE TABLE upload(
  id TEXT PRIMARY KEY,
  flight_id TEXT REFERENCES flight(id) ON DELETE CASCADE,  -- NULL: a part of an upload that is still to be put together
  name TEXT NOT NULL,                          -- the file's, as the user named it
  metadata TEXT NOT NULL,                      -- as sent, to be sent back
  length INTEGER,                              -- NULL: not known yet
  byte_offset INTEGER NOT NULL DEFAULT 0,
  is_done INTEGER NOT NULL DEFAULT 0,          -- 1: it is a file of its flight now
  expires_us INTEGER NOT NULL,
  owner TEXT NOT NULL DEFAULT '',              -- id of the token that began it, the only one that may continue it; '' without one
  concat TEXT NOT NULL DEFAULT '',             -- 'partial', or 'final;' and the parts it was put together from; '' for any other
  parts TEXT NOT NULL DEFAULT ''               -- where photos lie elsewhere: '<key>:<bytes>;...' or '=<stored name>'; '' in the folder
) STRICT;
CREATE INDEX upload_of_flight ON upload(flight_id);
CREATE INDEX upload_expiry ON upload(expires_us);

-- Maps of flights that are still uploading: coarse, from recorded poses, growing photo by photo.
CREATE TABLE preview(
  flight_id TEXT PRIMARY KEY REFERENCES flight(id) ON DELETE CASCADE,
  folder TEXT NOT NULL,                        -- ours, below flights/<id>
  edition INTEGER NOT NULL,                    -- grows with every change
  photos INTEGER NOT NULL,
  min_zoom INTEGER NOT NULL,
  max_zoom INTEGER NOT NULL,
  west REAL NOT NULL, south REAL NOT NULL, east REAL NOT NULL, north REAL NOT NULL,
  -- What the latest edition changed.
  changed_west REAL NOT NULL, changed_south REAL NOT NULL, changed_east REAL NOT NULL, changed_north REAL NOT NULL
) STRICT;

-- The queue.
CREATE TABLE job(
  id TEXT PRIMARY KEY,
  flight_id TEXT NOT NULL REFERENCES flight(id) ON DELETE CASCADE,
  options TEXT NOT NULL DEFAULT '{}',
  state TEXT NOT NULL CHECK(state IN ('accepted','running','successful','failed','dismissed')),
  priority INTEGER NOT NULL DEFAULT 0,
  stage TEXT NOT NULL DEFAULT '',
  progress REAL NOT NULL DEFAULT 0,
  message TEXT NOT NULL DEFAULT '',
  attempts INTEGER NOT NULL DEFAULT 0,
  max_attempts INTEGER NOT NULL DEFAULT 3,
  not_before_us INTEGER NOT NULL DEFAULT 0,
  lease_until_us INTEGER NOT NULL DEFAULT 0,
  lease_token INTEGER NOT NULL DEFAULT 0,      -- fencing token: grows with every claim; whoever holds an older one has lost the job
  worker TEXT NOT NULL DEFAULT '',
  cancel INTEGER NOT NULL DEFAULT 0,
  error_code TEXT,
  error_message TEXT,
  created_us INTEGER NOT NULL,
  started_us INTEGER,
  attempt_started_us INTEGER,
  finished_us INTEGER,
  owner TEXT NOT NULL DEFAULT '',              -- id of the token that queued it
  expected_s REAL,                             -- predicted duration of the whole job, from earlier jobs
  expected_low_s REAL,
  expected_high_s REAL,
  interruptions INTEGER NOT NULL DEFAULT 0,    -- claims that ended through no fault of the job: a restart is not an attempt
  claimed_in TEXT NOT NULL DEFAULT '',         -- the boot its worker was last heard in; '': before the server's start
  units_from REAL NOT NULL DEFAULT 0,          -- its progress before its units of one kind, and after them
  units_to REAL NOT NULL DEFAULT 0,
  units_of TEXT NOT NULL DEFAULT '',           -- the job under whose id its units lie, itself or one that failed; '': not cut
  made_from TEXT NOT NULL DEFAULT '',          -- digest of what its units are made from
  troubles INTEGER NOT NULL DEFAULT 0,         -- of machines that gave it back
  error_reason TEXT NOT NULL DEFAULT ''        -- JSON of a remark that says what the message does; '': that alone tells
) STRICT;
CREATE INDEX job_waiting ON job(priority DESC, id) WHERE state = 'accepted';
CREATE INDEX job_leased ON job(lease_until_us) WHERE state = 'running';
CREATE INDEX job_of_flight ON job(flight_id, id);
CREATE INDEX job_of_owner ON job(owner, attempt_started_us);
CREATE INDEX job_waiting_of_owner ON job(owner, priority, id) WHERE state = 'accepted';
CREATE INDEX job_running_of_owner ON job(owner) WHERE state = 'running';

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
  waiting_us INTEGER NOT NULL DEFAULT 0,       -- since when it waits, or last did
  since_us INTEGER NOT NULL DEFAULT 0,         -- since when its present worker has it
  troubles INTEGER NOT NULL DEFAULT 0,         -- as of a job
  PRIMARY KEY(job_id, kind, number)
) STRICT;
CREATE INDEX unit_open ON unit(state) WHERE state <> 'done';

-- Workers whose machines were in trouble: they take nothing until then.
CREATE TABLE worker_aside(
  worker TEXT PRIMARY KEY,                     -- as in job and unit
  since_us INTEGER NOT NULL,                   -- since its first trouble with nothing done since
  until_us INTEGER NOT NULL,                   -- then it tries again
  times INTEGER NOT NULL,                      -- that trouble came, one after the other
  code TEXT NOT NULL,
  message TEXT NOT NULL
) STRICT;

-- What the stages of jobs have cost, for predictions.
CREATE TABLE stage_cost(
  job_id TEXT NOT NULL,                        -- kept when the job is deleted: its cost is still true
  stage TEXT NOT NULL,
  photos INTEGER NOT NULL,
  seconds REAL NOT NULL,
  PRIMARY KEY(job_id, stage)
) STRICT;

-- Tasks of the NodeODM-compatible node: each is a flight under the UUID that its clients know.
CREATE TABLE node_task(
  uuid TEXT PRIMARY KEY,
  flight_id TEXT NOT NULL UNIQUE REFERENCES flight(id) ON DELETE CASCADE,
  options TEXT NOT NULL DEFAULT '[]',          -- JSON list of {name, value}, as the client may see it again
  created_ms INTEGER NOT NULL,                 -- the client's date
  is_committed INTEGER NOT NULL DEFAULT 0,     -- 0: its files are still coming
  notes TEXT NOT NULL DEFAULT '',              -- what its client should know, a line each
  outputs TEXT NOT NULL DEFAULT '[]',          -- JSON list of the paths that all.zip shall hold; empty: the usual ones
  webhook TEXT NOT NULL DEFAULT '',            -- address that is told of the task's end; '': nobody
  canceled_job TEXT NOT NULL DEFAULT ''        -- the job that a client cancelled, ended or not
) STRICT;

-- Who may do what. Only the SHA-256 of a token is stored, never the token.
CREATE TABLE token(
  id TEXT PRIMARY KEY,
  name TEXT NOT NULL UNIQUE,
  hash BLOB NOT NULL UNIQUE,
  scope TEXT NOT NULL CHECK(scope IN ('read','upload','admin')),
  created_us INTEGER NOT NULL,
  expires_us INTEGER,                          -- NULL: never
  most_bytes INTEGER,                          -- quota of stored files; NULL: as much as the disk holds
  requests_per_minute INTEGER,                 -- NULL: unlimited
  flight_id TEXT REFERENCES flight(id) ON DELETE CASCADE  -- a token for reading this flight alone, deleted with it; NULL: all flights
) STRICT;
CREATE INDEX token_of_flight ON token(flight_id) WHERE flight_id IS NOT NULL;

-- Set once there has been a token: when the last one is revoked or expires, the server stays closed.
CREATE TABLE token_policy(
  id INTEGER PRIMARY KEY CHECK(id = 1),
  asks_for_token INTEGER NOT NULL
) STRICT;
INSERT INTO token_policy VALUES(1, 0);

-- Answers to requests that a client may send again under the same key. An answer is repeated only to the token that got it.
CREATE TABLE idempotent_answer(
  owner TEXT NOT NULL,                         -- id of the token that sent the request; '' without one
  key TEXT NOT NULL,
  route TEXT NOT NULL,                         -- method and path
  fingerprint BLOB NOT NULL,                   -- SHA-256 of the request's body, or of its form's parts
  status INTEGER NOT NULL,
  location TEXT NOT NULL,
  body TEXT NOT NULL,
  created_us INTEGER NOT NULL,
  PRIMARY KEY(owner, key, route)
) STRICT;
CREATE INDEX idempotent_answer_age ON idempotent_answer(created_us);

-- Addresses that are notified when a job ends or a map is shown, and the messages that are still to be sent.
CREATE TABLE webhook(
  id TEXT PRIMARY KEY,
  url TEXT NOT NULL,
  secret TEXT NOT NULL,                        -- shared with the receiver; messages are signed with it
  created_us INTEGER NOT NULL
) STRICT;

CREATE TABLE webhook_delivery(
  webhook_id TEXT NOT NULL REFERENCES webhook(id) ON DELETE CASCADE,
  event_seq INTEGER NOT NULL,
  body TEXT NOT NULL,                          -- JSON, as it is sent
  attempts INTEGER NOT NULL DEFAULT 0,
  not_before_us INTEGER NOT NULL DEFAULT 0,
  PRIMARY KEY(webhook_id, event_seq)
) STRICT;
CREATE INDEX webhook_delivery_due ON webhook_delivery(not_before_us);

-- Ends of tasks of the NodeODM-compatible node that are still to be told to the address that came with the task.
CREATE TABLE node_delivery(
  uuid TEXT NOT NULL REFERENCES node_task(uuid) ON DELETE CASCADE,
  job_id TEXT NOT NULL,
  attempts INTEGER NOT NULL DEFAULT 0,
  not_before_us INTEGER NOT NULL DEFAULT 0,
  PRIMARY KEY(uuid, job_id)
) STRICT;
CREATE INDEX node_delivery_due ON node_delivery(not_before_us);

-- Exports of maps that somebody asked for: the file is exports/<id>.<ending> below the flight's folder, once it is made.
CREATE TABLE map_export(
  id TEXT PRIMARY KEY,
  flight_id TEXT NOT NULL REFERENCES flight(id) ON DELETE CASCADE,
  revision INTEGER NOT NULL,                   -- the map that it is of
  request TEXT NOT NULL,                       -- JSON, as it was asked for
  format TEXT NOT NULL,
  owner TEXT NOT NULL DEFAULT '',              -- id of the token that asked for it
  state TEXT NOT NULL CHECK(state IN ('accepted','running','successful','failed')),
  progress REAL NOT NULL DEFAULT 0,
  attempts INTEGER NOT NULL DEFAULT 0,
  lease_until_us INTEGER NOT NULL DEFAULT 0,
  lease_token INTEGER NOT NULL DEFAULT 0,      -- grows with every claim, as that of a job
  bytes INTEGER NOT NULL DEFAULT 0,
  error_code TEXT NOT NULL DEFAULT '',
  error_message TEXT NOT NULL DEFAULT '',
  created_us INTEGER NOT NULL,
  finished_us INTEGER,
  expires_us INTEGER,                          -- by the AgeClock; NULL: it waits or runs
  error_reason TEXT NOT NULL DEFAULT ''        -- as of a job
) STRICT;
CREATE INDEX map_export_of_flight ON map_export(flight_id, id);
CREATE INDEX map_export_open ON map_export(id) WHERE state IN ('accepted','running');
CREATE INDEX map_export_expiry ON map_export(expires_us);

-- Since when nothing has changed in a flight, where the server is to put such flights into the trash.
CREATE TABLE idle_flight(
  flight_id TEXT PRIMARY KEY REFERENCES flight(id) ON DELETE CASCADE,
  seen TEXT NOT NULL,                          -- digest of what was seen of it, to tell whether it changed
  since_us INTEGER NOT NULL                    -- by the AgeClock: it was not in use since, and is as it was then
) STRICT;

-- The id of the data folder that this catalogue belongs to: the one in its marker, skyquilt-data.json.
CREATE TABLE data_dir(
  one INTEGER PRIMARY KEY CHECK(one = 1),
  id TEXT NOT NULL,
  blobs TEXT NOT NULL DEFAULT ''               -- where photos and maps lie, in PostgreSQL alone: a folder knows it by blobs.json
) STRICT;
