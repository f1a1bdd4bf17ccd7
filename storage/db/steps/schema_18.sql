-- From a catalogue of version 17 to one of version 18: since when nothing has changed in a flight. The outcome is that of
-- schema.sql.
CREATE TABLE idle_flight(
  flight_id TEXT PRIMARY KEY REFERENCES flight(id) ON DELETE CASCADE,
  seen TEXT NOT NULL,                          -- digest of what was seen of it, to tell whether it changed
  since_us INTEGER NOT NULL                    -- by the AgeClock: it was not in use since, and is as it was then
) STRICT;
