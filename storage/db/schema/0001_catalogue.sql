-- Flights, their files, their finished revisions, and the queue of jobs. Times are microseconds since 1970, UTC.
CREATE TABLE flight(
  id TEXT PRIMARY KEY,
  name TEXT NOT NULL,
  created_us INTEGER NOT NULL,
  options TEXT NOT NULL DEFAULT '{}',          -- JSON, as the user gave it
  active_revision INTEGER,
  next_revision INTEGER NOT NULL DEFAULT 1
) STRICT;

CREATE TABLE file(
  flight_id TEXT NOT NULL REFERENCES flight(id) ON DELETE CASCADE,
  name TEXT NOT NULL,                          -- the user's; never a path
  bytes INTEGER NOT NULL,
  stored_name TEXT NOT NULL UNIQUE,            -- ours; a file in flights/<id>/files
  created_us INTEGER NOT NULL,
  PRIMARY KEY(flight_id, name)
) STRICT;

CREATE TABLE revision(
  flight_id TEXT NOT NULL REFERENCES flight(id) ON DELETE CASCADE,
  revision INTEGER NOT NULL,
  created_us INTEGER NOT NULL,
  west REAL NOT NULL, south REAL NOT NULL, east REAL NOT NULL, north REAL NOT NULL,
  min_zoom INTEGER NOT NULL,
  max_zoom INTEGER NOT NULL,
  gsd_m REAL NOT NULL,
  photos_total INTEGER NOT NULL,
  photos_aligned INTEGER NOT NULL,
  photos_pose_only INTEGER NOT NULL,
  photos_left_out INTEGER NOT NULL,
  PRIMARY KEY(flight_id, revision)
) STRICT;

CREATE TABLE job(
  id TEXT PRIMARY KEY,
  flight_id TEXT NOT NULL REFERENCES flight(id) ON DELETE CASCADE,
  options TEXT NOT NULL DEFAULT '{}',
  state TEXT NOT NULL CHECK(state IN ('accepted','running','successful','failed','dismissed')),
  priority INTEGER NOT NULL DEFAULT 0,
  stage TEXT NOT NULL DEFAULT '',
  progress REAL NOT NULL DEFAULT 0,
  message TEXT NOT NULL DEFAULT '',
  attempts INTEGER NOT NULL DEFAULT 0,
  max_attempts INTEGER NOT NULL DEFAULT 3,
  not_before_us INTEGER NOT NULL DEFAULT 0,
  lease_until_us INTEGER NOT NULL DEFAULT 0,
  lease_token INTEGER NOT NULL DEFAULT 0,      -- grows with every claim: whoever holds an older one has lost
  worker TEXT NOT NULL DEFAULT '',
  cancel INTEGER NOT NULL DEFAULT 0,
  error_code TEXT,
  error_message TEXT,
  created_us INTEGER NOT NULL,
  started_us INTEGER,
  attempt_started_us INTEGER,
  finished_us INTEGER
) STRICT;
CREATE INDEX job_waiting ON job(priority DESC, id) WHERE state = 'accepted';
CREATE INDEX job_leased ON job(lease_until_us) WHERE state = 'running';
CREATE INDEX job_of_flight ON job(flight_id, id);
