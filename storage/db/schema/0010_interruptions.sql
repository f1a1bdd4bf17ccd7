-- A restart is not an attempt: what ended a claim through no fault of the job's is counted apart.
ALTER TABLE job ADD COLUMN interruptions INTEGER NOT NULL DEFAULT 0;
ALTER TABLE job ADD COLUMN claimed_in TEXT NOT NULL DEFAULT '';  -- the boot its worker was last heard in; '': before the server's start

-- The time by which things grow old enough to be removed (storage/db/age_clock.h). It begins at the newest that is known
-- to have happened, so that a wrong clock on the day of this step ages nothing.
CREATE TABLE age_clock(
  id INTEGER PRIMARY KEY CHECK(id = 1),
  age_us INTEGER NOT NULL,                     -- as it stood at `since_boot_us` of the boot `boot_id`
  boot_id TEXT NOT NULL,
  since_boot_us INTEGER NOT NULL
) STRICT;
INSERT INTO age_clock SELECT 1, coalesce((SELECT max(at_us) FROM event),
  CAST((julianday('now') - 2440587.5) * 86400000000 AS INTEGER)), '', 0;
