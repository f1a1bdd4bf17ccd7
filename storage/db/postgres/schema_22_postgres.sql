-- From a catalogue of version 21 to one of version 22 in PostgreSQL: where photos and maps lie, since when units are at work,
-- and which workers stand aside. Part of a new one too.
ALTER TABLE data_dir ADD COLUMN blobs TEXT COLLATE "C" NOT NULL DEFAULT '';  -- 's3://...', 'folder', or '' where none said so yet
ALTER TABLE unit ADD COLUMN since_us BIGINT NOT NULL DEFAULT 0;  -- since when its present worker has it
CREATE TABLE worker_aside(
  worker TEXT COLLATE "C" PRIMARY KEY,  -- as in job and unit
  since_us BIGINT NOT NULL,  -- since its first trouble with nothing done since
  until_us BIGINT NOT NULL,  -- then it tries again
  times BIGINT NOT NULL,  -- that trouble came, one after the other
  code TEXT COLLATE "C" NOT NULL,
  message TEXT COLLATE "C" NOT NULL
);
-- Jobs that waited for their units when their flight went to the trash: nobody would ever end them.
UPDATE job SET state = 'dismissed', finished_us = now_us() WHERE state = 'running' AND worker = 'units' AND cancel = 1;
