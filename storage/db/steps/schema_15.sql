-- From a catalogue of version 14 to one of version 15: when the photos of a map were taken; of maps made before it is not
-- known. The outcome is that of schema.sql.
ALTER TABLE revision ADD COLUMN first_capture TEXT NOT NULL DEFAULT '';
ALTER TABLE revision ADD COLUMN last_capture TEXT NOT NULL DEFAULT '';
