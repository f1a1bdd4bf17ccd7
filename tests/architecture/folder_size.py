"""Fails on a source folder with more than 25 files directly in it: a room one cannot take in at a glance. Pictures that
tests compare with do not count."""
import collections
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(sys.argv[1])
LIMIT = 25
FOLDERS = ["core", "storage", "api", "server", "web/src", "tests"]
PICTURES = {".png", ".jpg", ".webp"}

files = subprocess.run(["git", "-C", str(ROOT), "ls-files", "--cached", "--others", "--exclude-standard", *FOLDERS],
                       capture_output=True, text=True, check=True).stdout.splitlines()
counts = collections.Counter(str(pathlib.PurePosixPath(name).parent) for name in files
                             if pathlib.PurePosixPath(name).suffix not in PICTURES and (ROOT / name).exists())
problems = [f"{folder}: {count} files, the limit is {LIMIT}" for folder, count in sorted(counts.items()) if count > LIMIT]
if not counts:
    problems.append("git knows no source files here")
print("\n".join(problems) or "no folder is too full")
sys.exit(1 if problems else 0)
