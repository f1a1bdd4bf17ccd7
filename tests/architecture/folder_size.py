"""Fails on a source folder with more than 25 files directly in it: a room one cannot take in at a glance. Pictures that
tests compare with do not count."""
import collections
import pathlib
import sys

from tracked_files import tracked_files

ROOT = pathlib.Path(sys.argv[1])
LIMIT = 25
FOLDERS = ["core", "storage", "api", "server", "web/src", "tests"]
PICTURES = {".png", ".jpg", ".webp"}

counts = collections.Counter(str(pathlib.PurePosixPath(name).parent) for name in tracked_files(ROOT, *FOLDERS)
                             if pathlib.PurePosixPath(name).suffix not in PICTURES)
problems = [f"{folder}: {count} files, the limit is {LIMIT}" for folder, count in sorted(counts.items()) if count > LIMIT]
print("\n".join(problems) or "no folder is too full")
sys.exit(1 if problems else 0)
