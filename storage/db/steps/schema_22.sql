-- From a catalogue of version 21 to one of version 22: where photos and maps lie, since when units are at work, and which
-- workers stand aside. The outcome is that of schema.sql.
ALTER TABLE data_dir ADD COLUMN blobs TEXT NOT NULL DEFAULT '';
ALTER TABLE unit ADD COLUMN since_us INTEGER NOT NULL DEFAULT 0;
CREATE TABLE worker_aside(
  worker TEXT PRIMARY KEY,
  since_us INTEGER NOT NULL,
  until_us INTEGER NOT NULL,
  times INTEGER NOT NULL,
  code TEXT NOT NULL,
  message TEXT NOT NULL
) STRICT;
-- Jobs that waited for their units when their flight went to the trash: nobody would ever end them.
UPDATE job SET state = 'dismissed', finished_us = CAST(strftime('%s', 'now') AS INTEGER) * 1000000
  WHERE state = 'running' AND worker = 'units' AND cancel = 1;
