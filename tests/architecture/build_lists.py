"""Fails on a source file that no CMakeLists.txt lists (dead code), on globbing, and on unfinished work."""
import pathlib
import re
import sys

ROOT = pathlib.Path(sys.argv[1]).resolve()
FOLDERS = ("core", "storage", "api", "server", "tests")
problems = []
listed = set()  # every source that some CMakeLists.txt names, wherever that file is
for folder in FOLDERS:
    for lists in (ROOT / folder).rglob("CMakeLists.txt"):
        for name in re.findall(r"[\w./-]+\.cc\b", lists.read_text()):
            listed.add((lists.parent / name).resolve())
for folder in FOLDERS:
    for lists in sorted((ROOT / folder).rglob("CMakeLists.txt")):
        if re.search(r"file\s*\(\s*GLOB", lists.read_text(), re.I):
            problems.append(f"{lists.relative_to(ROOT)}: sources are listed, not globbed")
    for path in sorted((ROOT / folder).rglob("*.cc")):
        if path not in listed:
            problems.append(f"{path.relative_to(ROOT)}: no CMakeLists.txt lists it")
    for path in sorted((ROOT / folder).rglob("*")):
        if path.suffix in (".h", ".cc", ".js") and re.search(r"\b(TODO|FIXME|XXX)\b", path.read_text(errors="replace")):
            problems.append(f"{path.relative_to(ROOT)}: unfinished work is marked in it")
print("\n".join(problems) or "every source is built")
sys.exit(1 if problems else 0)
