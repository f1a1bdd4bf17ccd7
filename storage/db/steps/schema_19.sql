-- From a catalogue of version 18 to one of version 19: tags of flights, and which of them are to be kept. The outcome is that
-- of schema.sql.
ALTER TABLE flight ADD COLUMN tags TEXT NOT NULL DEFAULT '';
ALTER TABLE flight ADD COLUMN is_kept INTEGER NOT NULL DEFAULT 0;
