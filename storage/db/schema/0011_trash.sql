-- Deleted flights can be taken back for a while.
ALTER TABLE flight ADD COLUMN deleted_us INTEGER;      -- by the machine's clock, to be shown; NULL: it is not in the trash
ALTER TABLE flight ADD COLUMN deleted_age_us INTEGER;  -- by the AgeClock: from then its days count
CREATE INDEX flight_in_trash ON flight(deleted_age_us) WHERE deleted_us IS NOT NULL;

-- Events of a new kind: the CHECK of the old ones can only be left out by a new table, and the triggers come anew with it.
DROP TRIGGER job_added;
DROP TRIGGER job_moved;
DROP TRIGGER map_shown;
DROP TRIGGER file_added;
DROP TRIGGER flight_deleted;
DROP TRIGGER event_pruned;
DROP TRIGGER event_to_tell;
DROP TRIGGER preview_begun;
DROP TRIGGER preview_grown;

CREATE TABLE event_of_any_kind(
  seq INTEGER PRIMARY KEY AUTOINCREMENT,
  at_us INTEGER NOT NULL DEFAULT (CAST((julianday('now') - 2440587.5) * 86400000000 AS INTEGER)),
  flight_id TEXT NOT NULL,
  job_id TEXT,
  kind TEXT NOT NULL,                          -- job, map, file, preview, deleted, restored
  body TEXT NOT NULL                           -- JSON
) STRICT;
INSERT INTO event_of_any_kind SELECT * FROM event;
-- A number once given out is never given out again, even where all events have been pruned.
DELETE FROM sqlite_sequence WHERE name = 'event_of_any_kind';
INSERT INTO sqlite_sequence(name, seq) SELECT 'event_of_any_kind', seq FROM sqlite_sequence WHERE name = 'event';
DROP TABLE event;
ALTER TABLE event_of_any_kind RENAME TO event;
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

CREATE TRIGGER event_to_tell AFTER INSERT ON event
WHEN NEW.kind = 'map'
  OR (NEW.kind = 'job' AND json_extract(NEW.body, '$.state') IN ('successful', 'failed', 'dismissed')) BEGIN
  INSERT INTO webhook_delivery(webhook_id, event_seq, body)
    SELECT id, NEW.seq, json_object('seq', NEW.seq, 'event', NEW.kind, 'flight_id', NEW.flight_id, 'job_id', NEW.job_id,
                                    NEW.kind, json(NEW.body)) FROM webhook;
END;
