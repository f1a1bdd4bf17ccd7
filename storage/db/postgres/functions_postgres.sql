-- What happens by itself in a catalogue in PostgreSQL: the triggers of schema_sqlite.sql, and the claim of a job.

-- Deleting a photo deletes the whole preview: the remaining photos are drawn anew.
CREATE FUNCTION previewed_file_gone() RETURNS TRIGGER LANGUAGE plpgsql AS $$ BEGIN
  DELETE FROM preview WHERE flight_id = OLD.flight_id;
  UPDATE file SET preview_state = 0 WHERE flight_id = OLD.flight_id;
  RETURN NULL;
END $$;
CREATE TRIGGER previewed_file_gone AFTER DELETE ON file FOR EACH ROW WHEN (OLD.preview_state = 1)
  EXECUTE FUNCTION previewed_file_gone();

-- Once there has been a token or a flight with an owner, the server stays closed.
CREATE FUNCTION ask_for_token() RETURNS TRIGGER LANGUAGE plpgsql AS $$ BEGIN
  UPDATE token_policy SET asks_for_token = 1 WHERE asks_for_token = 0;
  RETURN NULL;
END $$;
CREATE TRIGGER token_added AFTER INSERT ON token FOR EACH ROW EXECUTE FUNCTION ask_for_token();
CREATE TRIGGER owned_flight_added AFTER INSERT ON flight FOR EACH ROW WHEN (NEW.owner <> '')
  EXECUTE FUNCTION ask_for_token();

-- A job waits: its owner has a turn, and workers that sleep are woken when the transaction is committed. The row is locked
-- even where nothing in it changes: whoever would remove it has to see this job first (forget_turn).
CREATE FUNCTION job_waits() RETURNS TRIGGER LANGUAGE plpgsql AS $$ BEGIN
  INSERT INTO turn VALUES(NEW.owner, NEW.priority,
    (SELECT coalesce(max(j.attempt_started_us), 0) FROM job j WHERE j.owner = NEW.owner), NEW.id)
    ON CONFLICT(owner, priority) DO UPDATE SET first_id = EXCLUDED.first_id WHERE turn.first_id > EXCLUDED.first_id;
  PERFORM pg_notify(current_schema() || '.jobs', '');
  RETURN NULL;
END $$;
CREATE TRIGGER turn_waits AFTER INSERT ON job FOR EACH ROW WHEN (NEW.state = 'accepted') EXECUTE FUNCTION job_waits();
CREATE TRIGGER turn_waits_again AFTER UPDATE OF state, owner, priority ON job FOR EACH ROW WHEN (NEW.state = 'accepted' AND
    (OLD.state <> 'accepted' OR OLD.owner <> NEW.owner OR OLD.priority <> NEW.priority)) EXECUTE FUNCTION job_waits();

CREATE FUNCTION forget_turn(a_owner TEXT, a_priority BIGINT) RETURNS VOID LANGUAGE plpgsql AS $$ BEGIN
  PERFORM 1 FROM turn t WHERE t.owner = a_owner AND t.priority = a_priority FOR UPDATE SKIP LOCKED;
  IF FOUND THEN
    -- A statement of its own: it sees all that was committed before the lock was had.
    DELETE FROM turn t WHERE t.owner = a_owner AND t.priority = a_priority AND NOT EXISTS(
      SELECT 1 FROM job j WHERE j.state = 'accepted' AND j.owner = a_owner AND j.priority = a_priority);
  END IF;
END $$;

-- The job whose turn it is, claimed: state, lease, token and event in the one transaction of the call. The order is that of
-- storage/jobs/job_turns.h: priority, then the owner with the fewest running jobs, then whose last turn is longest ago, then
-- the job that came first. Rows that another claim has locked are passed over, so that claims wait for nothing but the
-- numbering of an event. The commit does not wait for the disk: a power cut that undoes it leaves the job waiting.
-- No row: nothing may begin. A row of NULLs: leases ran out and are to be settled first (unless `a_settled` says that they
-- were a moment ago).
CREATE FUNCTION claim_job(a_worker TEXT, a_now BIGINT, a_lease_end BIGINT, a_boot TEXT, a_settled BIGINT)
RETURNS TABLE(job_id TEXT, of_flight TEXT, with_options TEXT, token BIGINT, attempt BIGINT) LANGUAGE plpgsql AS $$
DECLARE
  p BIGINT;
  is_alone BOOLEAN;
  passed TEXT[];  -- owners all of whose jobs others are claiming at this moment
  t RECORD;
  n_running BIGINT;
  n_last BIGINT;
  n_first TEXT COLLATE "C";
  best_owner TEXT COLLATE "C";
  best_running BIGINT;
  best_last BIGINT;
  best_first TEXT COLLATE "C";
  chosen TEXT COLLATE "C";
BEGIN
  IF a_settled = 0 AND EXISTS(SELECT 1 FROM job j WHERE j.state = 'running' AND j.lease_until_us < a_now) THEN
    RETURN QUERY SELECT NULL::TEXT, NULL::TEXT, NULL::TEXT, NULL::BIGINT, NULL::BIGINT;
    RETURN;
  END IF;
  SELECT max(turn.priority) INTO p FROM turn;
  WHILE p IS NOT NULL LOOP
    passed := '{}';
    LOOP
      best_owner := NULL;
      SELECT count(*) < 2 INTO is_alone FROM (SELECT 1 FROM turn WHERE turn.priority = p LIMIT 2) AS two;
      FOR t IN SELECT turn.owner, turn.last_us, turn.first_id FROM turn WHERE turn.priority = p
          ORDER BY turn.last_us, turn.first_id LOOP
        -- What stands in `turn` is never later than the truth: nobody from here on can come before.
        EXIT WHEN best_owner IS NOT NULL AND best_running = 0 AND (t.last_us, t.first_id) > (best_last, best_first);
        CONTINUE WHEN t.owner = ANY(passed);
        SELECT j.id INTO n_first FROM job j WHERE j.state = 'accepted' AND j.owner = t.owner AND j.priority = p
          AND j.not_before_us <= a_now ORDER BY j.id LIMIT 1;
        IF NOT FOUND THEN
          PERFORM forget_turn(t.owner, p);
          CONTINUE;
        END IF;
        IF is_alone THEN
          best_owner := t.owner;
          EXIT;
        END IF;
        SELECT count(*) INTO n_running FROM job j WHERE j.state = 'running' AND j.owner = t.owner
          AND j.lease_until_us >= a_now;
        SELECT coalesce(max(j.attempt_started_us), 0) INTO n_last FROM job j WHERE j.owner = t.owner;
        IF best_owner IS NULL OR (n_running, n_last, n_first) < (best_running, best_last, best_first) THEN
          best_owner := t.owner;
          best_running := n_running;
          best_last := n_last;
          best_first := n_first;
        END IF;
      END LOOP;
      EXIT WHEN best_owner IS NULL;
      SELECT j.id INTO chosen FROM job j WHERE j.state = 'accepted' AND j.owner = best_owner AND j.priority = p
        AND j.not_before_us <= a_now ORDER BY j.id LIMIT 1 FOR UPDATE SKIP LOCKED;
      IF FOUND THEN
        RETURN QUERY UPDATE job j SET state = 'running', lease_token = j.lease_token + 1, attempts = j.attempts + 1,
            worker = a_worker, lease_until_us = a_lease_end, started_us = coalesce(j.started_us, a_now),
            attempt_started_us = CASE j.worker WHEN 'units' THEN j.attempt_started_us ELSE a_now END,
            stage = CASE j.worker WHEN 'units' THEN j.stage ELSE '' END,
            progress = CASE j.worker WHEN 'units' THEN j.progress ELSE 0 END, message = '', claimed_in = a_boot
          WHERE j.id = chosen RETURNING j.id, j.flight_id, j.options, j.lease_token, j.attempts;
        IF NOT is_alone THEN
          PERFORM 1 FROM turn WHERE turn.owner = best_owner AND turn.priority = p FOR UPDATE SKIP LOCKED;
          IF FOUND THEN
            UPDATE turn SET last_us = greatest(turn.last_us, a_now), first_id = coalesce((SELECT j.id FROM job j
                WHERE j.state = 'accepted' AND j.owner = best_owner AND j.priority = p ORDER BY j.id LIMIT 1), turn.first_id)
              WHERE turn.owner = best_owner AND turn.priority = p;
          END IF;
        END IF;
        RETURN;
      END IF;
      passed := passed || best_owner;
    END LOOP;
    SELECT max(turn.priority) INTO p FROM turn WHERE turn.priority < p;
  END LOOP;
END $$;

-- Units end with their job, however it ends, and wake workers that sleep.
CREATE FUNCTION units_end() RETURNS TRIGGER LANGUAGE plpgsql AS $$ BEGIN
  DELETE FROM unit WHERE job_id = NEW.id;
  RETURN NULL;
END $$;
CREATE TRIGGER units_end AFTER UPDATE OF state ON job FOR EACH ROW WHEN (NEW.state NOT IN ('accepted','running'))
  EXECUTE FUNCTION units_end();

CREATE FUNCTION unit_waits() RETURNS TRIGGER LANGUAGE plpgsql AS $$ BEGIN
  PERFORM pg_notify(current_schema() || '.jobs', '');
  RETURN NULL;
END $$;
CREATE TRIGGER unit_waits AFTER INSERT ON unit FOR EACH STATEMENT EXECUTE FUNCTION unit_waits();

-- Events are numbered in the order in which they become visible: whoever has read up to a number has missed none below it.
-- The lock is held from here to the end of the transaction; so that this is short, the triggers that write events are
-- deferred to the commit, and the commit waits for the disk only after it has let go (postgres_db.h).
CREATE FUNCTION event_numbered() RETURNS TRIGGER LANGUAGE plpgsql AS $$ BEGIN
  PERFORM pg_advisory_xact_lock(hashtextextended(current_schema() || '.event', 0));
  NEW.seq := nextval('event_seq');
  NEW.at_us := now_us();
  RETURN NEW;
END $$;
CREATE TRIGGER event_numbered BEFORE INSERT ON event FOR EACH ROW EXECUTE FUNCTION event_numbered();

-- Said by every connection that writes, first of all. The last milliseconds before a crash may be lost with the numbers of
-- their events, which somebody may have read: after each start of the server numbers go on far behind them.
CREATE FUNCTION after_start() RETURNS VOID LANGUAGE plpgsql AS $$ BEGIN
  UPDATE catalogue_version SET server_start = pg_postmaster_start_time()
    WHERE server_start IS DISTINCT FROM pg_postmaster_start_time();
  IF FOUND THEN
    PERFORM setval('event_seq', nextval('event_seq') + 5000);
  END IF;
END $$;

CREATE FUNCTION event_pruned() RETURNS TRIGGER LANGUAGE plpgsql AS $$ BEGIN
  DELETE FROM event WHERE seq < NEW.seq - 50000;
  RETURN NULL;
END $$;
CREATE TRIGGER event_pruned AFTER INSERT ON event FOR EACH ROW WHEN (NEW.seq % 1000 = 0)
  EXECUTE FUNCTION event_pruned();

CREATE FUNCTION job_added() RETURNS TRIGGER LANGUAGE plpgsql AS $$ BEGIN
  INSERT INTO event(flight_id, job_id, kind, body) VALUES(NEW.flight_id, NEW.id, 'job',
    format('{"state":%s,"stage":%s,"progress":%s,"attempts":%s}', to_json(NEW.state), to_json(NEW.stage), NEW.progress,
           NEW.attempts));
  RETURN NULL;
END $$;
CREATE CONSTRAINT TRIGGER job_added AFTER INSERT ON job DEFERRABLE INITIALLY DEFERRED FOR EACH ROW
  EXECUTE FUNCTION job_added();

CREATE FUNCTION job_moved() RETURNS TRIGGER LANGUAGE plpgsql AS $$ BEGIN
  INSERT INTO event(flight_id, job_id, kind, body) VALUES(NEW.flight_id, NEW.id, 'job',
    format('{"state":%s,"stage":%s,"progress":%s,"attempts":%s,"error":%s}', to_json(NEW.state), to_json(NEW.stage),
           NEW.progress, NEW.attempts, coalesce(to_json(NEW.error_message)::TEXT, 'null')));
  RETURN NULL;
END $$;
CREATE CONSTRAINT TRIGGER job_moved AFTER UPDATE OF state, stage ON job DEFERRABLE INITIALLY DEFERRED FOR EACH ROW
  WHEN (NEW.state <> OLD.state OR NEW.stage <> OLD.stage) EXECUTE FUNCTION job_moved();

CREATE FUNCTION map_shown() RETURNS TRIGGER LANGUAGE plpgsql AS $$ BEGIN
  INSERT INTO event(flight_id, kind, body)
    SELECT NEW.id, 'map', format('{"revision":%s,"bounds":[%s,%s,%s,%s]}', r.revision, r.west, r.south, r.east, r.north)
    FROM revision r WHERE r.flight_id = NEW.id AND r.revision = NEW.active_revision;
  RETURN NULL;
END $$;
CREATE CONSTRAINT TRIGGER map_shown AFTER UPDATE OF active_revision ON flight DEFERRABLE INITIALLY DEFERRED FOR EACH ROW
  WHEN (NEW.active_revision IS DISTINCT FROM OLD.active_revision) EXECUTE FUNCTION map_shown();

CREATE FUNCTION file_added() RETURNS TRIGGER LANGUAGE plpgsql AS $$ BEGIN
  INSERT INTO event(flight_id, kind, body)
    VALUES(NEW.flight_id, 'file', format('{"name":%s,"bytes":%s}', to_json(NEW.name), NEW.bytes));
  RETURN NULL;
END $$;
CREATE CONSTRAINT TRIGGER file_added AFTER INSERT ON file DEFERRABLE INITIALLY DEFERRED FOR EACH ROW
  EXECUTE FUNCTION file_added();

CREATE FUNCTION flight_moved() RETURNS TRIGGER LANGUAGE plpgsql AS $$ BEGIN
  IF NEW.deleted_us IS NOT NULL THEN
    INSERT INTO event(flight_id, kind, body) VALUES(NEW.id, 'deleted', '{"in_trash":true}');
  ELSE
    INSERT INTO event(flight_id, kind, body) VALUES(NEW.id, 'restored', '{}');
  END IF;
  RETURN NULL;
END $$;
CREATE CONSTRAINT TRIGGER flight_moved AFTER UPDATE OF deleted_us ON flight DEFERRABLE INITIALLY DEFERRED FOR EACH ROW
  WHEN ((NEW.deleted_us IS NULL) <> (OLD.deleted_us IS NULL)) EXECUTE FUNCTION flight_moved();

CREATE FUNCTION flight_deleted() RETURNS TRIGGER LANGUAGE plpgsql AS $$ BEGIN
  DELETE FROM event WHERE flight_id = OLD.id;
  INSERT INTO event(flight_id, kind, body) VALUES(OLD.id, 'deleted', '{"in_trash":false}');
  RETURN NULL;
END $$;
CREATE CONSTRAINT TRIGGER flight_deleted AFTER DELETE ON flight DEFERRABLE INITIALLY DEFERRED FOR EACH ROW
  EXECUTE FUNCTION flight_deleted();

CREATE FUNCTION preview_shown() RETURNS TRIGGER LANGUAGE plpgsql AS $$ BEGIN
  INSERT INTO event(flight_id, kind, body) VALUES(NEW.flight_id, 'preview',
    format('{"edition":%s,"photos":%s,"bounds":[%s,%s,%s,%s],"changed":[%s,%s,%s,%s]}', NEW.edition, NEW.photos,
           NEW.west, NEW.south, NEW.east, NEW.north,
           NEW.changed_west, NEW.changed_south, NEW.changed_east, NEW.changed_north));
  RETURN NULL;
END $$;
CREATE CONSTRAINT TRIGGER preview_begun AFTER INSERT ON preview DEFERRABLE INITIALLY DEFERRED FOR EACH ROW
  EXECUTE FUNCTION preview_shown();
CREATE CONSTRAINT TRIGGER preview_grown AFTER UPDATE OF edition ON preview DEFERRABLE INITIALLY DEFERRED FOR EACH ROW
  EXECUTE FUNCTION preview_shown();

-- In the transaction of the event itself: a message is queued for every event that happened and for no other.
CREATE FUNCTION event_to_tell() RETURNS TRIGGER LANGUAGE plpgsql AS $$ BEGIN
  INSERT INTO webhook_delivery(webhook_id, event_seq, body)
    SELECT id, NEW.seq, format('{"seq":%s,"event":%s,"flight_id":%s,"job_id":%s,%s:%s}', NEW.seq, to_json(NEW.kind),
        to_json(NEW.flight_id), coalesce(to_json(NEW.job_id)::TEXT, 'null'), to_json(NEW.kind), NEW.body) FROM webhook;
  IF NEW.kind = 'job' THEN
    INSERT INTO node_delivery(uuid, job_id)
      SELECT uuid, NEW.job_id FROM node_task WHERE flight_id = NEW.flight_id AND webhook <> '' ON CONFLICT DO NOTHING;
  END IF;
  RETURN NULL;
END $$;
-- The state comes first in a job's event (job_moved).
CREATE TRIGGER event_to_tell AFTER INSERT ON event FOR EACH ROW
  WHEN (NEW.kind = 'map' OR (NEW.kind = 'job' AND NEW.body ~ '^{"state":"(successful|failed|dismissed)"'))
  EXECUTE FUNCTION event_to_tell();
