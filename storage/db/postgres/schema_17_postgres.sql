-- From a catalogue of version 16 to one of version 17 in PostgreSQL: exports of maps. Part of a new one too.
-- Exports of maps that somebody asked for: the file is exports/<id>.<ending> below the flight's folder, once it is made.
CREATE TABLE map_export(
  id TEXT COLLATE "C" PRIMARY KEY,
  flight_id TEXT COLLATE "C" NOT NULL REFERENCES flight(id) ON DELETE CASCADE,
  revision BIGINT NOT NULL,  -- the map that it is of
  request TEXT COLLATE "C" NOT NULL,  -- JSON, as it was asked for
  format TEXT COLLATE "C" NOT NULL,
  owner TEXT COLLATE "C" NOT NULL DEFAULT '',  -- id of the token that asked for it
  state TEXT COLLATE "C" NOT NULL CHECK(state IN ('accepted','running','successful','failed')),
  progress DOUBLE PRECISION NOT NULL DEFAULT 0,
  attempts BIGINT NOT NULL DEFAULT 0,
  lease_until_us BIGINT NOT NULL DEFAULT 0,
  lease_token BIGINT NOT NULL DEFAULT 0,  -- grows with every claim, as that of a job
  bytes BIGINT NOT NULL DEFAULT 0,
  error_code TEXT COLLATE "C" NOT NULL DEFAULT '',
  error_message TEXT COLLATE "C" NOT NULL DEFAULT '',
  created_us BIGINT NOT NULL,
  finished_us BIGINT,
  expires_us BIGINT  -- by the AgeClock; NULL: it waits or runs
);
CREATE INDEX map_export_of_flight ON map_export(flight_id, id);
CREATE INDEX map_export_open ON map_export(id) WHERE state IN ('accepted','running');
CREATE INDEX map_export_expiry ON map_export(expires_us);
