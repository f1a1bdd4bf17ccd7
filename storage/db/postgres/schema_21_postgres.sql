-- From a catalogue of version 20 to one of version 21 in PostgreSQL: how true a map is. Part of a new one too.
ALTER TABLE revision ADD COLUMN quality TEXT COLLATE "C" NOT NULL DEFAULT '';  -- JSON, as report.json has it; '' where it is not known
