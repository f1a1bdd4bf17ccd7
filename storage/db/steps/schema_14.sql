-- From a catalogue of version 13 to one of version 14: parts of uploads, which have no flight yet, and what clients of
-- the NodeODM-compatible node say of a task. The outcome is that of schema.sql.
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
