"""Fails on what an unfinished merge left in any file: lists and texts with such lines are read without a word."""
import pathlib
import re
import sys

from tracked_files import tracked_files

ROOT = pathlib.Path(sys.argv[1])
MARK = re.compile(rb"^(?:<{7} |>{7} |={7}$)", re.MULTILINE)

left = []
for name in tracked_files(ROOT):
    found = MARK.search((ROOT / name).read_bytes())
    # A row of equal signs alone may underline a heading.
    if found and (found.group()[:1] != b"=" or re.search(rb"^<{7} ", (ROOT / name).read_bytes(), re.MULTILINE)):
        left.append(f"{name}: {found.group().decode()}")
print("\n".join(left) or "every merge is finished")
sys.exit(1 if left else 0)
