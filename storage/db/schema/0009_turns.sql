-- Who waits for a worker, so that a claim finds whose turn it is without looking at every job.
CREATE TABLE turn(
  owner TEXT NOT NULL,                         -- of jobs; '' is one too
  priority INTEGER NOT NULL,
  waiting INTEGER NOT NULL,                    -- jobs of this owner and priority in state 'accepted'; never 0
  last_us INTEGER NOT NULL,                    -- when the latest attempt at a job of this owner began; 0: none yet
  first_id TEXT NOT NULL,                      -- the first of the jobs that wait
  PRIMARY KEY(owner, priority)
) STRICT, WITHOUT ROWID;
CREATE INDEX turn_in_order ON turn(priority DESC, last_us, first_id, owner);
CREATE INDEX job_waiting_of_owner ON job(owner, priority, id) WHERE state = 'accepted';
CREATE INDEX job_running_of_owner ON job(owner) WHERE state = 'running';

INSERT INTO turn
  SELECT owner, priority, count(*),
         (SELECT coalesce(max(s.attempt_started_us), 0) FROM job s WHERE s.owner = job.owner), min(id)
  FROM job WHERE state = 'accepted' GROUP BY owner, priority;

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
