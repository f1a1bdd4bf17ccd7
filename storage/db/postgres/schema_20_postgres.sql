-- From a catalogue of version 19 to one of version 20 in PostgreSQL: since when units wait. Part of a new one too.
ALTER TABLE unit ADD COLUMN waiting_us BIGINT NOT NULL DEFAULT 0;  -- since when it waits, or last did
UPDATE unit SET waiting_us = now_us();
