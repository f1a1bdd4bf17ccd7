-- From a catalogue of version 16 to one of version 17: exports of maps. The outcome is that of schema.sql.
-- Exports of maps that somebody asked for: the file is exports/<id>.<ending> below the flight's folder, once it is made.
CREATE TABLE map_export(
  id TEXT PRIMARY KEY,
  flight_id TEXT NOT NULL REFERENCES flight(id) ON DELETE CASCADE,
  revision INTEGER NOT NULL,                   -- the map that it is of
  request TEXT NOT NULL,                       -- JSON, as it was asked for
  format TEXT NOT NULL,
  owner TEXT NOT NULL DEFAULT '',              -- id of the token that asked for it
  state TEXT NOT NULL CHECK(state IN ('accepted','running','successful','failed')),
  progress REAL NOT NULL DEFAULT 0,
  attempts INTEGER NOT NULL DEFAULT 0,
  lease_until_us INTEGER NOT NULL DEFAULT 0,
  lease_token INTEGER NOT NULL DEFAULT 0,      -- grows with every claim, as that of a job
  bytes INTEGER NOT NULL DEFAULT 0,
  error_code TEXT NOT NULL DEFAULT '',
  error_message TEXT NOT NULL DEFAULT '',
  created_us INTEGER NOT NULL,
  finished_us INTEGER,
  expires_us INTEGER                           -- by the AgeClock; NULL: it waits or runs
) STRICT;
CREATE INDEX map_export_of_flight ON map_export(flight_id, id);
CREATE INDEX map_export_open ON map_export(id) WHERE state IN ('accepted','running');
CREATE INDEX map_export_expiry ON map_export(expires_us);
