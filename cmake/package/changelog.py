"""Writes the changelogs of a Debian package into a folder: Debian's own of this one build, and CHANGELOG.md.

The date is that of SOURCE_DATE_EPOCH, so that the same sources make the same bytes."""
import argparse
import datetime
import email.utils
import gzip
import os
import pathlib
import time

arguments = argparse.ArgumentParser()
for name in ("version", "maintainer", "changes", "out"):
    arguments.add_argument(f"--{name}", required=True)
given = arguments.parse_args()
seconds = int(os.environ.get("SOURCE_DATE_EPOCH", time.time()))
day = email.utils.format_datetime(datetime.datetime.fromtimestamp(seconds, datetime.timezone.utc))
entry = (f"skyquilt ({given.version}-1) bookworm; urgency=medium\n\n"
         "  * Built from the sources of this version; changelog.gz has what changed.\n\n"
         f" -- {given.maintainer}  {day}\n")
out = pathlib.Path(given.out)
out.mkdir(parents=True, exist_ok=True)
(out / "changelog.gz").write_bytes(gzip.compress(pathlib.Path(given.changes).read_bytes(), 9, mtime=0))
(out / "changelog.Debian.gz").write_bytes(gzip.compress(entry.encode(), 9, mtime=0))
