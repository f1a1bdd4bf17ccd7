-- Resumable uploads (tus): the bytes so far are the file uploads/<id>, of which byte_offset are surely on the disk.
CREATE TABLE upload(
  id TEXT PRIMARY KEY,
  flight_id TEXT NOT NULL REFERENCES flight(id) ON DELETE CASCADE,
  name TEXT NOT NULL,                          -- the file's, as the user named it
  metadata TEXT NOT NULL,                      -- as sent, to be sent back
  length INTEGER,                              -- NULL: not known yet
  byte_offset INTEGER NOT NULL DEFAULT 0,
  is_done INTEGER NOT NULL DEFAULT 0,          -- 1: it is a file of its flight now
  expires_us INTEGER NOT NULL
) STRICT;
CREATE INDEX upload_of_flight ON upload(flight_id);
CREATE INDEX upload_expiry ON upload(expires_us);
