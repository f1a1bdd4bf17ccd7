-- Tasks of the NodeODM-compatible node: each is a flight under the UUID that its clients know.
CREATE TABLE node_task(
  uuid TEXT PRIMARY KEY,
  flight_id TEXT NOT NULL UNIQUE REFERENCES flight(id) ON DELETE CASCADE,
  options TEXT NOT NULL DEFAULT '[]',          -- JSON list of {name, value}, as the client may see it again
  created_ms INTEGER NOT NULL,                 -- the client's date
  is_committed INTEGER NOT NULL DEFAULT 0      -- 0: its files are still coming
) STRICT;

-- What happened, in one order for all flights: written by triggers, so that nothing can happen unseen.
CREATE TABLE event(
  seq INTEGER PRIMARY KEY AUTOINCREMENT,
  at_us INTEGER NOT NULL DEFAULT (CAST((julianday('now') - 2440587.5) * 86400000000 AS INTEGER)),
  flight_id TEXT NOT NULL,
  job_id TEXT,
  kind TEXT NOT NULL CHECK(kind IN ('job','map','file','deleted')),
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

CREATE TRIGGER flight_deleted AFTER DELETE ON flight BEGIN
  DELETE FROM event WHERE flight_id = OLD.id;
  INSERT INTO event(flight_id, kind, body) VALUES(OLD.id, 'deleted', '{}');
END;
