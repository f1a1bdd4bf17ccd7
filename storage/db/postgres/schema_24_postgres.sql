-- From a catalogue of version 23 to one of version 24 in PostgreSQL: why jobs and exports failed, as a code with its values.
-- Part of a new one too.
ALTER TABLE job ADD COLUMN error_reason TEXT COLLATE "C" NOT NULL DEFAULT '';  -- JSON of a remark; '': the message alone tells
ALTER TABLE map_export ADD COLUMN error_reason TEXT COLLATE "C" NOT NULL DEFAULT '';  -- as of a job
