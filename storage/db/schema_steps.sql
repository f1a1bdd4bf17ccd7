-- The way from each version of a catalogue since 13 to the next, in PostgreSQL since 16, until it is that of schema.sql and of
-- schema_sqlite.sql. Whoever stands at a version says all that stands below the line of the next one.

-- To version 14: parts of uploads, which have no flight yet, and what clients of the NodeODM-compatible node say of a task.
ALTER TABLE upload RENAME TO upload_13;
DROP INDEX upload_of_flight;
DROP INDEX upload_expiry;
CREATE TABLE upload(
  id TEXT PRIMARY KEY,
  flight_id TEXT REFERENCES flight(id) ON DELETE CASCADE,
  name TEXT NOT NULL,
  metadata TEXT NOT NULL,
  length INTEGER,
  byte_offset INTEGER NOT NULL DEFAULT 0,
  is_done INTEGER NOT NULL DEFAULT 0,
  expires_us INTEGER NOT NULL,
  owner TEXT NOT NULL DEFAULT '',
  concat TEXT NOT NULL DEFAULT ''
) STRICT;
CREATE INDEX upload_of_flight ON upload(flight_id);
CREATE INDEX upload_expiry ON upload(expires_us);
INSERT INTO upload(id, flight_id, name, metadata, length, byte_offset, is_done, expires_us, owner)
  SELECT id, flight_id, name, metadata, length, byte_offset, is_done, expires_us, owner FROM upload_13;
DROP TABLE upload_13;

ALTER TABLE node_task ADD COLUMN notes TEXT NOT NULL DEFAULT '';
ALTER TABLE node_task ADD COLUMN outputs TEXT NOT NULL DEFAULT '[]';
ALTER TABLE node_task ADD COLUMN webhook TEXT NOT NULL DEFAULT '';
ALTER TABLE node_task ADD COLUMN canceled_job TEXT NOT NULL DEFAULT '';

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

-- To version 15: when the photos of a map were taken; of maps made before it is not known.
ALTER TABLE revision ADD COLUMN first_capture TEXT NOT NULL DEFAULT '';
ALTER TABLE revision ADD COLUMN last_capture TEXT NOT NULL DEFAULT '';

-- To version 16: jobs that are cut into units, and where the bytes of a resumable upload are that do not lie in the data
-- folder.
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

-- To version 17: exports of maps.
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
  expires_us INTEGER                           -- by the AgeClock; NULL: it waits or runs
) STRICT;
CREATE INDEX map_export_of_flight ON map_export(flight_id, id);
CREATE INDEX map_export_open ON map_export(id) WHERE state IN ('accepted','running');
CREATE INDEX map_export_expiry ON map_export(expires_us);

-- To version 18: since when nothing has changed in a flight.
CREATE TABLE idle_flight(
  flight_id TEXT PRIMARY KEY REFERENCES flight(id) ON DELETE CASCADE,
  seen TEXT NOT NULL,                          -- digest of what was seen of it, to tell whether it changed
  since_us INTEGER NOT NULL                    -- by the AgeClock: it was not in use since, and is as it was then
) STRICT;

-- To version 19: tags of flights, and which of them are to be kept.
ALTER TABLE flight ADD COLUMN tags TEXT NOT NULL DEFAULT '';
ALTER TABLE flight ADD COLUMN is_kept INTEGER NOT NULL DEFAULT 0;

-- To version 20: since when units wait.
ALTER TABLE unit ADD COLUMN waiting_us INTEGER NOT NULL DEFAULT 0;
UPDATE unit SET waiting_us = CAST(strftime('%s', 'now') AS INTEGER) * 1000000;

-- To version 21: how true a map is; of maps made before it is not known.
ALTER TABLE revision ADD COLUMN quality TEXT NOT NULL DEFAULT '';

-- To version 22: where photos and maps lie, since when units are at work, and which workers stand aside.
ALTER TABLE data_dir ADD COLUMN blobs TEXT NOT NULL DEFAULT '';
ALTER TABLE unit ADD COLUMN since_us INTEGER NOT NULL DEFAULT 0;
CREATE TABLE worker_aside(
  worker TEXT PRIMARY KEY,
  since_us INTEGER NOT NULL,
  until_us INTEGER NOT NULL,
  times INTEGER NOT NULL,
  code TEXT NOT NULL,
  message TEXT NOT NULL
) STRICT;
-- Jobs that waited for their units when their flight went to the trash: nobody would ever end them.
UPDATE job SET state = 'dismissed', finished_us = CAST(strftime('%s', 'now') AS INTEGER) * 1000000
  WHERE state = 'running' AND worker = 'units' AND cancel = 1;

-- To version 23: whose units a job goes on with, by what they were made from, how often machines in trouble gave work back,
-- and what the files of maps in a store are.
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

-- To version 24: why jobs and exports failed, as a code with its values; of those that failed before there is the message
-- alone.
ALTER TABLE job ADD COLUMN error_reason TEXT NOT NULL DEFAULT '';
ALTER TABLE map_export ADD COLUMN error_reason TEXT NOT NULL DEFAULT '';
