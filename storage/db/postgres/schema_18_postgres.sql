-- From a catalogue of version 17 to one of version 18 in PostgreSQL: since when nothing has changed in a flight. Part of a
-- new one too.
CREATE TABLE idle_flight(
  flight_id TEXT COLLATE "C" PRIMARY KEY REFERENCES flight(id) ON DELETE CASCADE,
  seen TEXT COLLATE "C" NOT NULL,  -- digest of what was seen of it, to tell whether it changed
  since_us BIGINT NOT NULL  -- by the AgeClock: it was not in use since, and is as it was then
);
