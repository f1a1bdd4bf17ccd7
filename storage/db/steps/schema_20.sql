-- From a catalogue of version 19 to one of version 20: since when units wait. The outcome is that of schema.sql.
ALTER TABLE unit ADD COLUMN waiting_us INTEGER NOT NULL DEFAULT 0;
UPDATE unit SET waiting_us = CAST(strftime('%s', 'now') AS INTEGER) * 1000000;
