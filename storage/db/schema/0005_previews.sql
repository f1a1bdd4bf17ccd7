-- Maps of flights that are still uploading: coarse, by recorded poses, growing photo by photo.
ALTER TABLE file ADD COLUMN preview_state INTEGER NOT NULL DEFAULT 0;  -- 0: to be tried, 1: tried, 2: has no part in it
CREATE INDEX file_to_preview ON file(flight_id) WHERE preview_state = 0;

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

-- A photo that goes takes the whole preview with it: the others are drawn anew.
CREATE TRIGGER previewed_file_gone AFTER DELETE ON file WHEN OLD.preview_state = 1 BEGIN
  DELETE FROM preview WHERE flight_id = OLD.flight_id;
  UPDATE file SET preview_state = 0 WHERE flight_id = OLD.flight_id;
END;

-- Events of a new kind: a CHECK can only be changed by a new table, and the triggers come anew with it.
DROP TRIGGER job_added;
DROP TRIGGER job_moved;
DROP TRIGGER map_shown;
DROP TRIGGER file_added;
DROP TRIGGER flight_deleted;
DROP TRIGGER event_pruned;

CREATE TABLE event_of_more_kinds(
  seq INTEGER PRIMARY KEY AUTOINCREMENT,
  at_us INTEGER NOT NULL DEFAULT (CAST((julianday('now') - 2440587.5) * 86400000000 AS INTEGER)),
  flight_id TEXT NOT NULL,
  job_id TEXT,
  kind TEXT NOT NULL CHECK(kind IN ('job','map','file','preview','deleted')),
  body TEXT NOT NULL                           -- JSON
) STRICT;
INSERT INTO event_of_more_kinds SELECT * FROM event;
-- A number once given out is never given out again, even where all events have been pruned.
DELETE FROM sqlite_sequence WHERE name = 'event_of_more_kinds';
INSERT INTO sqlite_sequence(name, seq) SELECT 'event_of_more_kinds', seq FROM sqlite_sequence WHERE name = 'event';
DROP TABLE event;
ALTER TABLE event_of_more_kinds RENAME TO event;
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

CREATE TRIGGER flight_deleted AFTER DELETE ON flight BEGIN
  DELETE FROM event WHERE flight_id = OLD.id;
  INSERT INTO event(flight_id, kind, body) VALUES(OLD.id, 'deleted', '{}');
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
