-- From a catalogue of version 18 to one of version 19 in PostgreSQL: tags of flights, and which of them are to be kept. Part
-- of a new one too.
ALTER TABLE flight ADD COLUMN tags TEXT COLLATE "C" NOT NULL DEFAULT '';  -- each between line breaks
ALTER TABLE flight ADD COLUMN is_kept BIGINT NOT NULL DEFAULT 0;  -- 1: it never goes to the trash by itself
