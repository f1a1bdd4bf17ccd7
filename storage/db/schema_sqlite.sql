-- What of a catalogue SQLite alone has as it stands here: triggers, and the tables of the turns, the events and the age clock.

-- Deleting a photo deletes the whole preview: the remaining photos are drawn anew.
CREATE TRIGGER previewed_file_gone AFTER DELETE ON file WHEN OLD.preview_state = 1 BEGIN
  DELETE FROM preview WHERE flight_id = OLD.flight_id;
  UPDATE file SET preview_state = 0 WHERE flight_id = OLD.flight_id;
END;

CREATE TRIGGER units_end AFTER UPDATE OF state ON job WHEN NEW.state NOT IN ('accepted','running') BEGIN
  DELETE FROM unit WHERE job_id = NEW.id;
END;

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

CREATE TRIGGER token_added AFTER INSERT ON token BEGIN
  UPDATE token_policy SET asks_for_token = 1;
END;
-- The same for a catalogue rebuilt from the flights on disk: a flight with an owner had a token.
CREATE TRIGGER owned_flight_added AFTER INSERT ON flight WHEN NEW.owner <> '' BEGIN
  UPDATE token_policy SET asks_for_token = 1;
END;

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

-- In the transaction of the event itself: a message is queued for every event that happened and for no other.
CREATE TRIGGER event_to_tell AFTER INSERT ON event
WHEN NEW.kind = 'map'
  OR (NEW.kind = 'job' AND json_extract(NEW.body, '$.state') IN ('successful', 'failed', 'dismissed')) BEGIN
  INSERT INTO webhook_delivery(webhook_id, event_seq, body)
    SELECT id, NEW.seq, json_object('seq', NEW.seq, 'event', NEW.kind, 'flight_id', NEW.flight_id, 'job_id', NEW.job_id,
                                    NEW.kind, json(NEW.body)) FROM webhook;
END;

CREATE TRIGGER node_task_to_tell AFTER INSERT ON event
WHEN NEW.kind = 'job' AND json_extract(NEW.body, '$.state') IN ('successful', 'failed', 'dismissed') BEGIN
  INSERT OR IGNORE INTO node_delivery(uuid, job_id)
    SELECT uuid, NEW.job_id FROM node_task WHERE flight_id = NEW.flight_id AND webhook <> '';
END;

-- The time by which uploads and the trash expire (storage/db/age_clock.h): independent of the machine's clock once it runs.
CREATE TABLE age_clock(
  id INTEGER PRIMARY KEY CHECK(id = 1),
  age_us INTEGER NOT NULL,                     -- at `since_boot_us` of the boot `boot_id`
  boot_id TEXT NOT NULL,
  since_boot_us INTEGER NOT NULL
) STRICT;
INSERT INTO age_clock VALUES(1, CAST((julianday('now') - 2440587.5) * 86400000000 AS INTEGER), '', 0);
