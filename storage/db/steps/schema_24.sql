-- From a catalogue of version 23 to one of version 24: why jobs and exports failed, as a code with its values; of those that
-- failed before there is the message alone. The outcome is that of schema.sql.
ALTER TABLE job ADD COLUMN error_reason TEXT NOT NULL DEFAULT '';
ALTER TABLE map_export ADD COLUMN error_reason TEXT NOT NULL DEFAULT '';
