-- From a catalogue of version 20 to one of version 21: how true a map is; of maps made before it is not known. The outcome
-- is that of schema.sql.
ALTER TABLE revision ADD COLUMN quality TEXT NOT NULL DEFAULT '';
