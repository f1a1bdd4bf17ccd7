-- The catalogue: flights and their files, uploads under way, maps and previews, the queue of jobs, tokens, events,
-- webhooks and the trash. Times (`..._us`) are microseconds since 1970, UTC. Its number is kSchemaVersion in schema.cc.

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

-- Deleting a photo deletes the whole preview: the remaining photos are drawn anew.
CREATE TRIGGER previewed_file_gone AFTER DELETE ON file WHEN OLD.preview_state = 1 BEGIN
  DELETE FROM preview WHERE flight_id = OLD.flight_id;
  UPDATE file SET preview_state = 0 WHERE flight_id = OLD.flight_id;
END;

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

CREATE TRIGGER units_end AFTER UPDATE OF state ON job WHEN NEW.state NOT IN ('accepted','running') BEGIN
  DELETE FROM unit WHERE job_id = NEW.id;
END;

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

-- Owners with waiting jobs, so that a claim finds whose turn it is without reading every job.
CREATE TABLE turn(
  owner TEXT NOT NULL,                         -- of jobs; '' is one too
  priority INTEGER NOT NULL,
  waiting INTEGER NOT NULL,                    -- jobs of this owner and priority in state 'accepted'; never 0
  last_us INTEGER NOT NULL,                    -- when the latest attempt at a job of this owner began; 0: none yet
  first_id TEXT NOT NULL,                      -- the first of the waiting jobs
  PRIMARY KEY(owner, priority)
) STRICT, WITHOUT ROWID;
CREATE INDEX turn_in_order ON turn(priority DESC, last_us, first_id, owner);

CREATE TRIGGER turn_waits AFTER INSERT ON job WHEN NEW.state = 'accepted' BEGIN
  INSERT INTO turn VALUES(NEW.owner, NEW.priority, 1,
    (SELECT coalesce(max(attempt_started_us), 0) FROM job WHERE owner = NEW.owner), NEW.id)
    ON CONFLICT(owner, priority) DO UPDATE SET waiting = waiting + 1, first_id = min(first_id, NEW.id);
END;

CREATE TRIGGER turn_waits_again AFTER UPDATE OF state, owner, priority ON job WHEN NEW.state = 'accepted' AND
    (OLD.state <> 'accepted' OR OLD.owner <> NEW.owner OR OLD.priority <> NEW.priority) BEGIN
  INSERT INTO turn VALUES(NEW.owner, NEW.priority, 1,
    (SELECT coalesce(max(attempt_started_us), 0) FROM job WHERE owner = NEW.owner), NEW.id)
    ON CONFLICT(owner, priority) DO UPDATE SET waiting = waiting + 1, first_id = min(first_id, NEW.id);
END;

CREATE TRIGGER turn_waits_no_more AFTER UPDATE OF state, owner, priority ON job WHEN OLD.state = 'accepted' AND
    (NEW.state <> 'accepted' OR OLD.owner <> NEW.owner OR OLD.priority <> NEW.priority) BEGIN
  UPDATE turn SET waiting = waiting - 1, first_id = coalesce((SELECT min(id) FROM job WHERE state = 'accepted'
      AND owner = OLD.owner AND priority = OLD.priority), first_id)
    WHERE owner = OLD.owner AND priority = OLD.priority;
  DELETE FROM turn WHERE owner = OLD.owner AND priority = OLD.priority AND waiting = 0;
END;

CREATE TRIGGER turn_goes AFTER DELETE ON job WHEN OLD.state = 'accepted' BEGIN
  UPDATE turn SET waiting = waiting - 1, first_id = coalesce((SELECT min(id) FROM job WHERE state = 'accepted'
      AND owner = OLD.owner AND priority = OLD.priority), first_id)
    WHERE owner = OLD.owner AND priority = OLD.priority;
  DELETE FROM turn WHERE owner = OLD.owner AND priority = OLD.priority AND waiting = 0;
END;

CREATE TRIGGER turn_taken AFTER UPDATE OF attempt_started_us ON job WHEN NEW.attempt_started_us IS NOT NULL BEGIN
  UPDATE turn SET last_us = NEW.attempt_started_us WHERE owner = NEW.owner AND last_us < NEW.attempt_started_us;
END;

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
CREATE TRIGGER token_added AFTER INSERT ON token BEGIN
  UPDATE token_policy SET asks_for_token = 1;
END;
-- The same for a catalogue rebuilt from the flights on disk: a flight with an owner had a token.
CREATE TRIGGER owned_flight_added AFTER INSERT ON flight WHEN NEW.owner <> '' BEGIN
  UPDATE token_policy SET asks_for_token = 1;
END;

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

-- Events of all flights in one order, written by triggers so that no change can be missed.
CREATE TABLE event(
  seq INTEGER PRIMARY KEY AUTOINCREMENT,
  at_us INTEGER NOT NULL DEFAULT (CAST((julianday('now') - 2440587.5) * 86400000000 AS INTEGER)),
  flight_id TEXT NOT NULL,
  job_id TEXT,
  kind TEXT NOT NULL,                          -- job, map, file, preview, deleted, restored
  body TEXT NOT NULL                           -- JSON
) STRICT;
CREATE INDEX event_of_flight ON event(flight_id, seq);
CREATE INDEX event_of_job ON event(job_id, seq) WHERE job_id IS NOT NULL;

CREATE TRIGGER event_pruned AFTER INSERT ON event WHEN NEW.seq % 1000 = 0 BEGIN
  DELETE FROM event WHERE seq < NEW.seq - 50000;
END;

CREATE TRIGGER job_added AFTER INSERT ON job BEGIN
  INSERT INTO event(flight_id, job_id, kind, body) VALUES(NEW.flight_id, NEW.id, 'job',
    json_object('state', NEW.state, 'stage', NEW.stage, 'progress', NEW.progress, 'attempts', NEW.attempts));
END;

CREATE TRIGGER job_moved AFTER UPDATE OF state, stage ON job
WHEN NEW.state <> OLD.state OR NEW.stage <> OLD.stage BEGIN
  INSERT INTO event(flight_id, job_id, kind, body) VALUES(NEW.flight_id, NEW.id, 'job',
    json_object('state', NEW.state, 'stage', NEW.stage, 'progress', NEW.progress, 'attempts', NEW.attempts,
                'error', NEW.error_message));
END;

CREATE TRIGGER map_shown AFTER UPDATE OF active_revision ON flight
WHEN NEW.active_revision IS NOT OLD.active_revision BEGIN
  INSERT INTO event(flight_id, kind, body)
    SELECT NEW.id, 'map', json_object('revision', revision, 'bounds', json_array(west, south, east, north))
    FROM revision WHERE flight_id = NEW.id AND revision = NEW.active_revision;
END;

CREATE TRIGGER file_added AFTER INSERT ON file BEGIN
  INSERT INTO event(flight_id, kind, body) VALUES(NEW.flight_id, 'file', json_object('name', NEW.name, 'bytes', NEW.bytes));
END;

CREATE TRIGGER flight_trashed AFTER UPDATE OF deleted_us ON flight
WHEN NEW.deleted_us IS NOT NULL AND OLD.deleted_us IS NULL BEGIN
  INSERT INTO event(flight_id, kind, body) VALUES(NEW.id, 'deleted', '{"in_trash":true}');
END;

CREATE TRIGGER flight_restored AFTER UPDATE OF deleted_us ON flight
WHEN NEW.deleted_us IS NULL AND OLD.deleted_us IS NOT NULL BEGIN
  INSERT INTO event(flight_id, kind, body) VALUES(NEW.id, 'restored', '{}');
END;

CREATE TRIGGER flight_deleted AFTER DELETE ON flight BEGIN
  DELETE FROM event WHERE flight_id = OLD.id;
  INSERT INTO event(flight_id, kind, body) VALUES(OLD.id, 'deleted', '{"in_trash":false}');
END;

CREATE TRIGGER preview_begun AFTER INSERT ON preview BEGIN
  INSERT INTO event(flight_id, kind, body) VALUES(NEW.flight_id, 'preview',
    json_object('edition', NEW.edition, 'photos', NEW.photos,
                'bounds', json_array(NEW.west, NEW.south, NEW.east, NEW.north),
                'changed', json_array(NEW.changed_west, NEW.changed_south, NEW.changed_east, NEW.changed_north)));
END;

CREATE TRIGGER preview_grown AFTER UPDATE OF edition ON preview BEGIN
  INSERT INTO event(flight_id, kind, body) VALUES(NEW.flight_id, 'preview',
    json_object('edition', NEW.edition, 'photos', NEW.photos,
                'bounds', json_array(NEW.west, NEW.south, NEW.east, NEW.north),
                'changed', json_array(NEW.changed_west, NEW.changed_south, NEW.changed_east, NEW.changed_north)));
END;

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

-- In the transaction of the event itself: a message is queued for every event that happened and for no other.
CREATE TRIGGER event_to_tell AFTER INSERT ON event
WHEN NEW.kind = 'map'
  OR (NEW.kind = 'job' AND json_extract(NEW.body, '$.state') IN ('successful', 'failed', 'dismissed')) BEGIN
  INSERT INTO webhook_delivery(webhook_id, event_seq, body)
    SELECT id, NEW.seq, json_object('seq', NEW.seq, 'event', NEW.kind, 'flight_id', NEW.flight_id, 'job_id', NEW.job_id,
                                    NEW.kind, json(NEW.body)) FROM webhook;
END;

-- Ends of tasks of the NodeODM-compatible node that are still to be told to the address that came with the task.
CREATE TABLE node_delivery(
  uuid TEXT NOT NULL REFERENCES node_task(uuid) ON DELETE CASCADE,
  job_id TEXT NOT NULL,
  attempts INTEGER NOT NULL DEFAULT 0,
  not_before_us INTEGER NOT NULL DEFAULT 0,
  PRIMARY KEY(uuid, job_id)
) STRICT;
CREATE INDEX node_delivery_due ON node_delivery(not_before_us);

CREATE TRIGGER node_task_to_tell AFTER INSERT ON event
WHEN NEW.kind = 'job' AND json_extract(NEW.body, '$.state') IN ('successful', 'failed', 'dismissed') BEGIN
  INSERT OR IGNORE INTO node_delivery(uuid, job_id)
    SELECT uuid, NEW.job_id FROM node_task WHERE flight_id = NEW.flight_id AND webhook <> '';
END;

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

-- The time by which uploads and the trash expire (storage/db/age_clock.h): independent of the machine's clock once it runs.
CREATE TABLE age_clock(
  id INTEGER PRIMARY KEY CHECK(id = 1),
  age_us INTEGER NOT NULL,                     -- at `since_boot_us` of the boot `boot_id`
  boot_id TEXT NOT NULL,
  since_boot_us INTEGER NOT NULL
) STRICT;
INSERT INTO age_clock VALUES(1, CAST((julianday('now') - 2440587.5) * 86400000000 AS INTEGER), '', 0);

-- The id of the data folder that this catalogue belongs to: the one in its marker, skyquilt-data.json.
CREATE TABLE data_dir(
  one INTEGER PRIMARY KEY CHECK(one = 1),
  id TEXT NOT NULL,
  blobs TEXT NOT NULL DEFAULT ''               -- where photos and maps lie, in PostgreSQL alone: a folder knows it by blobs.json
) STRICT;
