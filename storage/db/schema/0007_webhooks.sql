-- Addresses that are told when a job ends or a map is shown, and what they are still to be told.
CREATE TABLE webhook(
  id TEXT PRIMARY KEY,
  url TEXT NOT NULL,
  secret TEXT NOT NULL,                        -- shared with the receiver: what is sent is signed with it
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

-- In the transaction of what happened: nothing is told that did not happen, and nothing that did is left out.
CREATE TRIGGER event_to_tell AFTER INSERT ON event
WHEN NEW.kind = 'map'
  OR (NEW.kind = 'job' AND json_extract(NEW.body, '$.state') IN ('successful', 'failed', 'dismissed')) BEGIN
  INSERT INTO webhook_delivery(webhook_id, event_seq, body)
    SELECT id, NEW.seq, json_object('seq', NEW.seq, 'event', NEW.kind, 'flight_id', NEW.flight_id, 'job_id', NEW.job_id,
                                    NEW.kind, json(NEW.body)) FROM webhook;
END;
